"""The newest that each robot's results tell, by kind: what speaks for measuring it next, or against."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
from functools import partial
from typing import Any, Final

from sqlalchemy import Connection, Row, func, select

from truepose.storage.database import Database
from truepose.storage.plant.looking import with_cells
from truepose.storage.plant.telling import Document, ToldKind
from truepose.storage.tables.of_plants import plant_cells, plant_robots, plant_told

_KINDS: Final[tuple[ToldKind, ...]] = ("campaign", "model", "validation", "diagnosis")


@dataclass(frozen=True, slots=True)
class ToldSeen:
    """What a result tells, and where it stands."""

    id: int
    branch_id: int
    cell: str
    kind: ToldKind
    record_id: int  # its number in the cell
    robot_serial_number: str
    measured_on: str
    verdict: str
    figure_mm: float | None
    limit_mm: float | None
    document: Document

    def is_later_than(self, other: "ToldSeen") -> bool:
        """Whether it was measured later, or told later of the same day."""
        return (self.measured_on, self.id) > (other.measured_on, other.id)


class PlantTold:
    """All queries about what results tell.

    What was told never changes: the newest of each robot is read once a day, and then only what came since.
    """

    def __init__(self, database: Database) -> None:
        self._database = database
        self._day = ""  # up to which what follows counts
        self._newest: defaultdict[str, dict[ToldKind, ToldSeen]] = defaultdict(dict)
        self._read_up_to = 0  # number of a row

    async def newest(self, upto: date) -> Mapping[str, Mapping[ToldKind, ToldSeen]]:
        """Return the newest of each kind of every robot that has any, by serial number.

        It is one up to a day, and a later one where there is no other.
        """
        day = upto.isoformat()
        after = self._read_up_to if day == self._day else 0
        last, came = await self._database.read(partial(_came_after, number=after, upto=day))
        if after == 0:
            self._newest, self._day, self._read_up_to = defaultdict(dict), day, 0
        for told in came:
            of_robot = self._newest[told.robot_serial_number]
            before = of_robot.get(told.kind)
            if before is None or _counts_before(told, before, day):
                of_robot[told.kind] = told
        self._read_up_to = max(self._read_up_to, last)
        return self._newest

    async def of_robot(self, serial_number: str, limit: int = 500) -> list[ToldSeen]:
        """Return what the latest results of a robot tell that have a day, the oldest first."""
        return await self._database.read(lambda connection: _of_robot(connection, serial_number, limit))


def _of_robot(connection: Connection, serial_number: str, limit: int) -> list[ToldSeen]:
    own = (plant_told.c.robot_serial_number == serial_number) & (plant_told.c.measured_on > "")
    query = select(plant_told, plant_cells.c.name.label("cell")).select_from(with_cells(plant_told))
    last_first = (plant_told.c.measured_on.desc(), plant_told.c.id.desc())
    rows = connection.execute(query.where(own).order_by(*last_first).limit(limit))
    return [told_seen(row) for row in rows][::-1]


def _counts_before(told: ToldSeen, other: ToldSeen, upto: str) -> bool:
    """Whether one counts as the newest before another: up to a day, the later one."""
    due, other_due = told.measured_on <= upto, other.measured_on <= upto
    return told.is_later_than(other) if due == other_due else due


def _came_after(connection: Connection, number: int, upto: str) -> tuple[int, list[ToldSeen]]:
    """Return the number of the last row, and what may be newest among those above a number."""
    last = int(connection.scalar(select(func.max(plant_told.c.id))) or 0)
    queries = [_above(number)] if number else [_newest_of(kind, upto) for kind in _KINDS]
    rows = (row for query in queries if last > number for row in connection.execute(query))
    return last, [told_seen(row) for row in rows]


def _above(number: int) -> Any:
    of_a_robot = plant_told.c.kind.in_(_KINDS) & (plant_told.c.robot_serial_number != "")
    query = select(plant_told, plant_cells.c.name.label("cell")).select_from(with_cells(plant_told))
    return query.where(plant_told.c.id > number, of_a_robot)


def _newest_of(kind: ToldKind, upto: str) -> Any:
    every = plant_told.alias("every")
    of_robot = (every.c.robot_serial_number == plant_robots.c.serial_number) & (every.c.kind == kind)
    last_first = (every.c.measured_on.desc(), every.c.id.desc())
    every_one = select(every.c.id).where(of_robot).order_by(*last_first).limit(1)
    counting = every_one.where(every.c.measured_on <= upto)
    newest = func.coalesce(counting.scalar_subquery(), every_one.scalar_subquery())
    return select(plant_told, plant_cells.c.name.label("cell")).select_from(
        with_cells(plant_told).join(plant_robots, plant_told.c.id == newest)
    )


def told_seen(row: Row[Any]) -> ToldSeen:
    """Return what a result tells as it was read."""
    return ToldSeen(**{name: getattr(row, name) for name in ToldSeen.__dataclass_fields__})
