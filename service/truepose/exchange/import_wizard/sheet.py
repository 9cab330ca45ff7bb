"""A table of any program: its encoding and separators, where its header is, which unit stands where."""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.tables.rows import LONGEST_LINE, MOST_COLUMNS, MOST_ROWS, read_text

_MOST_LINES: Final = 1_000_000  # with blank ones and notes
_LOOKED_AT: Final = 60  # lines, to see what separates
_BINARY: Final = {
    b"PK\x03\x04": "this is a workbook or an archive, not a table; save the sheet as CSV and import that",
    b"\xd0\xcf\x11\xe0": "this is a workbook in an old format; save the sheet as CSV and import that",
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


def decode_text(file: str, data: bytes) -> str:
    """Return the text of a file; raises UnreadableFileError for what is none."""
    for mark, sentence in _BINARY.items():
        if data.startswith(mark):
            raise UnreadableFileError(sentence, file=file)
    try:
        text = data.decode(_encoding(data))
    except UnicodeDecodeError:
        # Replaced and not refused: what is damaged by it are letters of headings, never digits.
        text = data.decode("cp1252", errors="replace")  # as spreadsheets under Windows write
    if "\0" in text:
        raise UnreadableFileError("this is not text; export the readings as a text file", file=file)
    return text


def _encoding(data: bytes) -> str:
    for mark, encoding in _MARKS:
        if data.startswith(mark):
            return encoding
    # UTF-16 without a mark, as some controllers write it: of Latin letters and digits every second byte is
    # zero.
    head = data[:200]
    if head and head[1::2].count(0) > len(head) // 3:
        return "utf-16-le"
    if head and head[0::2].count(0) > len(head) // 3:
        return "utf-16-be"
    return "utf-8"


def lines_of(file: str, text: str) -> list[str]:
    """Return the lines of a text; raises UnreadableFileError for what nobody could have typed."""
    lines = _LINE_END.split(text, _MOST_LINES)
    if len(lines) > _MOST_LINES:
        raise UnreadableFileError(f"the file has more than {_MOST_LINES:,} lines", file=file)
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
    # At least half of the lines: notes above a table have none of its marks, and may be long.
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
        # `1.234,5`: with a comma as decimal mark, points only set off thousands.
        grouped = _GROUPED.fullmatch(cell)
        cell = cell.replace(grouped[1], "") if grouped else cell
        return cell.replace(",", ".") if _WITH_COMMA.fullmatch(cell) else cell
    return cell


MOST_CELLS: Final = 4_000_000  # a quarter of a gigabyte as words
_COMMENTS: Final = ("#", "//", "%", "!")
_NUMBER: Final = re.compile(r"[+-]?(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?")
_BLANK: Final = frozenset({"", "-", "na", "n/a", "nan", "null", "none"})
_UNIT_CELL: Final = re.compile(
    r"[\[(]?\s*(?:[a-z\u00b5\u03bc\u00b0]{0,4}[a-z\u00b0\u00b2]|-)\s*[\])]?", re.IGNORECASE
)
_FEWEST: Final = 3  # columns of a table of measurements: less is a list or a letter
_MOSTLY: Final = 0.6

Edits = Mapping[int, str | None]  # of lines, by number: what stands there instead; None: it is left out


@dataclass(frozen=True, slots=True)
class Row:
    """A row of numbers, and where it stands."""

    line: int  # 1-based
    cells: tuple[str, ...]  # `.` as decimal mark


@dataclass(frozen=True, slots=True)
class Sheet:
    """A table of a file; every row is as long as the header unless it is torn."""

    name: str
    header: tuple[str, ...]  # what stands above each column; "" where nothing does
    header_line: int | None  # None: there is no header
    rows: tuple[Row, ...]
    separator: str | None  # None: blanks
    decimal: str
    lines: tuple[str, ...]  # the whole text, to be shown around a fault
    above: tuple[str, ...] = ()  # what stands above the header

    def column(self, number: int) -> list[str]:
        """Return the cells of a column (0-based); a torn row has an empty one."""
        return [row.cells[number] if number < len(row.cells) else "" for row in self.rows]


def is_number(cell: str) -> bool:
    """Whether a cell is a number with `.` as its decimal mark."""
    return _NUMBER.fullmatch(cell) is not None


def is_blank(cell: str) -> bool:
    """Whether a cell says nothing."""
    return cell.strip().lower() in _BLANK


def read_sheet(file: str, data: bytes, edits: Edits | None = None) -> Sheet:
    """Read the table of a file of any program.

    Parameters
    ----------
    file : str
        Its name, for sentences.
    data : bytes
    edits : mapping of int to str or None, optional
        Lines that somebody has corrected since.

    Raises
    ------
    UnreadableFileError
        It is no text, or it has no table of numbers.
    """
    texts = _edited(lines_of(file, decode_text(file, data)), edits or {})
    kept = [(number, text) for number, text in enumerate(texts, start=1) if text.strip()]
    separator = separator_of([text for _, text in kept])
    split = list(_split(file, kept, separator))
    mark = decimal_mark([cells for _, cells in split])
    plain = [(number, [with_point(cell, mark) for cell in cells]) for number, cells in split]
    first = _first_row(file, plain)
    header, header_line = _header(plain[:first], len(plain[first][1]))
    rows = tuple(Row(number, tuple(cells)) for number, cells in plain[first:] if not _is_comment(cells))
    above = tuple(text for number, text in kept if number < (header_line or rows[0].line))
    return Sheet(
        name=file,
        header=header or ("",) * len(rows[0].cells),
        header_line=header_line,
        rows=rows,
        separator=separator,
        decimal=mark,
        lines=tuple(texts),
        above=above,
    )


def _split(
    file: str, lines: Sequence[tuple[int, str]], separator: str | None
) -> Iterator[tuple[int, list[str]]]:
    """Yield the cells of lines, counted as they come: of nothing but separators cells are the most."""
    total = 0
    for count, (number, text) in enumerate(lines, start=1):
        cells = cells_of(text, separator)
        total += len(cells)
        if total > MOST_CELLS or count > MOST_ROWS:
            raise UnreadableFileError("the file has too many cells", file=file)
        yield number, cells


def _edited(lines: list[str], edits: Edits) -> list[str]:
    return [(edits[number] or "") if number in edits else text for number, text in enumerate(lines, start=1)]


def _is_comment(cells: Sequence[str]) -> bool:
    return cells[0].startswith(_COMMENTS)


def _numeric(cells: Sequence[str]) -> bool:
    """Whether a line is a row of a table: most of its cells are numbers."""
    given = [cell for cell in cells if not is_blank(cell)]
    return len(given) >= _FEWEST and sum(map(is_number, given)) >= _MOSTLY * len(given)


def _first_row(file: str, lines: Sequence[tuple[int, list[str]]]) -> int:
    for at, (_, cells) in enumerate(lines):
        if _numeric(cells) and not _is_comment(cells):
            if len(cells) > MOST_COLUMNS:
                raise UnreadableFileError(
                    f"it has more than {MOST_COLUMNS} columns, which is the limit", file=file
                )
            return at
    raise UnreadableFileError("it has no table of numbers", file=file)


def _header(above: Sequence[tuple[int, list[str]]], width: int) -> tuple[tuple[str, ...], int | None]:
    """Return the names of the columns, from the one or two lines right above the first row."""
    if not above:
        return (), None
    line, last = above[-1]
    names = _named(last, width)
    if names is None:
        return (), None
    if all(is_blank(cell) or _UNIT_CELL.fullmatch(cell) for cell in names) and len(above) > 1:
        higher, before = above[-2]
        upper = _named(before, width)
        if upper is not None and any(len(cell) > 1 for cell in upper):
            pairs = zip(upper, names, strict=True)
            return tuple(f"{name} [{unit.strip('[]() ')}]" for name, unit in pairs), higher
    return names, line


def _named(cells: Sequence[str], width: int) -> tuple[str, ...] | None:
    """Return the cells as names of columns, None where they are none."""
    # Comment signs before the first heading are how some programs keep others from reading it as data.
    names = list(cells)
    if names and names[0].startswith(_COMMENTS):
        names[0] = names[0].lstrip("#/%! ")
        names = names if names[0] or len(names) == width else names[1:]
    while len(names) > width and not names[-1]:
        names.pop()
    return tuple(names) if len(names) == width else None
