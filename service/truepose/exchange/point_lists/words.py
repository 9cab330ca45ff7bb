"""Lines of a text of points, taken apart: what is a comment, what separates, what a name in quotes is."""

import csv
import re
from collections.abc import Iterator
from typing import Final, NamedTuple

from truepose.exchange.errors import UnreadableFileError

MOST_LINES: Final = 200_000
_COMMENTS: Final = ("//", "#", "!", "%", "*")
_SEPARATORS: Final = ("\t", ";", ",")
_WORD: Final = re.compile(r'"([^"]*)"|\'([^\']*)\'|(\S+)')
_DECIMAL_COMMA: Final = re.compile(r"[+-]?\d+,\d+")


class Line(NamedTuple):
    """What stands in a line that is no comment."""

    number: int  # 1-based
    words: tuple[str, ...]


def lines_of(file: str, data: bytes) -> tuple[list[Line], list[str]]:
    """Return the lines with words, and the comments; raises UnreadableFileError."""
    texts = [(number, line.strip()) for number, line in enumerate(_text(file, data).splitlines(), start=1)]
    if len(texts) > MOST_LINES:
        raise UnreadableFileError(f"it has more than {MOST_LINES:,} lines, the most that is read", file=file)
    said = [line for _, line in texts if line.startswith(_COMMENTS)]
    kept = [(number, line) for number, line in texts if line and not line.startswith(_COMMENTS)]
    if not kept:
        raise UnreadableFileError("there is no point in it", file=file)
    separator = _separator(kept[0][1])
    return [Line(number, tuple(_words(line, separator))) for number, line in kept], said


def _text(file: str, data: bytes) -> str:
    if b"\0" in data:
        raise UnreadableFileError("this is no text; export the points as a text file", file=file)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")  # as programs under Windows write names


def _separator(line: str) -> str | None:
    """Return what separates the words of a file, by its first line; None: blanks."""
    outside_quotes = re.sub(r'"[^"]*"', "", line)
    return next((one for one in _SEPARATORS if one in outside_quotes), None)


def _words(line: str, separator: str | None) -> Iterator[str]:
    if separator is None:
        for match in _WORD.finditer(line):
            yield next(part for part in match.groups() if part is not None)
        return
    (cells,) = csv.reader([line], delimiter=separator, skipinitialspace=True)
    for cell in cells:
        word = cell.strip()
        yield word.replace(",", ".") if separator != "," and _DECIMAL_COMMA.fullmatch(word) else word
