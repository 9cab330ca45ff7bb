"""The cells of a plant: the branches of their chains, how far each was collected, and the visits to them.

A branch has the links of its parent up to where it leaves it, and then its own.

A visit that finds the same as the one before is no record: when it was made is remembered as long as the
service runs, so that what is kept grows with what happens, and not with time.
"""

from collections.abc import Mapping
from dataclasses import replace
from datetime import UTC, datetime
from typing import Any

from sqlalchemy import CTE, ColumnElement, Connection, Row, Table, func, select

from truepose.storage.database import Database
from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.records import AcceptedBranch, Branch, ClockSeen, Visit, VisitRecord
from truepose.storage.plant.tables import plant_branches, plant_cells, plant_journal, plant_visits
from truepose.storage.queries import Repository
from truepose.storage.record_insertion import add_row
from truepose.storage.rows import from_row, to_row


def enter_cell(connection: Connection, name: str) -> None:
    """Enter a cell where it is new, with its first branch."""
    # Cells are entered at each start, from the file that lists them.
    if _known_number(connection, name) is None:
        number = add_row(connection, plant_cells, name=name)
        add_row(connection, plant_branches, cell_id=number, after_link=0, person="", reason="")


def cell_number(connection: Connection, name: str) -> int:
    """Return the number of a cell that was entered; raises NotInPlantError."""
    number = _known_number(connection, name)
    if number is None:
        raise NotInPlantError(f"There is no cell '{name}' in this plant.")
    return number


def _known_number(connection: Connection, name: str) -> int | None:
    return connection.scalar(select(plant_cells.c.id).where(plant_cells.c.name == name))


def newest_branch(connection: Connection, cell_id: int) -> Branch:
    """Return the branch that a cell is collected into."""
    return _branches(connection, plant_branches.c.cell_id == cell_id)[-1]


def _branches(connection: Connection, condition: ColumnElement[bool]) -> list[Branch]:
    rows = connection.execute(select(plant_branches).where(condition).order_by(plant_branches.c.id)).all()
    by_number = {row.id: row for row in rows}
    return [Branch(row.id, row.cell_id, _segments(row, by_number)) for row in rows]


def _segments(row: Row[Any], by_number: Mapping[int, Row[Any]]) -> tuple[tuple[int, int | None], ...]:
    last = None
    segments: list[tuple[int, int | None]] = [(row.id, None)]
    while row.parent_id is not None:
        # A branch may leave its parent before the place at which that one left its own.
        last = row.after_link if last is None else min(last, row.after_link)
        row = by_number[row.parent_id]
        segments.append((row.id, last))
    return tuple(reversed(segments))


def add_branch(connection: Connection, branch: Branch, after_link: int, person: str, reason: str) -> None:
    """Have a cell collected into a further branch, which shares with `branch` what is up to a link."""
    add_row(
        connection,
        plant_branches,
        cell_id=branch.cell_id,
        parent_id=branch.id,
        after_link=after_link,
        person=person,
        reason=reason,
    )


def accepted_branches(connection: Connection, name: str) -> list[AcceptedBranch]:
    """Return the chains of a cell that somebody accepted, the newest first."""
    branch = plant_branches.c
    query = select(branch.recorded_at, branch.after_link, branch.person, branch.reason)
    accepted = query.where(branch.cell_id == cell_number(connection, name), branch.parent_id.is_not(None))
    return [AcceptedBranch(*row) for row in connection.execute(accepted.order_by(branch.id.desc()))]


def position(connection: Connection, branch: Branch) -> int:
    """Return the newest link that was collected."""
    own = select(func.max(plant_journal.c.link)).where(plant_journal.c.branch_id == branch.id)
    after = select(plant_branches.c.after_link).where(plant_branches.c.id == branch.id)
    # The newest link itself is the position: there is no second number that could disagree with it (decision
    # 0062).
    return int(connection.scalar(own) or connection.scalar(after) or 0)


def heads(connection: Connection, branch: Branch, at: int) -> Mapping[int, bytes]:
    """Return the newest hash of each stream, as it was at a link."""
    found: dict[int, bytes] = {}
    for number, last in branch.segments:
        found |= _heads_of(connection, number, at if last is None else min(last, at))
    return found


