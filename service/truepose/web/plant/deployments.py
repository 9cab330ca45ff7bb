"""Plans and models for cells: delivered at the next visit, once, and listed with what the cell said."""

from typing import Any, Literal

from fastapi import Response, status
from pydantic import Field

from truepose.storage.plant.records import HandDown, HandDownKind, HandDownRecord
from truepose.web.plant.cells import require_in_file
from truepose.web.plant.context import PlantHere
from truepose.web.resources import CHANGE, LIST, READ, Id, OptionalKey, Paged, resource
from truepose.web.schemas import VISIBLE, FreeDocument, PersonName, RecordedAt, RecordId, Reply, Request


class HandDownRequest(Request):
    """A plan or a model for a cell."""

    cell: str = Field(min_length=1, max_length=200, examples=["left arm"])
    kind: Literal["plan", "model"]
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["monthly check"])
    person: PersonName
    document: FreeDocument = Field(
        description="Of a plan, what `POST /sessions` of the cell takes; of a model, the model.",
        examples=[{"name": "monthly check"}],
    )


class HandDownReply(Reply):
    """A plan or a model for a cell, and whether the cell has it."""

    id: RecordId
    recorded_at: RecordedAt
    cell: str = Field(examples=["left arm"])
    kind: Literal["plan", "model"]
    name: str = Field(examples=["monthly check"])
    person: str
    document: dict[str, Any] = Field(examples=[{"name": "monthly check"}])
    state: Literal["waiting", "delivered", "refused"]
    sentence: str = Field(description="What the cell said; empty: nothing.", examples=[""])
    state_since: RecordedAt
    number_in_cell: int | None = Field(description="Its number there; null: it is not there.", examples=[3])


def hand_down_reply(record: HandDownRecord) -> HandDownReply:
    """Return what was handed down, as it travels."""
    return HandDownReply.of(record, record.hand_down)


router = resource("/plant/hand-downs", tags=["plant"])


@router.post("", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def add_hand_down(
    here: PlantHere, wanted: HandDownRequest, response: Response, key: OptionalKey
) -> HandDownReply:
    """Hand a plan or a model down to a cell. A person there uses it, or nobody does: nothing moves by it."""
    require_in_file(here, wanted.cell)
    told = HandDown(wanted.cell, HandDownKind(wanted.kind), wanted.name, wanted.person, wanted.document)
    number = await here.hand_downs.add(told, key)
    here.collector.visit_soon(wanted.cell)
    response.headers["Location"] = f"/api/v1/plant/hand-downs/{number}"
    return hand_down_reply(await here.hand_downs.get(number))


@router.get("", responses=LIST)
async def list_plant_hand_downs(here: PlantHere, paging: Paged) -> list[HandDownReply]:
    """List what was handed down, oldest first, with its state."""
    return paging.shown(await here.hand_downs.page(paging.page), hand_down_reply)


@router.get("/{id}", responses=READ)
async def get_plant_hand_down(here: PlantHere, id: Id) -> HandDownReply:
    """Show what was handed down, and whether the cell has it."""
    return hand_down_reply(await here.hand_downs.get(id))
