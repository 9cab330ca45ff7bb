"""Visits to cells: what came of each, and the clocks.

A visit that finds the same as the one before is no record: when it was made is remembered as long as the
service runs, so that what is kept grows with what happens, and not with time.
"""

from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import Connection, Row, func, select

from truepose.storage.database import Database
from truepose.storage.plant.chains import cell_number
from truepose.storage.plant.records import ClockSeen, Outcome, Visit, VisitRecord
from truepose.storage.rows import add_row
from truepose.storage.tables.of_plants import plant_cells, plant_visits


class VisitRepository:
    """All queries about visits."""

    def __init__(self, database: Database) -> None:
        self._database = database
        self._kept: dict[str, VisitRecord] = {}  # the newest one to each cell, since the start
        self._found: dict[str, VisitRecord] = {}  # the same, as it was found last

    async def keep(self, cell: str, visit: Visit) -> None:
        """Keep a visit where it tells anything new: records, another outcome, clocks that moved."""
        kept = self._kept.get(cell) or (await self.newest()).get(cell)
        if kept is not None and visit.head is None:
            visit = replace(visit, head=kept.visit.head)
        if kept is None or _tells_anything(kept.visit, visit):
            kept = await self._database.write(lambda connection: _keep(connection, cell, visit))
        found = replace(visit, collected=kept.visit.collected)
        self._kept[cell], self._found[cell] = kept, replace(kept, visit=found, found_at=_now())

    async def newest(self) -> dict[str, VisitRecord | None]:
        """Return the newest visit to each cell, by its name; None: there was none yet."""
        return {**await self._database.read(_newest), **self._found}

    async def of(self, cell: str, limit: int) -> list[VisitRecord]:
        """Return the latest visits to a cell, newest first."""
        query = (
            select(plant_visits)
            .join(plant_cells, plant_cells.c.id == plant_visits.c.cell_id)
            .where(plant_cells.c.name == cell)
            .order_by(plant_visits.c.id.desc())
            .limit(limit)
        )
        kept = await self._database.read(lambda c: [_record(row) for row in c.execute(query)])
        found = self._found.get(cell)
        return [found if found is not None and found.id == record.id else record for record in kept]


def newest_visit(connection: Connection, cell_id: int) -> VisitRecord | None:
    """Return the newest visit to a cell, None where there was none."""
    query = select(plant_visits).where(plant_visits.c.cell_id == cell_id)
    row = connection.execute(query.order_by(plant_visits.c.id.desc()).limit(1)).one_or_none()
    return None if row is None else _record(row)


def _newest(connection: Connection) -> dict[str, VisitRecord | None]:
    of_cell = plant_visits.c.cell_id == plant_cells.c.id
    newest = select(func.max(plant_visits.c.id)).where(of_cell).correlate(plant_cells).scalar_subquery()
    visits = plant_cells.outerjoin(plant_visits, plant_visits.c.id == newest)
    query = select(plant_cells.c.name, plant_visits).select_from(visits).order_by(plant_cells.c.name)
    return {row.name: None if row.id is None else _record(row) for row in connection.execute(query)}


def _keep(connection: Connection, cell: str, visit: Visit) -> VisitRecord:
    cell_id = cell_number(connection, cell)
    number = add_row(
        connection,
        plant_visits,
        cell_id=cell_id,
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
    return _record(connection.execute(select(plant_visits).where(plant_visits.c.id == number)).one())


def _tells_anything(kept: Visit, visit: Visit) -> bool:
    same = (kept.outcome, kept.fork, kept.version) == (visit.outcome, visit.fork, visit.version)
    parted_elsewhere = visit.fork is not None and visit.head != kept.head
    return not same or parted_elsewhere or bool(visit.collected) or _moved(kept.clock, visit.clock)


def _moved(before: ClockSeen | None, now: ClockSeen | None) -> bool:
    """Whether clocks differ otherwise than before by more than either visit leaves open."""
    if before is None or now is None:
        return now is not None
    return abs(now.offset_s - before.offset_s) > 1.0 + before.bound_s + now.bound_s


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


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
    return VisitRecord(row.id, row.recorded_at, visit, row.recorded_at)
