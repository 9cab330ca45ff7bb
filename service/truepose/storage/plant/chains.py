"""The chains of a cell: branches, how far each was collected, and the hashes that the next links rest on.

A branch has the links of its parent up to where it leaves it, and then its own.
"""

from collections.abc import Mapping
from typing import Any

from sqlalchemy import CTE, ColumnElement, Connection, Row, Table, func, select

from truepose.storage.errors import NotInPlantError
from truepose.storage.plant.records import AcceptedBranch, Branch
from truepose.storage.rows import add_row
from truepose.storage.tables.of_plants import plant_branches, plant_cells, plant_journal


def enter_cell(connection: Connection, name: str) -> None:
    """Enter a cell where it is new, with its first branch."""
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


def all_branches(connection: Connection) -> list[Branch]:
    """Return every branch of every cell, each after the one that it parted from."""
    return _branches(connection, plant_branches.c.id > 0)


def _branches(connection: Connection, condition: ColumnElement[bool]) -> list[Branch]:
    rows = connection.execute(select(plant_branches).where(condition).order_by(plant_branches.c.id)).all()
    by_number = {row.id: row for row in rows}
    return [Branch(row.id, row.cell_id, _segments(row, by_number)) for row in rows]


def _segments(row: Row[Any], by_number: Mapping[int, Row[Any]]) -> tuple[tuple[int, int | None], ...]:
    last = None
    segments: list[tuple[int, int | None]] = [(row.id, None)]
    while row.parent_id is not None:
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
