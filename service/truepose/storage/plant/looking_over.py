"""What the first page of a plant asks for: all robots with their last day, and what came in lately."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from datetime import date, datetime
from typing import Any, Final

from sqlalchemy import ColumnElement, Connection, ScalarSelect, Table, cast, func, select

from truepose.storage.column_types import TEXT
from truepose.storage.database import Database
from truepose.storage.plant.looking import ResultSeen, result_seen, results_seen
from truepose.storage.tables.of_plants import (
    plant_branches,
    plant_cells,
    plant_days,
    plant_results,
    plant_robots,
    plant_sessions,
)

_MADE_LATER: Final = ("report", "closing")  # their day is none of measuring
_BETWEEN: Final = "\x1f"  # unit separator: in no day and no serial number


@dataclass(frozen=True, slots=True)
class RobotMeasured:
    """A robot, and when and where it was measured last."""

    serial_number: str
    robot: str  # its type
    last_measured_on: str  # a day, by the cell's clock; empty: never
    cell: str  # where that was, or where it is to be measured; empty: nobody said it
    instrument_serial_number: str = ""  # that measured it then; empty: nobody said it


@dataclass(frozen=True, slots=True)
class Lately:
    """What came in since a moment, by the plant's clock."""

    robots: int  # seen for the first time
    results: dict[str, int]  # how many of each kind
    newest: list[ResultSeen]  # the latest of them, newest first


class PlantOverview:
    """All queries about a plant as a whole."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def robots(self, upto: date) -> list[RobotMeasured]:
        """Return every robot with its last day up to one; a later one where it has no other.

        A clock that was wrong once would else be the last that anybody heard of a robot.
        """
        return await self._database.read(lambda connection: _robots(connection, upto.isoformat()))

    async def lately(self, since: datetime, limit: int) -> Lately:
        """Return what came in since a moment."""
        return await self._database.read(
            lambda c: _lately(c, since.isoformat(timespec="milliseconds"), limit)
        )

    async def newest_branches(self) -> dict[str, int]:
        """Return the branch of each cell that its own numbers are those of."""
        query = (
            select(plant_cells.c.name, func.max(plant_branches.c.id))
            .join(plant_branches, plant_branches.c.cell_id == plant_cells.c.id)
            .group_by(plant_cells.c.name)
        )
        rows = await self._database.read(lambda connection: connection.execute(query).all())
        return dict(tuple(row) for row in rows)


def _robots(connection: Connection, upto: str) -> list[RobotMeasured]:
    cells = _cells_of_branches(connection)
    measured = plant_results.c.kind.not_in(_MADE_LATER)
    robot = (plant_robots.c.serial_number, plant_robots.c.robot)
    query = select(*robot, _last(plant_days, upto), _last(plant_results, upto, measured))
    robots = [
        RobotMeasured(serial, robot, *_later(upto, _read(cells, of_days), _read(cells, of_results)))
        for serial, robot, of_days, of_results in connection.execute(query)
    ]
    return _where_planned(connection, cells, robots)


def _where_planned(
    connection: Connection, cells: Mapping[int, str], robots: list[RobotMeasured]
) -> list[RobotMeasured]:
    """Return robots with the cell that planned for them, where none has measured them."""
    unmeasured = {robot.serial_number for robot in robots if not robot.cell}
    if not unmeasured:
        return robots
    planned = select(plant_sessions.c.robot_serial_number, plant_sessions.c.branch_id)
    rows = connection.execute(planned.order_by(plant_sessions.c.id))
    places = {serial: cells[branch] for serial, branch in rows if serial in unmeasured}
    return [replace(robot, cell=robot.cell or places.get(robot.serial_number, "")) for robot in robots]


def _later(upto: str, *found: tuple[str, str, str]) -> tuple[str, str, str]:
    return max(found, key=lambda last: ("" < last[0] <= upto, last))


def _last(table: Table, upto: str, *conditions: ColumnElement[bool]) -> ColumnElement[str]:
    """Return what the row of a robot's last day says: of one up to a day, else of any."""
    counting = (table.c.measured_on > "") & (table.c.measured_on <= upto)
    return func.coalesce(_newest(table, counting, *conditions), _newest(table, *conditions))


def _newest(table: Table, *conditions: ColumnElement[bool]) -> ScalarSelect[str]:
    """Return branch, day and instrument of a robot's newest day, in one text: it is sought once."""
    told = (cast(table.c.branch_id, TEXT), table.c.measured_on, table.c.instrument_serial_number)
    query = select(told[0] + _BETWEEN + told[1] + _BETWEEN + told[2])
    of_robot = query.where(table.c.robot_serial_number == plant_robots.c.serial_number, *conditions)
    return of_robot.order_by(table.c.measured_on.desc(), table.c.id.desc()).limit(1).scalar_subquery()


def _read(cells: Mapping[int, str], told: str | None) -> tuple[str, str, str]:
    """Return day, cell and instrument; empty where there are none."""
    if told is None:
        return "", "", ""
    branch, day, instrument = told.split(_BETWEEN, 2)
    return day, cells[int(branch)], instrument


def _cells_of_branches(connection: Connection) -> dict[int, str]:
    of_branch = plant_branches.c.cell_id == plant_cells.c.id
    query = select(plant_branches.c.id, plant_cells.c.name).join(plant_cells, of_branch)
    return dict(tuple(row) for row in connection.execute(query))


def _lately(connection: Connection, since: str, limit: int) -> Lately:
    before = _last_before(connection, plant_results, since)
    recent = plant_results.c.id > before
    counts = select(plant_results.c.kind, func.count()).where(recent).group_by(plant_results.c.kind)
    newest = results_seen().where(recent).order_by(plant_results.c.id.desc()).limit(limit)
    robots_before = _last_before(connection, plant_robots, since)
    robots = select(func.count()).select_from(plant_robots).where(plant_robots.c.id > robots_before)
    return Lately(
        robots=connection.scalar(robots) or 0,
        results=dict(tuple(row) for row in connection.execute(counts)),
        newest=[result_seen(row) for row in connection.execute(newest)],
    )


def _last_before(connection: Connection, table: Any, since: str) -> int:
    """Return the last row that was there before; sought from the newest one: old rows cost nothing."""
    query = select(table.c.id).where(table.c.recorded_at < since).order_by(table.c.id.desc()).limit(1)
    return connection.scalar(query) or 0
