"""What the first page of a plant asks for: all robots with their last day, and what came in lately."""

from dataclasses import dataclass, replace
from datetime import date

from sqlalchemy import ColumnElement, Connection, func, select

from truepose.storage.database import Database
from truepose.storage.plant.looking import (
    ResultSeen,
    cells_of_branches,
    last_before,
    last_days,
    result_seen,
    results_seen,
    with_last_days,
)
from truepose.storage.tables.of_plants import (
    plant_branches,
    plant_cells,
    plant_results,
    plant_robots,
    plant_sessions,
)


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
    """What came in since a day began, by the plant's clock."""

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

    async def robot(self, serial_number: str, upto: date) -> list[RobotMeasured]:
        """Return one robot, as it stands among them all; none where nobody has heard of it."""
        one = plant_robots.c.serial_number == serial_number
        return await self._database.read(lambda connection: _robots(connection, upto.isoformat(), one))

    async def lately(self, since: date, limit: int) -> Lately:
        """Return what came in since a day began."""
        return await self._database.read(lambda connection: _lately(connection, since.isoformat(), limit))

    async def campaigns_above(self, robot: str, number: int) -> int:
        """Return how many campaigns of a type of robot were collected after one."""
        here = (plant_results.c.kind == "campaign") & (plant_results.c.id > number)
        query = select(func.count()).select_from(plant_results).where(here, plant_results.c.robot == robot)
        return await self._database.read(lambda connection: connection.scalar(query) or 0)

    async def newest_branches(self) -> dict[str, int]:
        """Return the branch of each cell that its own numbers are those of."""
        query = (
            select(plant_cells.c.name, func.max(plant_branches.c.id))
            .join(plant_branches, plant_branches.c.cell_id == plant_cells.c.id)
            .group_by(plant_cells.c.name)
        )
        rows = await self._database.read(lambda connection: connection.execute(query).all())
        return dict(tuple(row) for row in rows)


def _robots(connection: Connection, upto: str, *conditions: ColumnElement[bool]) -> list[RobotMeasured]:
    query = select(plant_robots.c.serial_number, plant_robots.c.robot, *last_days(plant_robots, upto))
    robots = [
        RobotMeasured(
            row.serial_number, row.robot, last.measured_on, last.cell, last.instrument_serial_number
        )
        for row, last in with_last_days(connection, query.where(*conditions), upto)
    ]
    return _where_planned(connection, robots)


def _where_planned(connection: Connection, robots: list[RobotMeasured]) -> list[RobotMeasured]:
    """Return robots with the cell that planned for them, where none has measured them."""
    unmeasured = {robot.serial_number for robot in robots if not robot.cell}
    if not unmeasured:
        return robots
    cells = cells_of_branches(connection)
    planned = select(plant_sessions.c.robot_serial_number, plant_sessions.c.branch_id)
    rows = connection.execute(planned.order_by(plant_sessions.c.id))
    places = {serial: cells[branch] for serial, branch in rows if serial in unmeasured}
    return [replace(robot, cell=robot.cell or places.get(robot.serial_number, "")) for robot in robots]


def _lately(connection: Connection, since: str, limit: int) -> Lately:
    before = last_before(connection, plant_results, since)
    recent = plant_results.c.id > before
    counts = select(plant_results.c.kind, func.count()).where(recent).group_by(plant_results.c.kind)
    newest = results_seen().where(recent).order_by(plant_results.c.id.desc()).limit(limit)
    robots_before = last_before(connection, plant_robots, since)
    robots = select(func.count()).select_from(plant_robots).where(plant_robots.c.id > robots_before)
    return Lately(
        robots=connection.scalar(robots) or 0,
        results=dict(tuple(row) for row in connection.execute(counts)),
        newest=[result_seen(row) for row in connection.execute(newest)],
    )
