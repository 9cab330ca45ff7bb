"""What a plant hands down to its cells, as it is on record in the plant and in the cell.

Nothing of it moves anything by itself.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from sqlalchemy import Connection, Row, Select, func, select

from truepose.domain.identification import Model
from truepose.storage.database import Database
from truepose.storage.documents import to_document
from truepose.storage.errors import ConflictError, NotFoundError
from truepose.storage.plant.cells import cell_number
from truepose.storage.plant.records import HandDown, HandDownKind, HandDownRecord, HandDownState
from truepose.storage.plant.tables import plant_cells, plant_hand_down_states, plant_hand_downs
from truepose.storage.queries import Part
from truepose.storage.record_insertion import add_row, once
from truepose.storage.records import Page, RequestKey
from truepose.storage.tables import hand_down_uses, handed_down, models


@dataclass(frozen=True, slots=True)
class NewHandedDown:
    """A plan or a model, as a plant hands it down."""

    plant: str
    kind: str
    name: str
    person: str
    document: Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Use:
    """Somebody used what was handed down."""

    recorded_at: str
    person: str
    note: str


@dataclass(frozen=True, slots=True)
class HandedDownRecord:
    """What was handed down, as it was kept."""

    id: int
    recorded_at: str
    handed_down: NewHandedDown
    uses: tuple[Use, ...]
    model_id: int | None  # as which it was accepted; None: it was not


class HandedDownRepository:
    """All queries about what was handed down to this cell."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def add(self, new: NewHandedDown, key: RequestKey) -> int:
        """Keep what a plant hands down, once for each key; raises KeyReusedError."""
        return await self._database.write_new(
            lambda c: once(c, key, "handed_down", lambda i: _add_received(i, new))
        )

    async def get(self, number: int) -> HandedDownRecord:
        """Return what was handed down; raises NotFoundError."""
        return await self._database.read(lambda connection: _get(connection, number))

    async def page(self, page: Page) -> Part[HandedDownRecord]:
        """Return what was handed down, oldest first."""
        return await self._database.read(lambda connection: _received_page(connection, page))

    async def newest(self, count: int, before: int | None = None) -> list[HandedDownRecord]:
        """Return what was handed down last, or last before a number, newest first."""
        query = select(handed_down).order_by(handed_down.c.id.desc()).limit(count)
        if before is not None:
            query = query.where(handed_down.c.id < before)
        return await self._database.read(
            lambda c: [_received_record(c, row) for row in c.execute(query).all()]
        )

    async def accept_model(self, number: int, model: Model, person: str) -> int:
        """Keep a handed-down model as one of this cell, with who accepts it; return its number there.

        Raises NotFoundError, and ConflictError where it was accepted before.
        """
        return await self._database.write(lambda connection: _accept(connection, number, model, person))

    async def note_use(self, number: int, person: str, note: str) -> None:
        """Keep who used what was handed down; raises NotFoundError."""

        def work(connection: Connection) -> None:
            _get(connection, number)
            add_row(connection, hand_down_uses, handed_down_id=number, person=person, note=note)

        await self._database.write(work)


def _accept(connection: Connection, number: int, model: Model, person: str) -> int:
    _get(connection, number)
    # Two models from one hand-down would be two records of the same acceptance; the unique index refuses the
    # second as well.
    before = connection.scalar(select(models.c.id).where(models.c.handed_down_id == number))
    if before is not None:
        raise ConflictError(f"Hand-down {number} was accepted already, as model {before}.")
    named = {"handed_down_id": number, "accepted_by": person, "robot": model.robot.name}
    made = add_row(connection, models, **named, document=to_document(model))
    add_row(
        connection, hand_down_uses, handed_down_id=number, person=person, note=f"Accepted as model {made}."
    )
    return made


def _add_received(connection: Connection, new: NewHandedDown) -> int:
    return add_row(
        connection,
        handed_down,
        plant=new.plant,
        kind=new.kind,
        name=new.name,
        person=new.person,
        document=dict(new.document),
    )


def _get(connection: Connection, number: int) -> HandedDownRecord:
    row = connection.execute(select(handed_down).where(handed_down.c.id == number)).one_or_none()
    if row is None:
        raise NotFoundError("hand-down", number)
    return _received_record(connection, row)