def newest_row(
    connection: Connection, branch: Branch, table: Table, condition: ColumnElement[bool], *, by_link: bool
) -> Row[Any] | None:
    """Return the newest row of a branch, else of what it shares with those before it.

    `by_link` says that a row belongs to a link, and counts up to where its branch was left.
    """
    # From the own branch back: what was collected after the parting counts before what is shared.
    for branch_id, last in reversed(branch.segments):
        query = select(table).where(table.c.branch_id == branch_id, condition)
        if by_link and last is not None:
            query = query.where(table.c.link <= last)
        row = connection.execute(query.order_by(table.c.id.desc()).limit(1)).one_or_none()
        if row is not None:
            return row
    return None


def _heads_of(connection: Connection, branch_id: int, upto: int) -> dict[int, bytes]:
    streams = _streams(branch_id)
    of_stream = (plant_journal.c.branch_id == branch_id) & (plant_journal.c.stream == streams.c.stream)
    wanted = of_stream & (plant_journal.c.link <= upto)
    newest = select(plant_journal.c.hash).where(wanted).order_by(plant_journal.c.link.desc()).limit(1)
    rows = connection.execute(
        select(streams.c.stream, newest.scalar_subquery()).where(streams.c.stream.is_not(None))
    )
    return {stream: bytes(found) for stream, found in rows if found is not None}


def _streams(branch_id: int) -> CTE:
    """Return every stream of a branch, from one to the next by the index: no link is looked through."""
    here = select(func.min(plant_journal.c.stream).label("stream")).where(
        plant_journal.c.branch_id == branch_id
    )
    before = here.cte("streams", recursive=True)
    following = here.where(plant_journal.c.stream > before.c.stream).scalar_subquery()
    return before.union_all(select(following).where(before.c.stream.is_not(None)))


class VisitRepository(Repository):
    """All queries about visits."""

    def __init__(self, database: Database) -> None:
        super().__init__(database)
        self._kept: dict[str, VisitRecord] = {}  # the newest one to each cell, since the start
        self._found: dict[str, VisitRecord] = {}  # the same, as it was found last

    async def keep(self, cell: str, visit: Visit) -> None:
        """Keep a visit where it tells anything new: records, another outcome, clocks that moved."""
        kept = self._kept.get(cell) or (await self.newest()).get(cell)
        # A visit without an answer says nothing of the chain, and must not seem to have changed it (decision
        # 0066).
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
        kept = await self._each(query, _record)
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
        **to_row(visit, plant_visits),
        cell_id=cell_id,
        clock_offset_s=None if visit.clock is None else visit.clock.offset_s,
        clock_bound_s=None if visit.clock is None else visit.clock.bound_s,
        cell_schema=visit.schema,
    )
    return _record(connection.execute(select(plant_visits).where(plant_visits.c.id == number)).one())


def _tells_anything(kept: Visit, visit: Visit) -> bool:
    same = (kept.outcome, kept.fork, kept.version) == (visit.outcome, visit.fork, visit.version)
    # Once a person has accepted a branch the same fork may be found again from another position.
    parted_elsewhere = visit.fork is not None and visit.head != kept.head
    return not same or parted_elsewhere or bool(visit.collected) or _moved(kept.clock, visit.clock)


def _moved(before: ClockSeen | None, now: ClockSeen | None) -> bool:
    """Whether clocks differ otherwise than before by more than either visit leaves open."""
    if before is None or now is None:
        return now is not None
    # Compared with the visit that was kept and not with the last one: a slow drift is kept once it has come
    # to a second (decision 0066).
    return abs(now.offset_s - before.offset_s) > 1.0 + before.bound_s + now.bound_s


def _now() -> str:
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def _record(row: Row[Any]) -> VisitRecord:
    clock = None if row.clock_offset_s is None else ClockSeen(row.clock_offset_s, row.clock_bound_s)
    visit = from_row(Visit, row, clock=clock, schema=row.cell_schema)
    return VisitRecord(row.id, row.recorded_at, visit, row.recorded_at)
