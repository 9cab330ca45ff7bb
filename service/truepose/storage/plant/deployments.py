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
from truepose.storage.plant.records import HandDown, HandDownRecord, HandDownState
from truepose.storage.plant.tables import plant_cells, plant_hand_down_states, plant_hand_downs
from truepose.storage.queries import NumberedRecords, Part, Repository, part_of
from truepose.storage.record_insertion import add_row, once
from truepose.storage.records import Page, RequestKey
from truepose.storage.rows import from_row, to_row
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


class HandedDownRepository(Repository):
    """All queries about what was handed down to this cell."""

    async def add(self, new: NewHandedDown, key: RequestKey) -> int:
        """Keep what a plant hands down, once for each key; raises KeyReusedError."""
        row = to_row(new, handed_down)
        return await self._database.write_new(
            lambda c: once(c, key, "handed_down", lambda inner: add_row(inner, handed_down, **row))
        )

    async def get(self, number: int) -> HandedDownRecord:
        """Return what was handed down; raises NotFoundError."""
        return await self._database.read(lambda connection: _get(connection, number))

    async def page(self, page: Page) -> Part[HandedDownRecord]:
        """Return what was handed down, oldest first."""
        query, number = select(handed_down), handed_down.c.id
        return await self._database.read(
            lambda c: part_of(c, query, number, page, lambda row: _received_record(c, row))
        )

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


def _get(connection: Connection, number: int) -> HandedDownRecord:
    row = connection.execute(select(handed_down).where(handed_down.c.id == number)).one_or_none()
    if row is None:
        raise NotFoundError("hand-down", number)
    return _received_record(connection, row)


def _received_record(connection: Connection, row: Row[Any]) -> HandedDownRecord:
    of_it = hand_down_uses.c.handed_down_id == row.id
    used = connection.execute(select(hand_down_uses).where(of_it).order_by(hand_down_uses.c.id))
    accepted = connection.scalar(select(models.c.id).where(models.c.handed_down_id == row.id))
    return from_row(
        HandedDownRecord,
        row,
        handed_down=from_row(NewHandedDown, row),
        uses=tuple(from_row(Use, use) for use in used),
        model_id=accepted,
    )


class HandDownRepository(NumberedRecords[HandDownRecord]):
    """All queries about hand-downs."""

    def __init__(self, database: Database) -> None:
        super().__init__(database, "hand-down", plant_hand_downs, _records, _sent_record)

    async def add(self, hand_down: HandDown, key: RequestKey | None = None) -> int:
        """Keep what is to be handed down at the next visit; return its number."""
        return await self._database.write_new(
            lambda c: once(c, key, "hand_down", lambda inner: _add_sent(inner, hand_down))
        )

    async def waiting(self, cell: str) -> list[HandDownRecord]:
        """Return what a cell is to have and has not yet, oldest first."""
        none_yet = plant_hand_down_states.c.id.is_(None)
        query = _records().where(plant_cells.c.name == cell, none_yet).order_by(plant_hand_downs.c.id)
        return await self._each(query, _sent_record)

    async def note(
        self, number: int, state: HandDownState, sentence: str, number_in_cell: int | None
    ) -> None:
        """Keep what a cell said to a hand-down."""
        values = {"state": state.value, "sentence": sentence, "number_in_cell": number_in_cell}
        await self._database.write(
            lambda c: add_row(c, plant_hand_down_states, hand_down_id=number, **values)
        )


def _add_sent(connection: Connection, hand_down: HandDown) -> int:
    number = cell_number(connection, hand_down.cell)
    return add_row(connection, plant_hand_downs, cell_id=number, **to_row(hand_down, plant_hand_downs))


def _records() -> Select[Any]:
    every, states = plant_hand_down_states.alias("every"), plant_hand_down_states
    of_it = every.c.hand_down_id == plant_hand_downs.c.id
    newest = select(func.max(every.c.id)).where(of_it).correlate(plant_hand_downs).scalar_subquery()
    of_cell = plant_hand_downs.join(plant_cells, plant_cells.c.id == plant_hand_downs.c.cell_id)
    columns = (
        states.c.state,
        states.c.sentence,
        states.c.number_in_cell,
        states.c.recorded_at.label("since"),
    )
    found = select(plant_hand_downs, plant_cells.c.name.label("cell"), *columns)
    return found.select_from(of_cell.outerjoin(states, states.c.id == newest))


def _sent_record(row: Row[Any]) -> HandDownRecord:
    return from_row(
        HandDownRecord,
        row,
        hand_down=from_row(HandDown, row),
        # One without a state was never answered: nothing is written before the cell has said something.
        state=HandDownState(row.state or HandDownState.WAITING),
        sentence=row.sentence or "",
        state_since=row.since or row.recorded_at,
    )
