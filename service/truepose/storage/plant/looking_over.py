"""What the first page of a plant asks for: all robots with their last day, and what came in lately."""

from dataclasses import dataclass
from datetime import date, datetime
from typing import Any, Final

from sqlalchemy import Connection, ScalarSelect, func, select

from truepose.storage.database import Database
from truepose.storage.plant.looking import ResultSeen, result_seen, results_seen, with_cells
from truepose.storage.tables.of_plants import (
    plant_branches,
    plant_cells,
    plant_days,
    plant_results,
    plant_robots,
)

_MADE_LATER: Final = ("report", "closing")  # their day is none of measuring


@dataclass(frozen=True, slots=True)
class RobotMeasured:
    """A robot, and when and where it was measured last."""

    serial_number: str
    robot: str  # its type
    last_measured_on: str  # a day, by the cell's clock; empty: never
    cell: str  # empty: never measured
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
    days, results = plant_days.c, plant_results.c
    measured = results.kind.not_in(_MADE_LATER)
    columns = (
        plant_robots.c.serial_number,
        plant_robots.c.robot,
        _last(plant_days, days.measured_on, upto),
        _last(plant_days, plant_cells.c.name, upto),
        _last(plant_days, days.instrument_serial_number, upto),
        _last(plant_results, results.measured_on, upto, measured),
        _last(plant_results, plant_cells.c.name, upto, measured),
        _last(plant_results, results.instrument_serial_number, upto, measured),
    )
    return [_robot(upto, *row) for row in connection.execute(select(*columns))]


def _robot(upto: str, serial: str, robot: str, *told: str | None) -> RobotMeasured:
    found = [tuple(one or "" for one in told[first : first + 3]) for first in (0, 3)]
    return RobotMeasured(serial, robot, *max(found, key=lambda last: ("" < last[0] <= upto, last)))


def _last(table: Any, wanted: Any, upto: str, *conditions: Any) -> Any:
    """Return what the row of a robot's last day says: of one up to a day, else of any."""
    counting = table.c.measured_on.between("0", upto)  # an empty one is no day
    return func.coalesce(_newest(table, wanted, counting, *conditions), _newest(table, wanted, *conditions))


def _newest(table: Any, wanted: Any, *conditions: Any) -> ScalarSelect[Any]:
    """Return what the row of a robot's newest day says."""
    query: ScalarSelect[Any] = (
        select(wanted)
        .select_from(with_cells(table))
        .where(table.c.robot_serial_number == plant_robots.c.serial_number, *conditions)
        .order_by(table.c.measured_on.desc(), table.c.id.desc())
        .limit(1)
        .scalar_subquery()
    )
    return query


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
