"""The text of a file of any program: its encoding, what separates its cells, its decimal mark."""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Sequence
from typing import Final

from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.tables.texts import read_text

LONGEST_LINE: Final = 2**16
_LOOKED_AT: Final = 60  # lines, to see what separates
_BINARY: Final = {
    b"PK\x03\x04": "this is a workbook or an archive, not a table; save the sheet as CSV and bring that",
    b"\xd0\xcf\x11\xe0": "this is a workbook of an old spreadsheet; save the sheet as CSV and bring that",
    b"%PDF": "this is a PDF; export the readings as a text file",
}
_MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
_SEPARATORS: Final = ("\t", ";", ",", "|")
_WITH_COMMA: Final = re.compile(r"[+-]?\d+,\d+(?:[eE][+-]?\d+)?")
_WITH_POINT: Final = re.compile(r"[+-]?\d*\.\d+(?:[eE][+-]?\d+)?")
_GROUPED: Final = re.compile(r"[+-]?\d{1,3}(?:([.' \u00a0\u202f])\d{3})(?:\1\d{3})*,\d+")
_QUOTED: Final = re.compile(r'"[^"]*"')
_LINE_END: Final = re.compile(r"\r\n|\r|\n")


def decoded(file: str, data: bytes) -> str:
    """Return the text of a file; raises UnreadableFileError for what is none."""
    for mark, sentence in _BINARY.items():
        if data.startswith(mark):
            raise UnreadableFileError(sentence, file=file)
    try:
        text = data.decode(_encoding(data))
    except UnicodeDecodeError:
        text = data.decode("cp1252", errors="replace")  # as spreadsheets under Windows write
    if "\0" in text:
        raise UnreadableFileError("this is no text; export the readings as a text file", file=file)
    return text


def _encoding(data: bytes) -> str:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return encoding
    head = data[:200]
    if head and head[1::2].count(0) > len(head) // 3:
        return "utf-16-le"
    if head and head[0::2].count(0) > len(head) // 3:
        return "utf-16-be"
    return "utf-8"


def lines_of(file: str, text: str) -> list[str]:
    """Return the lines of a text; raises UnreadableFileError for one that nobody could have typed."""
    lines = _LINE_END.split(text)
    for number, line in enumerate(lines, start=1):
        if len(line) > LONGEST_LINE:
            raise UnreadableFileError(
                f"the line has more than {LONGEST_LINE:,} characters", file=file, line=number
            )
    return lines


def separator_of(lines: Sequence[str]) -> str | None:
    """Return what separates the cells; None: blanks.

    That which most lines have equally often; a comma only where nothing else is: it may be a decimal mark.
    """
    bare = [_QUOTED.sub("", line) for line in lines if line.strip()][:_LOOKED_AT]
    found = {mark: _steadiness([line.count(mark) for line in bare]) for mark in _SEPARATORS}
    strong = [mark for mark in ("\t", ";", "|") if found[mark] >= max(2, len(bare) // 2)]
    if strong:
        return max(strong, key=lambda mark: found[mark])
    return "," if found[","] >= max(1, len(bare) // 2) and not _only_decimal(bare) else None


def _steadiness(counts: Sequence[int]) -> int:
    """Return how many lines have the commonest number of a mark, if it is not none."""
    most = Counter(count for count in counts if count).most_common(1)
    return most[0][1] if most else 0


def _only_decimal(lines: Sequence[str]) -> bool:
    """Whether commas stand in numbers only, and blanks between them."""
    words = [word for line in lines for word in line.split() if "," in word]
    return bool(words) and all(_WITH_COMMA.fullmatch(word) for word in words)


def cells_of(line: str, separator: str | None) -> list[str]:
    """Return the cells of a line; a text that an export of ours keeps from being a formula as it was."""
    if separator is None:
        return line.split()
    return [read_text(cell.strip()) for cell in next(csv.reader([line], delimiter=separator), [])]


def decimal_mark(rows: Sequence[Sequence[str]]) -> str:
    """Return the decimal mark of the cells: a comma where more cells have one than have a point."""
    shown = [cell for row in rows[:_LOOKED_AT] for cell in row]
    commas = sum(_WITH_COMMA.fullmatch(cell) is not None for cell in shown)
    points = sum(_WITH_POINT.fullmatch(cell) is not None for cell in shown)
    return "," if commas > points else "."


def with_point(cell: str, mark: str) -> str:
    """Return a cell with `.` as its decimal mark, if it is a number with another one."""
    if mark == ",":
        grouped = _GROUPED.fullmatch(cell)
        cell = cell.replace(grouped[1], "") if grouped else cell
        return cell.replace(",", ".") if _WITH_COMMA.fullmatch(cell) else cell
    return cell
