"""Strict reading of a table into columns of numbers, with the place of the first bad cell.

Rows of a CSV text come some thousand at a time. Well-formed columns take a fast path (one regular expression
and one conversion for all of these rows); cells are looked at one by one only where one is blank or bad.
Columns that are arrays already keep to the same rules; NaN and None are their empty cells.
"""

import re
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
import numpy.typing as npt

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.exchange.errors import BadValueError, MissingEntryError, UnreadableFileError, WrongUnitError
from truepose.exchange.quantities import in_other_unit, limits_of, unit, unit_sentence
from truepose.exchange.tables.rows import MOST_ROWS, numbered_rows, parts, read_header

_NUMBER = r"[+-]?(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?"
_ONE_NUMBER = re.compile(_NUMBER)
_ALL_NUMBERS = re.compile(rf"(?:{_NUMBER}\n)++")
_NOT_FINITE = frozenset({"nan", "inf", "infinity", "-inf", "+inf", "-infinity", "-nan"})
_LARGEST_WHOLE = 2.0**53  # beyond it neighbouring whole numbers are the same float
_MOST_LISTED = 20  # numbers that a sentence names
_KINDS_OF_NUMBERS = "fiub"  # of arrays: floats, whole numbers, truth values
Arrays: TypeAlias = Mapping[str, npt.NDArray[np.generic]]  # columns of equal length by name
TableData: TypeAlias = bytes | Arrays  # the text of a file, or what a program has in memory
Cells: TypeAlias = Sequence[str] | npt.NDArray[np.generic]  # of one column
Counted: TypeAlias = Literal["line", "row"]  # lines of a text from 1, rows of arrays from 0


@dataclass(frozen=True, slots=True)
class Rule:
    """What the numbers of a column must be, and the words for it ("must ...")."""

    accepts: Callable[[FloatArray], BoolArray]
    must: str


WHOLE = Rule(lambda v: (v == np.round(v)) & (np.abs(v) < _LARGEST_WHOLE), "must be a whole number")
POSITIVE = Rule(lambda v: v > 0, "must be greater than 0")


def at_least(least: int) -> Rule:
    """Return the rule that numbers are not below `least`."""
    return Rule(lambda v: v >= least, f"must not be below {least}")


def between(least: int, greatest: int) -> Rule:
    """Return the rule that numbers lie in a closed interval."""
    return Rule(lambda v: (v >= least) & (v <= greatest), f"must lie between {least} and {greatest}")


def one_of(numbers: Collection[int], what: str) -> Rule:
    """Return the rule that numbers are among `numbers`, which are `what`."""
    allowed = np.array(sorted(numbers), float)
    first, last = sorted(numbers)[:_MOST_LISTED], sorted(numbers)[_MOST_LISTED:][-1:]
    listed = ", ".join(map(str, [*first, *(["...", *last] if last else [])]))
    known = f": {listed}" if numbers else ", of which there are none"
    return Rule(lambda v: np.isin(v, allowed), f"must be one of {what}{known}")


@dataclass(frozen=True, slots=True)
class Column:
    """A column that the format knows.

    `blank` is what an empty cell stands for (None: an empty cell is refused). With `words` the cells
    hold one of these instead of a number, and the value is its index.
    """

    name: str
    required: bool = True
    rules: tuple[Rule, ...] = ()
    blank: float | None = None
    words: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class Table:
    """The known columns of a table as equal-length arrays; `lines` says where each row stood."""

    file: str
    lines: IntArray
    values: Mapping[str, FloatArray]
    unlisted: tuple[str, ...]  # names of columns that the format does not know
    header_line: int | None  # where the names of the columns stand; None for arrays

    def __contains__(self, name: str) -> bool:
        return name in self.values

    @property
    def counted(self) -> Counted:
        """What `lines` holds."""
        return "row" if self.header_line is None else "line"

    def numbers(self, name: str) -> FloatArray:
        """Return a column that is there, shape (n,)."""
        return self.values[name]

    def whole(self, name: str) -> IntArray:
        """Return a column of whole numbers that is there, shape (n,)."""
        return self.values[name].astype(np.int64)

    def block(self, names: Sequence[str]) -> FloatArray:
        """Return columns that are there side by side, shape (n, len(names))."""
        return np.column_stack([self.values[name] for name in names])

    def optional_numbers(self, name: str) -> FloatArray | None:
        """Return a column, or None where the file has none."""
        return self.values.get(name)

    def optional_whole(self, name: str) -> IntArray | None:
        """Return a column of whole numbers, or None where the file has none."""
        return self.whole(name) if name in self.values else None

    def require(self, good: BoolArray, column: str, sentence: str) -> None:
        """Raise BadValueError at the first row that is not `good` (shape (n,))."""
        if not good.all():
            places = (self.counted, self.lines)
            raise _bad_value(sentence, self.file, places, int(np.argmin(good)), column)


