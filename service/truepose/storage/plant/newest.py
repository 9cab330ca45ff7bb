"""The newest that each robot's results tell, by kind: what speaks for measuring it next, or against."""

from collections import defaultdict
from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date
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
    """All queries about what results tell."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def newest(self, upto: date) -> Mapping[str, Mapping[ToldKind, ToldSeen]]:
        """Return the newest of each kind of every robot that has any, by serial number.

        It is one up to a day, and a later one where there is no other.
        """
        return await self._database.read(lambda connection: _newest(connection, upto.isoformat()))

    async def of_robot(self, serial_number: str, limit: int = 500) -> list[ToldSeen]:
        """Return what the latest results of a robot tell that have a day, the oldest first."""
        return await self._database.read(lambda connection: _of_robot(connection, serial_number, limit))


def _of_robot(connection: Connection, serial_number: str, limit: int) -> list[ToldSeen]:
    own = (plant_told.c.robot_serial_number == serial_number) & (plant_told.c.measured_on > "")
    query = select(plant_told, plant_cells.c.name.label("cell")).select_from(with_cells(plant_told))
    last_first = (plant_told.c.measured_on.desc(), plant_told.c.id.desc())
    rows = connection.execute(query.where(own).order_by(*last_first).limit(limit))
    return [told_seen(row) for row in rows][::-1]


def _newest(connection: Connection, upto: str) -> Mapping[str, Mapping[ToldKind, ToldSeen]]:
    found: defaultdict[str, dict[ToldKind, ToldSeen]] = defaultdict(dict)
    for kind in _KINDS:
        for row in connection.execute(_newest_of(kind, upto)):
            found[row.robot_serial_number][kind] = told_seen(row)
    return found


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
