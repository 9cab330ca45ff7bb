"""What pages and programs ask a plant for: robots, instruments, results, each by an index."""

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Final, Literal, TypeAlias

from sqlalchemy import Column, ColumnElement, Connection, Row, ScalarSelect, Table, func, select

from truepose.storage.database import Database
from truepose.storage.errors import NotFoundError, NotInPlantError
from truepose.storage.parts import Part
from truepose.storage.records import Page
from truepose.storage.tables.of_plants import (
    plant_branches,
    plant_cells,
    plant_days,
    plant_instruments,
    plant_results,
    plant_robots,
)

ResultKind: TypeAlias = Literal[
    "campaign", "identification", "diagnosis", "validation", "model", "correction", "report", "closing"
]

_MOST_DAYS: Final = 1000  # rows, newest first


@dataclass(frozen=True, slots=True)
class SeenRobot:
    """A robot that some cell measured."""

    id: int
    serial_number: str
    robot: str  # its type
    cell: str  # where it was measured last; empty: nothing came of it yet
    results: int
    last_measured_on: str  # a day; empty: never


@dataclass(frozen=True, slots=True)
class SeenInstrument:
    """An instrument that measured in some cell."""

    id: int
    serial_number: str
    results: int
    last_measured_on: str


@dataclass(frozen=True, slots=True)
class DayMeasured:
    """How much was measured on one day."""

    cell: str
    measured_on: str
    robot_serial_number: str
    instrument_serial_number: str
    readings: int


@dataclass(frozen=True, slots=True)
class ResultSeen:
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


