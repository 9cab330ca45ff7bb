"""The text of a program, byte for byte, and the place of anything in it.

A program is read as Latin-1, in which every byte is one character: places in the text are places in the
file, whatever its encoding. Names are shown as UTF-8 where they are that.
"""

import bisect
import re
from collections.abc import Mapping
from itertools import accumulate
from typing import Final, NoReturn

from truepose.domain.results.corrections import place
from truepose.domain.sentences import Sentence
from truepose.exchange.errors import BadValueError, InputFileError, UnreadableFileError
from truepose.exchange.plausible import limits_of
from truepose.exchange.programs.program import Number

_LIMITS: Final = limits_of("number")
_LINE_END: Final = re.compile(r"\r\n|\n|\r")
_WIDE: Final = (b"\xff\xfe", b"\xfe\xff")
_MARK: Final = b"\xef\xbb\xbf"  # that a text is UTF-8


class Source:
    """A program as text, and behind it other files that belong to it.

    Parameters
    ----------
    data : bytes
        The file.
    name : str
        Of the file, for error messages.
    beside : mapping of str to bytes, optional
        Other files of the same program by name; lines are counted on through all of them.

    Raises
    ------
    UnreadableFileError
        A file is no text of one byte a character.
    """

    def __init__(self, data: bytes, name: str, beside: Mapping[str, bytes] | None = None) -> None:
        self.data = data
        self.name = name
        files = {name: data, **(beside or {})}
        for file, content in files.items():
            _require_text(file, content)
        parts = [data, *(content.removeprefix(_MARK) for content in list(files.values())[1:])]
        self._bytes = b"\n".join(parts)
        self.text = self._bytes.decode("latin-1")
        self._lines = [0, *(end.end() for end in _LINE_END.finditer(self.text))]
        begins = accumulate((len(part) + 1 for part in parts[:-1]), initial=0)
        self._begins = [(self.line(begin), file) for begin, file in zip(begins, files, strict=True)]

    @property
    def start(self) -> int:
        """Where the text begins, behind a byte order mark."""
        return len(_MARK) if self.data.startswith(_MARK) else 0

    @property
    def n_lines(self) -> int:
        """Lines of the text; behind the last line end stands one more, which is empty."""
        return len(self._lines)

    def line(self, at: int) -> int:
        """Return the 1-based line of a place, counted on through the files beside."""
        return bisect.bisect_right(self._lines, at)

    def file_and_line(self, line: int) -> tuple[str, int]:
        """Return the file of a line, and its number there."""
        begin, file = next(entry for entry in reversed(self._begins) if entry[0] <= line)
        return file, line - begin + 1

    def is_own(self, line: int) -> bool:
        """Whether a line is of the program itself, not of a file beside."""
        return len(self._begins) == 1 or line < self._begins[1][0]

    def said(self, line: int) -> str:
        """Return how the name of a frame tells its line."""
        file, number = self.file_and_line(line)
        return f"line {number}" if self.is_own(line) else f"line {number} of {file}"

    def place(self, line: int) -> Sentence:
        """Return how a sentence names a line."""
        file, number = self.file_and_line(line)
        return place(number, None if self.is_own(line) else file)

    def line_span(self, line: int) -> tuple[int, int]:
        """Return where a 1-based line begins and where it ends, before its line end."""
        start = self._lines[line - 1]
        end = self._lines[line] if line < len(self._lines) else len(self.text)
        return start, start + len(self.text[start:end].rstrip("\r\n"))

    def shown(self, start: int, end: int) -> str:
        """Return a piece of the text as a person reads it, on one line."""
        piece = self._bytes[start:end]
        try:
            text = piece.decode("utf-8")
        except UnicodeDecodeError:
            text = piece.decode("latin-1")
        return " ".join(text.split())

    def number(self, start: int, end: int) -> Number:
        """Return the number that is written between two places; refuses one that none can be."""
        written = "".join(self.text[start:end].split())  # a sign may stand apart
        value = float(written)
        if not _LIMITS.accepts(value):
            self.refuse(_LIMITS.fault(value, written), start)
        digits, _, exponent = written.lower().partition("e")
        _, _, places = digits.partition(".")
        return Number(start, end, value, max(len(places) - int(exponent or 0), 0))

    def fail(self, sentence: str, at: int, kind: type[InputFileError] = UnreadableFileError) -> NoReturn:
        """Raise `kind` at a place."""
        line = self.line(at)
        file, number = self.file_and_line(line)
        raise kind(sentence, file=file, line=number, column=str(at - self._lines[line - 1] + 1))

    def refuse(self, sentence: str, at: int) -> NoReturn:
        """Raise BadValueError at a place."""
        self.fail(sentence, at, BadValueError)


def _require_text(file: str, data: bytes) -> None:
    if data.startswith(_WIDE):
        sentence = "the text is UTF-16; save the file as UTF-8 or in the encoding of the controller"
    elif b"\0" in data:
        sentence = "this is a binary file; the program as text is required"
    elif not data.strip():
        sentence = "the file is empty; a program is required"
    else:
        return
    raise UnreadableFileError(sentence, file=file)