def _received_page(connection: Connection, page: Page) -> Part[HandedDownRecord]:
    query = select(handed_down).where(handed_down.c.id > page.after).order_by(handed_down.c.id)
    rows = connection.execute(query.limit(page.limit + 1)).all()
    some = rows[: page.limit]
    total = connection.scalar(select(func.count()).select_from(handed_down)) or 0
    following = some[-1].id if len(rows) > len(some) else None
    return Part(tuple(_received_record(connection, row) for row in some), total, following)


def _received_record(connection: Connection, row: Row[Any]) -> HandedDownRecord:
    of_it = hand_down_uses.c.handed_down_id == row.id
    used = connection.execute(select(hand_down_uses).where(of_it).order_by(hand_down_uses.c.id))
    uses = tuple(Use(use.recorded_at, use.person, use.note) for use in used)
    new = NewHandedDown(row.plant, row.kind, row.name, row.person, row.document)
    accepted = connection.scalar(select(models.c.id).where(models.c.handed_down_id == row.id))
    return HandedDownRecord(row.id, row.recorded_at, new, uses, accepted)


class HandDownRepository:
    """All queries about hand-downs."""

    def __init__(self, database: Database) -> None:
        self._database = database

    async def add(self, hand_down: HandDown, key: RequestKey | None = None) -> int:
        """Keep what is to be handed down at the next visit; return its number."""
        return await self._database.write_new(
            lambda c: once(c, key, "hand_down", lambda inner: _add_sent(inner, hand_down))
        )

    async def get(self, number: int) -> HandDownRecord:
        """Return a hand-down; raises NotFoundError."""
        query = _records().where(plant_hand_downs.c.id == number)
        row = await self._database.read(lambda connection: connection.execute(query).one_or_none())
        if row is None:
            raise NotFoundError("hand-down", number)
        return _sent_record(row)

    async def page(self, page: Page) -> Part[HandDownRecord]:
        """Return hand-downs, oldest first."""
        return await self._database.read(lambda connection: _sent_page(connection, page))

    async def waiting(self, cell: str) -> list[HandDownRecord]:
        """Return what a cell is to have and has not yet, oldest first."""
        none_yet = plant_hand_down_states.c.id.is_(None)
        query = _records().where(plant_cells.c.name == cell, none_yet).order_by(plant_hand_downs.c.id)
        return await self._database.read(lambda c: [_sent_record(row) for row in c.execute(query)])

    async def note(
        self, number: int, state: HandDownState, sentence: str, number_in_cell: int | None
    ) -> None:
        """Keep what a cell said to a hand-down."""
        values = {"state": state.value, "sentence": sentence, "number_in_cell": number_in_cell}
        await self._database.write(
            lambda c: add_row(c, plant_hand_down_states, hand_down_id=number, **values)
        )


def _add_sent(connection: Connection, hand_down: HandDown) -> int:
    return add_row(
        connection,
        plant_hand_downs,
        cell_id=cell_number(connection, hand_down.cell),
        kind=hand_down.kind.value,
        name=hand_down.name,
        person=hand_down.person,
        document=dict(hand_down.document),
    )


def _sent_page(connection: Connection, page: Page) -> Part[HandDownRecord]:
    query = _records().where(plant_hand_downs.c.id > page.after).order_by(plant_hand_downs.c.id)
    rows = connection.execute(query.limit(page.limit + 1)).all()
    some = rows[: page.limit]
    total = connection.scalar(select(func.count()).select_from(plant_hand_downs)) or 0
    following = some[-1].id if len(rows) > len(some) else None
    return Part(tuple(_sent_record(row) for row in some), total, following)


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


def _sent_record(row: Row[Any]) -> HandDownRecord:
    told = HandDown(row.cell, HandDownKind(row.kind), row.name, row.person, row.document)
    # A hand-down without a state was never answered: nothing is written before the cell has said something.
    state = HandDownState.WAITING if row.state is None else HandDownState(row.state)
    since = row.since or row.recorded_at
    return HandDownRecord(row.id, row.recorded_at, told, state, row.sentence or "", row.number_in_cell, since)