class PlantLooks:
    """All queries about what a plant has seen."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def robots(self, page: Page) -> Part[SeenRobot]:
        """Return robots in the order in which they were first seen."""
        return await self._database.read(lambda c: _part(c, plant_robots, _robots(), page, _robot))

    async def robot(self, serial_number: str) -> SeenRobot:
        """Return one robot; raises NotInPlantError."""
        query = _robots().where(plant_robots.c.serial_number == serial_number)
        return _robot(await self._one(query, "robot", serial_number))

    async def instruments(self, page: Page) -> Part[SeenInstrument]:
        """Return instruments in the order in which they were first seen."""
        return await self._database.read(
            lambda c: _part(c, plant_instruments, _instruments(), page, _instrument)
        )

    async def instrument(self, serial_number: str) -> SeenInstrument:
        """Return one instrument; raises NotInPlantError."""
        query = _instruments().where(plant_instruments.c.serial_number == serial_number)
        return _instrument(await self._one(query, "instrument", serial_number))

    async def results(self, kind: ResultKind, page: Page) -> Part[ResultSeen]:
        """Return results of a kind in the order in which they were collected."""
        of_kind = plant_results.c.kind == kind
        return await self._database.read(lambda c: _results_part(c, of_kind, page))

    async def result(self, number: int) -> ResultSeen:
        """Return one result; raises NotFoundError."""
        query = results_seen().where(plant_results.c.id == number)
        row = await self._database.read(lambda connection: connection.execute(query).one_or_none())
        if row is None:
            raise NotFoundError("result", number)
        return result_seen(row)

    async def life_of_robot(self, serial_number: str, limit: int = 500) -> list[ResultSeen]:
        """Return what was measured and made of a robot, newest day first."""
        return await self._life(plant_results.c.robot_serial_number == serial_number, limit)

    async def life_of_instrument(self, serial_number: str, limit: int = 500) -> list[ResultSeen]:
        """Return what was measured with an instrument, newest day first."""
        return await self._life(plant_results.c.instrument_serial_number == serial_number, limit)

    async def days_of_robot(self, serial_number: str) -> list[DayMeasured]:
        """Return how much was measured of a robot on which of its latest days, oldest first."""
        return await self._days(plant_days.c.robot_serial_number == serial_number)

    async def days_of_instrument(self, serial_number: str) -> list[DayMeasured]:
        """Return how much was measured with an instrument on which of its latest days, oldest first."""
        return await self._days(plant_days.c.instrument_serial_number == serial_number)

    async def _one(self, query: Any, what: str, serial_number: str) -> Row[Any]:
        row = await self._database.read(lambda connection: connection.execute(query).one_or_none())
        if row is None:
            raise NotInPlantError(f"No {what} {serial_number} was measured in any cell of this plant.")
        return row

    async def _life(self, condition: ColumnElement[bool], limit: int) -> list[ResultSeen]:
        newest = (plant_results.c.measured_on.desc(), plant_results.c.id.desc())
        query = results_seen().where(condition).order_by(*newest).limit(limit)
        return await self._database.read(lambda c: [result_seen(row) for row in c.execute(query)])

    async def _days(self, condition: ColumnElement[bool]) -> list[DayMeasured]:
        columns = (
            plant_cells.c.name,
            plant_days.c.measured_on,
            plant_days.c.robot_serial_number,
            plant_days.c.instrument_serial_number,
            plant_days.c.readings,
        )
        query = (
            select(*columns)
            .join(plant_branches, plant_branches.c.id == plant_days.c.branch_id)
            .join(plant_cells, plant_cells.c.id == plant_branches.c.cell_id)
            .where(condition)
            .order_by(plant_days.c.measured_on.desc())
            .limit(_MOST_DAYS)
        )
        rows = await self._database.read(lambda connection: connection.execute(query).all())
        return _summed(rows)


def _summed(rows: Iterable[Any]) -> list[DayMeasured]:
    """Return days with all their readings: a day of a session may lie in several pages of a chain."""
    readings: Counter[tuple[str, str, str, str]] = Counter()
    for cell, day, robot, instrument, count in rows:
        readings[day, cell, robot, instrument] += count
    return [
        DayMeasured(cell, day, robot, instrument, count)
        for (day, cell, robot, instrument), count in sorted(readings.items())
    ]


def _part(connection: Connection, table: Table, query: Any, page: Page, read: Any) -> Part[Any]:
    wanted = query.where(table.c.id > page.after).order_by(table.c.id).limit(page.limit + 1)
    return _cut(
        connection, connection.execute(wanted).all(), select(func.count()).select_from(table), page, read
    )


def _cut(connection: Connection, rows: Any, count: Any, page: Page, read: Any) -> Part[Any]:
    some = rows[: page.limit]
    following = some[-1].id if len(rows) > len(some) else None
    return Part(tuple(read(row) for row in some), connection.scalar(count) or 0, following)


def _results_part(connection: Connection, condition: ColumnElement[bool], page: Page) -> Part[ResultSeen]:
    query = results_seen().where(condition, plant_results.c.id > page.after).order_by(plant_results.c.id)
    rows = connection.execute(query.limit(page.limit + 1)).all()
    count = select(func.count()).select_from(plant_results).where(condition)
    return _cut(connection, rows, count, page, result_seen)


def _robots() -> Any:
    serial = plant_robots.c.serial_number
    of = plant_results.c.robot_serial_number
    newest = select(plant_cells.c.name).select_from(with_cells(plant_results)).where(of == serial)
    cell = newest.order_by(plant_results.c.measured_on.desc(), plant_results.c.id.desc()).limit(1)
    return select(plant_robots, cell.scalar_subquery().label("cell"), *_of_results(of, serial))


def _instruments() -> Any:
    serial = plant_instruments.c.serial_number
    return select(plant_instruments, *_of_results(plant_results.c.instrument_serial_number, serial))


def _of_results(of: Column[str], serial: Column[str]) -> tuple[Any, Any]:
    return (
        _alone(select(func.count()).where(of == serial)).label("results"),
        _alone(select(func.max(plant_results.c.measured_on)).where(of == serial)).label("last_measured_on"),
    )


def _alone(query: Any) -> ScalarSelect[Any]:
    answer: ScalarSelect[Any] = query.select_from(plant_results).scalar_subquery()
    return answer


def with_cells(table: Table) -> Any:
    """Return a table whose rows are of a branch, with its branch and cell."""
    of_branch = table.join(plant_branches, plant_branches.c.id == table.c.branch_id)
    return of_branch.join(plant_cells, plant_cells.c.id == plant_branches.c.cell_id)


def results_seen() -> Any:
    """Return the query for all results."""
    cell = plant_cells.c.name.label("cell")
    return select(plant_results, cell).select_from(with_cells(plant_results))


def _robot(row: Row[Any]) -> SeenRobot:
    return SeenRobot(
        row.id, row.serial_number, row.robot, row.cell or "", row.results, row.last_measured_on or ""
    )


def _instrument(row: Row[Any]) -> SeenInstrument:
    return SeenInstrument(row.id, row.serial_number, row.results, row.last_measured_on or "")


def result_seen(row: Row[Any]) -> ResultSeen:
    """Return a result as it was read."""
    return ResultSeen(**{name: getattr(row, name) for name in ResultSeen.__dataclass_fields__})
