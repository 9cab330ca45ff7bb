"""Visits to cells: what came of each, and the clocks. What tells nothing new within an hour is not kept."""

from datetime import UTC, datetime, timedelta
from typing import Any, Final

from sqlalchemy import Connection, Row, func, select

from truepose.storage.database import Database
from truepose.storage.plant.chains import cell_number
from truepose.storage.plant.records import ClockSeen, Outcome, Visit, VisitRecord
from truepose.storage.rows import add_row
from truepose.storage.tables.of_plants import plant_cells, plant_visits

_AT_LEAST_EVERY: Final = timedelta(hours=1)


class VisitRepository:
    """All queries about visits."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def keep(self, cell: str, visit: Visit) -> None:
        """Keep a visit where it tells anything new: records, another outcome, clocks that moved, an hour."""
        await self._database.write(lambda connection: _keep(connection, cell, visit))

    async def newest(self) -> dict[str, VisitRecord | None]:
        """Return the newest visit to each cell, by its name; None: there was none yet."""
        return await self._database.read(_newest)

    async def of(self, cell: str, limit: int) -> list[VisitRecord]:
        """Return the latest visits to a cell, newest first."""
        query = (
            select(plant_visits)
            .join(plant_cells, plant_cells.c.id == plant_visits.c.cell_id)
            .where(plant_cells.c.name == cell)
            .order_by(plant_visits.c.id.desc())
            .limit(limit)
        )
        return await self._database.read(lambda c: [_record(row) for row in c.execute(query)])


def newest_visit(connection: Connection, cell_id: int) -> VisitRecord | None:
    """Return the newest visit to a cell, None where there was none."""
    query = select(plant_visits).where(plant_visits.c.cell_id == cell_id)
    row = connection.execute(query.order_by(plant_visits.c.id.desc()).limit(1)).one_or_none()
    return None if row is None else _record(row)


def _newest(connection: Connection) -> dict[str, VisitRecord | None]:
    last = (
        select(plant_visits.c.cell_id, func.max(plant_visits.c.id).label("id"))
        .group_by(plant_visits.c.cell_id)
        .subquery()
    )
    visits = connection.execute(select(plant_visits).join(last, plant_visits.c.id == last.c.id))
    found = {row.cell_id: _record(row) for row in visits}
    cells = connection.execute(select(plant_cells).order_by(plant_cells.c.name))
    return {row.name: found.get(row.id) for row in cells}


def _keep(connection: Connection, cell: str, visit: Visit) -> None:
    number = cell_number(connection, cell)
    before = newest_visit(connection, number)
    if before is not None and not _tells_anything(before, visit):
        return
    add_row(
        connection,
        plant_visits,
        cell_id=number,
        outcome=visit.outcome.value,
        sentence=visit.sentence,
        collected=visit.collected,
        newest=visit.newest,
        head=visit.head,
        fork=visit.fork,
        clock_offset_s=None if visit.clock is None else visit.clock.offset_s,
        clock_bound_s=None if visit.clock is None else visit.clock.bound_s,
        version=visit.version,
        cell_schema=visit.schema,
    )


def _tells_anything(before: VisitRecord, visit: Visit) -> bool:
    told = before.visit
    same = (told.outcome, told.fork, told.version) == (visit.outcome, visit.fork, visit.version)
    return not same or bool(visit.collected) or _moved(told.clock, visit.clock) or _is_old(before)


def _moved(before: ClockSeen | None, now: ClockSeen | None) -> bool:
    """Whether clocks differ otherwise than before by more than either visit leaves open."""
    if before is None or now is None:
        return before is not now
    return abs(now.offset_s - before.offset_s) > 1.0 + before.bound_s + now.bound_s


def _is_old(before: VisitRecord) -> bool:
    age = datetime.now(UTC) - datetime.fromisoformat(before.recorded_at)
    return abs(age) >= _AT_LEAST_EVERY  # also where this computer's clock was put back


def _record(row: Row[Any]) -> VisitRecord:
    clock = None if row.clock_offset_s is None else ClockSeen(row.clock_offset_s, row.clock_bound_s)
    visit = Visit(
        Outcome(row.outcome),
        row.sentence,
        row.collected,
        row.newest,
        row.head,
        row.fork,
        clock,
        row.version,
        row.cell_schema,
    )
    return VisitRecord(row.id, row.recorded_at, visit)
