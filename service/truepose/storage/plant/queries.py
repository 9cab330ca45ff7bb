"""What pages and programs ask a plant for: robots, instruments, results, each by an index."""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from datetime import date
from typing import Any, Final, Literal, TypeAlias, TypeVar

from sqlalchemy import ColumnElement, Connection, Row, ScalarSelect, Table, cast, func, select

from truepose.storage.engine.dialects import TEXT
from truepose.storage.errors import NotFoundError, NotInPlantError
from truepose.storage.plant.records import day_said
from truepose.storage.plant.tables import (
    plant_branches,
    plant_cells,
    plant_days,
    plant_instruments,
    plant_results,
    plant_robots,
)
from truepose.storage.queries import Part, Repository, part_of
from truepose.storage.records import Page

ResultKind: TypeAlias = Literal[
    "campaign", "identification", "diagnosis", "validation", "model", "correction", "report", "closing"
]

_MOST_DAYS: Final = 1000  # rows, newest first
_MADE_LATER: Final = ("report", "closing", "model")  # their day need be none of measuring
_BETWEEN: Final = "\x1f"  # unit separator: in no day and no serial number


@dataclass(frozen=True, slots=True)
class RobotRecord:
    """A robot that some cell measured."""

    id: int
    serial_number: str
    robot: str  # its type
    cell: str  # where it was measured last; empty: nowhere yet
    results: int
    last_measured_on: str  # a day; empty: never


@dataclass(frozen=True, slots=True)
class InstrumentRecord:
    """An instrument that measured in some cell."""

    id: int
    serial_number: str
    results: int
    last_measured_on: str


@dataclass(frozen=True, slots=True)
class LastDay:
    """When something was measured last, or measured itself, and where; empty: never, or nobody said it."""

    cell: str = ""
    measured_on: str = ""
    instrument_serial_number: str = ""


@dataclass(frozen=True, slots=True)
class DayMeasured:
    """How much was measured on one day."""

    cell: str
    measured_on: str
    robot_serial_number: str
    instrument_serial_number: str
    readings: int


@dataclass(frozen=True, slots=True)
class ResultRecord:
    """A campaign, what was made of it, or a report."""

    id: int
    cell: str
    kind: ResultKind
    record_id: int  # its number in the cell
    name: str
    robot: str
    robot_serial_number: str
    instrument_serial_number: str
    measured_on: str
    clock_offset_s: float | None  # of the cell when it was collected
    branch_id: int


Seen = TypeVar("Seen", RobotRecord, InstrumentRecord)
_Told: TypeAlias = Callable[[Row[Any], LastDay], Seen]
_WHOSE: Final = {plant_robots: "robot_serial_number", plant_instruments: "instrument_serial_number"}


