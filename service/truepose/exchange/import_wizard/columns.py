"""A table in the columns and units of the file format, each row with the place where it stood."""

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from truepose.exchange.errors import BadValueError, UnreadableFileError
from truepose.exchange.import_wizard.headings import LABELS, NOTHING, ColumnMeaning
from truepose.exchange.import_wizard.sheet import Sheet, is_blank, is_number

_SIGNS: Final = {"+": 1.0, "-": -1.0, "pos": 1.0, "neg": -1.0, "positive": 1.0, "negative": -1.0}
_CLOCK: Final = re.compile(r"(\d{1,2}):(\d{2})(?::(\d{2}(?:\.\d+)?))?")
_DAY_S: Final = 86_400.0
_NUMBER_AT_END: Final = re.compile(r"(.*?)(\d{1,9})")
Cells = npt.NDArray[Any]  # floats; or objects where a cell is no number, which then is there as it stood


class ImportedValueError(BadValueError):
    """A value of a reading cannot be meant; `point` says which point of its row it is of."""

    def __init__(self, sentence: str, place: "Place", column: str | None) -> None:
        super().__init__(sentence, file=place.file, line=place.line, column=column)
        self.point = place.point


@dataclass(frozen=True, slots=True)
class Place:
    """Where a reading stands."""

    file: str
    line: int
    point: int = 0  # which point of its row


@dataclass(frozen=True, slots=True)
class ImportedTable:
    """Readings in columns of the file format."""

    columns: Mapping[str, Cells]
    places: tuple[Place, ...]

    def __len__(self) -> int:
        return len(self.places)


def in_format(sheet: Sheet, meanings: Sequence[ColumnMeaning]) -> ImportedTable:
    """Return a table with one row a reading; raises UnreadableFileError at a torn row."""
    _require_whole(sheet)
    points = sorted({one.point for one in meanings if one.point}) or [0]
    parts = [_of_point(sheet, meanings, point) for point in points]
    names = dict.fromkeys(name for part in parts for name in part)
    order = _row_by_row(len(sheet.rows), len(points))
    columns = {name: np.concatenate([part[name] for part in parts if name in part])[order] for name in names}
    if points != [0]:
        columns["nest"] = np.tile(np.array(points, float), len(sheet.rows))
    return ImportedTable(
        columns,
        tuple(Place(sheet.name, row.line, point) for row in sheet.rows for point in points),
    )


def _row_by_row(rows: int, points: int) -> npt.NDArray[np.int64]:
    return np.arange(rows * points).reshape(points, rows).T.reshape(-1)


def _require_whole(sheet: Sheet) -> None:
    width = len(sheet.header)
    for row in sheet.rows:
        if len(row.cells) != width and any(row.cells[width:] or ("torn",)):
            raise UnreadableFileError(
                f"{len(row.cells)} cells found where the table has {width} columns",
                file=sheet.name,
                line=row.line,
            )


def _of_point(sheet: Sheet, meanings: Sequence[ColumnMeaning], point: int) -> dict[str, Cells]:
    found: dict[str, Cells] = {}
    for at, meaning in enumerate(meanings):
        if meaning.quantity != NOTHING and meaning.point in {0, point}:
            if meaning.column in found:
                raise BadValueError(
                    "two columns are assigned to this quantity; keep one of them and ignore the other",
                    file=sheet.name,
                    line=sheet.header_line,
                    column=meaning.column,
                )
            found[meaning.column] = _column(sheet, at, meaning)
    return found


def _column(sheet: Sheet, at: int, meaning: ColumnMeaning) -> Cells:
    cells = sheet.column(at)
    if meaning.quantity == "time":
        cells = _seconds(cells)
    if meaning.quantity == "direction":
        cells = [str(_SIGNS.get(cell.lower(), cell)) for cell in cells]
    if meaning.quantity in LABELS and not all(is_number(cell) or is_blank(cell) for cell in cells):
        return _numbered(cells)
    converted = [_value(cell, meaning) for cell in cells]
    sound = all(isinstance(value, float) for value in converted)
    return np.array(converted, dtype=float if sound else object)


def _value(cell: str, meaning: ColumnMeaning) -> float | str:
    """Return the number of a cell in the format's unit; NaN for an empty one; what is none as it is."""
    if is_number(cell):
        return meaning.converted(float(cell))
    return float("nan") if is_blank(cell) else cell


def _numbered(cells: Sequence[str]) -> Cells:
    """Return labels as numbers: those at their ends, else from 1 in the order of their first appearance."""
    labels = list(dict.fromkeys(cells))
    # `SMR 2` is nest 2 and not the second label that happens to come, but only where all labels are told
    # apart by their numbers.
    ends = [_NUMBER_AT_END.fullmatch(label) for label in labels]
    own = [int(end[2]) for end in ends if end is not None and end[1] == (ends[0] or end)[1]]
    kept = own if len(set(own)) == len(labels) else range(1, len(labels) + 1)
    numbers = dict(zip(labels, map(float, kept), strict=True))
    return np.array([numbers[cell] for cell in cells])


def labels_of(sheet: Sheet, at: int) -> tuple[str, ...]:
    """Return the labels of a column that are no numbers, in the order of the numbers they are given."""
    cells = sheet.column(at)
    return () if all(is_number(cell) or is_blank(cell) for cell in cells) else tuple(dict.fromkeys(cells))


def _seconds(cells: Sequence[str]) -> list[str]:
    """Return moments of a clock or a calendar as seconds since the first one."""
    moments = _without_midnights([_moment(cell) for cell in cells], cells)
    first = next((moment for moment in moments if moment is not None), None)
    if first is None:
        return list(cells)
    return [
        cell if moment is None else repr(moment - first) for cell, moment in zip(cells, moments, strict=True)
    ]


def _without_midnights(moments: Sequence[float | None], cells: Sequence[str]) -> list[float | None]:
    """Return moments of a clock that goes on behind midnight; readings may stand a little out of order."""
    found: list[float | None] = []
    days, before = 0, None
    for moment, cell in zip(moments, cells, strict=True):
        clock = None if moment is None or _CLOCK.fullmatch(cell) is None else moment
        if clock is not None and before is not None and abs(clock - before) > _DAY_S / 2:
            days += 1 if clock < before else -1
        before = before if clock is None else clock
        found.append(moment if clock is None else clock + days * _DAY_S)
    return found


def _moment(cell: str) -> float | None:
    """Return a moment [s]; None where a cell is none."""
    clock = _CLOCK.fullmatch(cell)
    if clock is not None:
        return 3600.0 * float(clock[1]) + 60.0 * float(clock[2]) + float(clock[3] or 0.0)
    if ":" not in cell and cell.count("-") != 2:
        return None
    try:
        moment = datetime.fromisoformat(cell)
    except ValueError:
        return None
    # Where the service stands says nothing of where the cell stands; and a zone of its own could put its
    # clock back during the readings.
    return (moment if moment.tzinfo else moment.replace(tzinfo=UTC)).timestamp()


def join_readings(parts: Sequence[ImportedTable]) -> ImportedTable:
    """Return readings of several tables as one; a column that one of them lacks is empty there."""
    names = dict.fromkeys(name for part in parts for name in part.columns)
    columns = {
        name: np.concatenate([part.columns.get(name, np.full(len(part), np.nan)) for part in parts])
        for name in names
    }
    return ImportedTable(columns, tuple(place for part in parts for place in part.places))
