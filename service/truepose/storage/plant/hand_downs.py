"""What a plant hands down to its cells, and what became of it."""

from typing import Any

from sqlalchemy import Connection, Row, Select, func, select

from truepose.storage.database import Database
from truepose.storage.errors import NotFoundError
from truepose.storage.parts import Part
from truepose.storage.plant.chains import cell_number
from truepose.storage.plant.records import HandDown, HandDownKind, HandDownRecord, HandDownState
from truepose.storage.records import Page, RequestKey
from truepose.storage.request_keys import once
from truepose.storage.rows import add_row
from truepose.storage.tables.of_plants import plant_cells, plant_hand_down_states, plant_hand_downs


class HandDownRepository:
    """All queries about hand-downs."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def add(self, hand_down: HandDown, key: RequestKey | None = None) -> int:
        """Keep what is to be handed down at the next visit; return its number."""
        return await self._database.write_new(
            lambda c: once(c, key, "hand_down", lambda inner: _add(inner, hand_down))
        )

    async def get(self, number: int) -> HandDownRecord:
        """Return a hand-down; raises NotFoundError."""
        query = _records().where(plant_hand_downs.c.id == number)
        row = await self._database.read(lambda connection: connection.execute(query).one_or_none())
        if row is None:
            raise NotFoundError("hand-down", number)
        return _record(row)

    async def page(self, page: Page) -> Part[HandDownRecord]:
        """Return hand-downs, oldest first."""
        return await self._database.read(lambda connection: _page(connection, page))

    async def waiting(self, cell: str) -> list[HandDownRecord]:
        """Return what a cell is to have and has not yet, oldest first."""
        none_yet = plant_hand_down_states.c.id.is_(None)
        query = _records().where(plant_cells.c.name == cell, none_yet).order_by(plant_hand_downs.c.id)
        return await self._database.read(lambda c: [_record(row) for row in c.execute(query)])

    async def note(
        self, number: int, state: HandDownState, sentence: str, number_in_cell: int | None
    ) -> None:
        """Keep what a cell said to a hand-down."""
        values = {"state": state.value, "sentence": sentence, "number_in_cell": number_in_cell}
        await self._database.write(
            lambda c: add_row(c, plant_hand_down_states, hand_down_id=number, **values)
        )


def _add(connection: Connection, hand_down: HandDown) -> int:
    return add_row(
        connection,
        plant_hand_downs,
        cell_id=cell_number(connection, hand_down.cell),
        kind=hand_down.kind.value,
        name=hand_down.name,
        person=hand_down.person,
        document=dict(hand_down.document),
    )


def _page(connection: Connection, page: Page) -> Part[HandDownRecord]:
    query = _records().where(plant_hand_downs.c.id > page.after).order_by(plant_hand_downs.c.id)
    rows = connection.execute(query.limit(page.limit + 1)).all()
    some = rows[: page.limit]
    total = connection.scalar(select(func.count()).select_from(plant_hand_downs)) or 0
    following = some[-1].id if len(rows) > len(some) else None
    return Part(tuple(_record(row) for row in some), total, following)


def _records() -> Select[Any]:
    every, states = plant_hand_down_states.alias("every"), plant_hand_down_states
    of_it = every.c.hand_down_id == plant_hand_downs.c.id
    newest = select(func.max(every.c.id)).where(of_it).correlate(plant_hand_downs).scalar_subquery()
    columns = (states.c.state, states.c.sentence, states.c.number_in_cell)
    return (
        select(
            plant_hand_downs, plant_cells.c.name.label("cell"), *columns, states.c.recorded_at.label("since")
        )
        .join(plant_cells, plant_cells.c.id == plant_hand_downs.c.cell_id)
        .outerjoin(states, states.c.id == newest)
    )


def _record(row: Row[Any]) -> HandDownRecord:
    told = HandDown(row.cell, HandDownKind(row.kind), row.name, row.person, row.document)
    state = HandDownState.WAITING if row.state is None else HandDownState(row.state)
    since = row.since or row.recorded_at
    return HandDownRecord(row.id, row.recorded_at, told, state, row.sentence or "", row.number_in_cell, since)