class PlantQueries(Repository):
    """All queries about what a plant has seen."""

    async def robots(self, page: Page, upto: date) -> Part[RobotRecord]:
        """Return robots in the order in which they were first seen, each with its last day up to one.

        A later one is told where there is no other: the clock of a cell may have been wrong once.
        """
        return await self._part(plant_robots, page, upto.isoformat(), _robot)

    async def robot(self, serial_number: str, upto: date) -> RobotRecord:
        """Return one robot; raises NotInPlantError."""
        return await self._one(plant_robots, serial_number, upto.isoformat(), _robot)

    async def instruments(self, page: Page, upto: date) -> Part[InstrumentRecord]:
        """Return instruments in the order in which they were first seen."""
        return await self._part(plant_instruments, page, upto.isoformat(), _instrument)

    async def instrument(self, serial_number: str, upto: date) -> InstrumentRecord:
        """Return one instrument; raises NotInPlantError."""
        return await self._one(plant_instruments, serial_number, upto.isoformat(), _instrument)

    async def results(self, kind: ResultKind, page: Page) -> Part[ResultRecord]:
        """Return results of a kind in the order in which they were collected."""
        query, number = results_seen().where(plant_results.c.kind == kind), plant_results.c.id
        return await self._database.read(lambda c: part_of(c, query, number, page, result_seen))

    async def result(self, number: int) -> ResultRecord:
        """Return one result; raises NotFoundError."""
        query = results_seen().where(plant_results.c.id == number)
        row = await self._row(query)
        if row is None:
            raise NotFoundError("result", number)
        return result_seen(row)

    async def life_of_robot(self, serial_number: str, limit: int = 500) -> list[ResultRecord]:
        """Return what was measured and made of a robot, newest day first."""
        return await self._life(plant_results.c.robot_serial_number == serial_number, limit)

    async def life_of_instrument(self, serial_number: str, limit: int = 500) -> list[ResultRecord]:
        """Return what was measured with an instrument, newest day first."""
        return await self._life(plant_results.c.instrument_serial_number == serial_number, limit)

    async def days_of_robot(self, serial_number: str) -> list[DayMeasured]:
        """Return how much was measured of a robot on which of its latest days, oldest first."""
        return await self._days(plant_days.c.robot_serial_number == serial_number)

    async def days_of_instrument(self, serial_number: str) -> list[DayMeasured]:
        """Return how much was measured with an instrument on which of its latest days, oldest first."""
        return await self._days(plant_days.c.instrument_serial_number == serial_number)

    async def _part(self, table: Table, page: Page, upto: str, seen: _Told[Seen]) -> Part[Seen]:
        return await self._database.read(lambda c: _seen_part(c, table, page, upto, seen))

    async def _one(self, table: Table, serial_number: str, upto: str, seen: _Told[Seen]) -> Seen:
        query = _seen(table, upto).where(table.c.serial_number == serial_number)
        found = await self._database.read(lambda c: with_last_days(c, query, upto))
        if not found:
            what = _WHOSE[table].partition("_")[0]
            raise NotInPlantError(f"No {what} {serial_number} was measured in any cell of this plant.")
        return seen(*found[0])

    async def _life(self, condition: ColumnElement[bool], limit: int) -> list[ResultRecord]:
        newest = (plant_results.c.measured_on.desc(), plant_results.c.id.desc())
        query = results_seen().where(condition).order_by(*newest).limit(limit)
        return await self._each(query, result_seen)

    async def _days(self, condition: ColumnElement[bool]) -> list[DayMeasured]:
        query = (
            select(plant_cells.c.name.label("cell"), plant_days)
            .select_from(with_cells(plant_days))
            .where(condition)
            .order_by(plant_days.c.measured_on.desc())
            .limit(_MOST_DAYS)
        )
        return _summed(await self._rows(query))


def _summed(rows: Iterable[Any]) -> list[DayMeasured]:
    """Return days with all their readings: a day of a session may lie in several pages of a chain."""
    readings: Counter[tuple[str, str, str, str]] = Counter()
    for row in rows:
        of = (row.measured_on, row.cell, row.robot_serial_number, row.instrument_serial_number)
        readings[of] += row.readings
    return [
        DayMeasured(cell, day, robot, instrument, count)
        for (day, cell, robot, instrument), count in sorted(readings.items())
    ]


def _seen_part(connection: Connection, table: Table, page: Page, upto: str, seen: _Told[Seen]) -> Part[Seen]:
    cells = cells_of_branches(connection)

    def read(row: Row[Any]) -> Seen:
        return seen(row, _later(row[-2:], cells, upto))

    return part_of(connection, _seen(table, upto), table.c.id, page, read)


def _seen(table: Table, upto: str) -> Any:
    """Return the query for robots or instruments: with how much came of each, and its last day."""
    own = plant_results.c[_WHOSE[table]] == table.c.serial_number
    results = select(func.count()).select_from(plant_results).where(own).scalar_subquery()
    return select(table, results.label("results"), *last_days(table, upto))