def read_table(
    file: str,
    data: TableData,
    columns: Sequence[Column],
    *,
    together: Sequence[Sequence[str]] = (),
    passed_over: Collection[str] = (),
) -> Table:
    """Read a table, from the text of a CSV file or from arrays.

    Parameters
    ----------
    file : str
        Its name, for error messages.
    data : bytes or mapping of str to ndarray
        UTF-8, with or without byte order mark, any line ends; or columns of shape (n,).
    columns : sequence of Column
        What the format knows; the table has them in any order.
    together : sequence of sequences of str
        Optional columns that come all or not at all.
    passed_over : collection of str
        Known names that do not matter here; neither read nor reported.

    Raises
    ------
    UnreadableFileError, MissingEntryError, WrongUnitError, BadValueError
        With file, line or row, and column of the first fault.
    """
    found = table_parts(file, data, columns, together=together, passed_over=passed_over)
    tables = [part.table for part in found]
    values = {name: np.concatenate([one.values[name] for one in tables]) for name in tables[0].values}
    return replace(tables[0], lines=np.concatenate([one.lines for one in tables]), values=values)


@dataclass(frozen=True, slots=True)
class TablePart:
    """Some rows of a table, and their cells by column as they stood."""

    table: Table
    cells: Mapping[str, Cells]


def table_parts(
    file: str,
    data: TableData,
    columns: Sequence[Column],
    *,
    together: Sequence[Sequence[str]] = (),
    passed_over: Collection[str] = (),
    most_rows: int = MOST_ROWS,
) -> Iterator[TablePart]:
    """Read a table some thousand rows at a time and keep none; arguments and errors as of `read_table`."""
    if not isinstance(data, bytes):
        yield TablePart(_table_of_arrays(file, data, columns, together, passed_over), data)
        return
    numbered = numbered_rows(file, data)
    header_line, header = read_header(file, numbered)
    _check_header(file, header, columns, together, line=header_line)
    wanted = [column for column in columns if column.name in header]
    unlisted = _unlisted(header, columns, passed_over)
    lines = np.zeros(0, np.int64)
    for rows in parts(file, header, numbered, most_rows):
        cells = dict(zip(header, zip(*(row for _, row in rows), strict=True), strict=True))
        lines = np.array([line for line, _ in rows], np.int64)
        values = _convert(file, wanted, header, ("line", lines), cells)
        yield TablePart(Table(file, lines, values, unlisted, header_line), cells)
    if not lines.size:
        raise UnreadableFileError("the file has a header and no rows", file=file)


def _table_of_arrays(
    file: str,
    arrays: Arrays,
    columns: Sequence[Column],
    together: Sequence[Sequence[str]],
    passed_over: Collection[str],
) -> Table:
    header = list(arrays)
    _check_header(file, header, columns, together, line=None)
    wanted = [column for column in columns if column.name in arrays]
    rows = np.arange(max(map(len, arrays.values()), default=0))
    if not rows.size:
        raise UnreadableFileError("the table has no rows", file=file)
    values = _convert(file, wanted, header, ("row", rows), arrays)
    return Table(file, rows, values, _unlisted(header, columns, passed_over), None)


def column_names(file: str, data: TableData) -> tuple[str, ...]:
    """Return the names of the columns: of a CSV text those in its header line."""
    return tuple(read_header(file, numbered_rows(file, data))[1] if isinstance(data, bytes) else data)


def _unlisted(
    header: Sequence[str], columns: Sequence[Column], passed_over: Collection[str]
) -> tuple[str, ...]:
    known = {column.name for column in columns} | set(passed_over)
    return tuple(name for name in header if name and name not in known)


def _check_header(
    file: str,
    header: Sequence[str],
    columns: Sequence[Column],
    together: Sequence[Sequence[str]],
    *,
    line: int | None,
) -> None:
    seen = set(header)
    for column in columns:
        if column.name not in seen:
            _check_absent(file, column, seen, line)
    for group in together:
        absent = [name for name in group if name not in seen]
        if 0 < len(absent) < len(group):
            raise MissingEntryError(
                f"column {absent[0]} is missing; {group[0]} to {group[-1]} must all be given, or none",
                file=file,
                line=line,
            )


def _check_absent(file: str, column: Column, present: set[str], line: int | None) -> None:
    """Refuse an absent column that is required, or that is there in another unit."""
    rival = in_other_unit(column.name, present)
    # An optional column without a unit in its name may be anything; one that names another unit was meant for
    # this.
    if rival is not None and (column.required or unit(rival)):
        raise WrongUnitError(unit_sentence("column", rival, column.name), file=file, line=line)
    if column.required:
        raise MissingEntryError(f"column {column.name} is missing; it is required", file=file, line=line)


