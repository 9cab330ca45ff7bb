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
    """A plan or a model to push to a cell."""

    cell: str = Field(min_length=1, max_length=200, examples=["left arm"])
    kind: Literal["plan", "model"]
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["monthly check"])
    person: PersonName
    document: FreeDocument = Field(
        description="For a plan, the body of `POST /sessions` of the cell; for a model, the model.",
        examples=[{"name": "monthly check"}],
    )


class HandDownReply(Reply):
    """A plan or a model pushed to a cell, with its delivery state."""

    id: RecordId
    recorded_at: RecordedAt
    cell: str = Field(examples=["left arm"])
    kind: Literal["plan", "model"]
    name: str = Field(examples=["monthly check"])
    person: str
    document: dict[str, Any] = Field(examples=[{"name": "monthly check"}])
    state: Literal["waiting", "delivered", "refused"]
    sentence: str = Field(description="Message from the cell; empty if there is none.", examples=[""])
    state_since: RecordedAt
    number_in_cell: int | None = Field(
        description="Number of the plan or model within the cell; null if the cell has not received it.",
        examples=[3],
    )


def hand_down_reply(record: HandDownRecord) -> HandDownReply:
    """Return what was handed down, as it travels."""
    return HandDownReply.of(record, record.hand_down)


router = resource("/plant/hand-downs", tags=["plant"])


@router.post("", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def add_hand_down(
    here: PlantHere, wanted: HandDownRequest, response: Response, key: OptionalKey
) -> HandDownReply:
    """Push a plan or a model to a cell. Nothing moves; a person at the cell decides about its use."""
    require_in_file(here, wanted.cell)
    told = HandDown(wanted.cell, HandDownKind(wanted.kind), wanted.name, wanted.person, wanted.document)
    number = await here.hand_downs.add(told, key)
    here.collector.visit_soon(wanted.cell)
    response.headers["Location"] = f"/api/v1/plant/hand-downs/{number}"
    return hand_down_reply(await here.hand_downs.get(number))


@router.get("", responses=LIST)
async def list_plant_hand_downs(here: PlantHere, paging: Paged) -> list[HandDownReply]:
    """List the pushed plans and models with their state, oldest first."""
    return paging.shown(await here.hand_downs.page(paging.page), hand_down_reply)


@router.get("/{id}", responses=READ)
async def get_plant_hand_down(here: PlantHere, id: Id) -> HandDownReply:
    """Return a pushed plan or model with its delivery state."""
    return hand_down_reply(await here.hand_downs.get(id))