def last_days(table: Table, upto: str) -> tuple[ColumnElement[str], ColumnElement[str]]:
    """Return what is on record of the last day of robots or instruments up to a day, else of any.

    Of readings, and of what was made of them: what `with_last_days` reads.
    """
    measured = plant_results.c.kind.not_in(_MADE_LATER)
    return _last(table, plant_days, upto), _last(table, plant_results, upto, measured)


def _last(table: Table, measured: Table, upto: str, *conditions: ColumnElement[bool]) -> ColumnElement[str]:
    own = (measured.c[_WHOSE[table]] == table.c.serial_number, *conditions)
    # Two comparisons and not BETWEEN: PostgreSQL takes no collation between its bounds (commit 5c28ad6c).
    counting = (measured.c.measured_on > "") & (measured.c.measured_on <= upto)
    return func.coalesce(_newest(measured, counting, *own), _newest(measured, *own))


def _newest(table: Table, *conditions: ColumnElement[bool]) -> ScalarSelect[str]:
    """Return branch, day and instrument of the newest day, in one text: it is sought once."""
    told = (cast(table.c.branch_id, TEXT), table.c.measured_on, table.c.instrument_serial_number)
    # As three columns it would be sought three times: six look-ups a robot on the first page became two
    # (commit d6e52cb4).
    query = select(told[0] + _BETWEEN + told[1] + _BETWEEN + told[2]).where(*conditions)
    return query.order_by(table.c.measured_on.desc(), table.c.id.desc()).limit(1).scalar_subquery()


def with_last_days(connection: Connection, query: Any, upto: str) -> list[tuple[Row[Any], LastDay]]:
    """Return rows that end with `last_days`, each with the later of them: one up to a day before others."""
    rows = connection.execute(query).all()
    # After the rows: a branch that is added in between is known then.
    cells = cells_of_branches(connection)
    return [(row, _later(row[-2:], cells, upto)) for row in rows]


def _later(told: Iterable[str | None], cells: Mapping[int, str], upto: str) -> LastDay:
    each = (_read(one, cells) for one in told if one is not None)
    return max(each, key=lambda one: ("" < one.measured_on <= upto, one.measured_on), default=LastDay())


def _read(told: str, cells: Mapping[int, str]) -> LastDay:
    branch, day, instrument = told.split(_BETWEEN, 2)
    return LastDay(cells[int(branch)], day, instrument)


def cells_of_branches(connection: Connection) -> dict[int, str]:
    """Return the cell of each branch."""
    of_cell = plant_branches.c.cell_id == plant_cells.c.id
    query = select(plant_branches.c.id, plant_cells.c.name).join(plant_cells, of_cell)
    return dict(tuple(row) for row in connection.execute(query))


def with_cells(table: Table) -> Any:
    """Return a table whose rows are of a branch, with its branch and cell."""
    of_branch = table.join(plant_branches, plant_branches.c.id == table.c.branch_id)
    return of_branch.join(plant_cells, plant_cells.c.id == plant_branches.c.cell_id)


def results_seen() -> Any:
    """Return the query for all results."""
    cell = plant_cells.c.name.label("cell")
    return select(plant_results, cell).select_from(with_cells(plant_results))


def _robot(row: Row[Any], last: LastDay) -> RobotRecord:
    return RobotRecord(row.id, row.serial_number, row.robot, last.cell, row.results, last.measured_on)


def _instrument(row: Row[Any], last: LastDay) -> InstrumentRecord:
    return InstrumentRecord(row.id, row.serial_number, row.results, last.measured_on)


def result_seen(row: Row[Any]) -> ResultRecord:
    """Return a result as it was read."""
    seen = {name: getattr(row, name) for name in ResultRecord.__dataclass_fields__}
    return ResultRecord(**{**seen, "measured_on": day_said(row.measured_on)})


def last_before(connection: Connection, table: Table, since: str) -> int:
    """Return the last row that was there before; sought from the newest one: old rows cost nothing."""
    query = select(table.c.id).where(table.c.recorded_at < since).order_by(table.c.id.desc()).limit(1)
    return connection.scalar(query) or 0