def _convert(
    file: str,
    columns: Sequence[Column],
    header: Sequence[str],
    places: tuple[Counted, IntArray],
    cells: Mapping[str, Cells],
) -> dict[str, FloatArray]:
    """Convert every column; raise for the bad cell that a reader of the table meets first."""
    values: dict[str, FloatArray] = {}
    faults: list[tuple[int, int, str]] = []
    for column in columns:
        values[column.name], fault = _numbers(column, cells[column.name])
        if fault is not None:
            faults.append((fault[0], header.index(column.name), fault[1]))
    if faults:
        # As a person reads: from line to line, and in a line from left to right.
        row, position, sentence = min(faults)
        raise _bad_value(sentence, file, places, row, header[position])
    return values


def _bad_value(
    sentence: str, file: str, places: tuple[Counted, IntArray], row: int, column: str
) -> BadValueError:
    counted, numbers = places
    number = int(numbers[row])
    if counted == "line":
        return BadValueError(sentence, file=file, line=number, column=column)
    return BadValueError(sentence, file=file, row=number, column=column)


def _numbers(column: Column, cells: Cells) -> tuple[FloatArray, tuple[int, str] | None]:
    """Return the numbers of a column, and row and sentence of its first fault if it has one."""
    sound = None if column.words else _all_numbers(column, cells)
    if sound is None:
        values, given, fault = _one_by_one(column, _texts(cells))
    else:
        values, given, fault = sound, np.ones(len(cells), bool), None
    for rule in column.rules:
        broken = _first(given & ~rule.accepts(values), cells, rule.must)
        fault = min(filter(None, (fault, broken)), default=None)
    return values, fault


def _texts(cells: Cells) -> list[str]:
    """Return the cells as somebody would type them; those without a value are empty."""
    if not isinstance(cells, np.ndarray):
        return [cell.strip() for cell in cells]
    return ["" if cell is None or cell != cell else str(cell).strip() for cell in cells.tolist()]


def _all_numbers(column: Column, cells: Cells) -> FloatArray | None:
    """Return the numbers of a column in which every cell is a sound one, else None."""
    values = _floats(cells)
    if values is None:
        return None
    # A number that no instrument can have said makes the column unsound as a whole: cell by cell its place is
    # then found.
    limits, size = limits_of(column.name), np.abs(values)
    sound = (size == 0.0) | ((size >= limits.least) & (size <= limits.greatest))
    return values if bool(sound.all()) else None


def _floats(cells: Cells) -> FloatArray | None:
    if isinstance(cells, np.ndarray):
        return cells.astype(float) if cells.dtype.kind in _KINDS_OF_NUMBERS else None
    # The expression is possessive: a bad cell at the end has it fail at once, and not try all cells before it
    # again.
    if not _ALL_NUMBERS.fullmatch("\n".join(cells) + "\n"):
        return None
    try:
        return np.fromiter(map(float, cells), float, len(cells))
    except ValueError:  # a quoted cell of several lines
        return None


def _one_by_one(column: Column, cells: Sequence[str]) -> tuple[FloatArray, BoolArray, tuple[int, str] | None]:
    """Return numbers, whether each was given and sound, and the first fault."""
    values = np.full(len(cells), np.nan if column.blank is None else column.blank)
    given = np.zeros(len(cells), bool)
    fault: tuple[int, str] | None = None
    for row, cell in enumerate(cells):
        if not cell and column.blank is not None:
            continue
        sentence = _fault(column, cell)
        if sentence is None:
            values[row] = column.words.index(cell) if column.words else float(cell)
            given[row] = True
        elif fault is None:
            fault = (row, sentence)
    return values, given, fault


def _fault(column: Column, cell: str) -> str | None:
    """Say what is wrong with a cell, or None."""
    if not cell:
        return f"the cell is empty; {'a word' if column.words else 'a number'} is required"
    if column.words:
        return None if cell in column.words else f"{shown(cell)} must be {' or '.join(column.words)}"
    if cell.lower() in _NOT_FINITE or (is_number(cell) and not np.isfinite(float(cell))):
        return f"{shown(cell)} is not a finite number"
    if is_number(cell):
        limits = limits_of(column.name)
        if limits.accepts(float(cell)):
            return None
        return f"{limits.fault(float(cell), shown(cell))}, or remove the row"
    hint = "; the decimal point is ." if is_number(cell.replace(",", ".")) else ""
    return f"{shown(cell)} is not a number{hint}"


def is_number(cell: str) -> bool:
    """Whether a cell is written as a number with a point, which may still be no finite one."""
    return _ONE_NUMBER.fullmatch(cell) is not None


def _first(bad: BoolArray, cells: Cells, must: str) -> tuple[int, str] | None:
    if not bad.any():
        return None
    row = int(np.argmax(bad))
    return row, f"{shown(str(cells[row]).strip())} {must}"


def shown(cell: str) -> str:
    """Return a cell as a sentence names it, cut where it is long."""
    return repr(cell if len(cell) <= 30 else cell[:27] + "...")
