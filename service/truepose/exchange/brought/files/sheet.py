"""A table as somebody brings it: where its header is, where its rows begin, which unit stands where."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

from truepose.exchange.brought.files.text import (
    cells_of,
    decimal_mark,
    decoded,
    lines_of,
    separator_of,
    with_point,
)
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.tables.rows import MOST_COLUMNS, MOST_ROWS

MOST_CELLS: Final = 4_000_000  # a quarter of a gigabyte as words
_COMMENTS: Final = ("#", "//", "%", "!")
_NUMBER: Final = re.compile(r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
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
        It is no text, or there is no table of numbers in it.
    """
    texts = _edited(lines_of(file, decoded(file, data)), edits or {})
    kept = [(number, text) for number, text in enumerate(texts, start=1) if text.strip()]
    separator = separator_of([text for _, text in kept])
    split = [(number, cells_of(text, separator)) for number, text in kept]
    if sum(len(cells) for _, cells in split) > MOST_CELLS or len(split) > MOST_ROWS:
        raise UnreadableFileError("the file has more cells than are read", file=file)
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
                    f"it has more than the {MOST_COLUMNS} columns that are read", file=file
                )
            return at
    raise UnreadableFileError("there is no table of numbers in it", file=file)


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
    names = list(cells)
    if names and names[0].startswith(_COMMENTS):
        names[0] = names[0].lstrip("#/%! ")
        names = names if names[0] or len(names) == width else names[1:]
    while len(names) > width and not names[-1]:
        names.pop()
    return tuple(names) if len(names) == width else None
