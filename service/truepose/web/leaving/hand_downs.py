"""What the plant hands down to this cell: it is kept and shown, and a person uses it, or nobody does."""

import asyncio

from fastapi import Response, status

from truepose.exchange.models.of_cell import accepted_model, fitting_model
from truepose.storage.errors import ConflictError
from truepose.storage.leaving.handed_down import HandedDownRecord, HandedDownRepository, NewHandedDown
from truepose.web.context import Here
from truepose.web.leaving.schemas import (
    AcceptanceRequest,
    HandedDownReply,
    HandedDownRequest,
    ModelCheckReply,
    UseRequest,
    handed_down_reply,
    model_check_reply,
)
from truepose.web.people.asking import Asker, asking
from truepose.web.problems import problems
from truepose.web.requests.paging import Paged, listing
from truepose.web.requests.parameters import Id, RequiredKey
from truepose.web.resources import resource
from truepose.web.schemas.calibration.results import ModelReply, model_reply

router = resource("/hand-downs", tags=["plant"])


@router.post("", status_code=status.HTTP_201_CREATED, responses=problems(400, 404, 409, 413, 415, 422, 503))
async def accept_hand_down(
    here: Here, asker: Asker, response: Response, wanted: HandedDownRequest, key: RequiredKey
) -> HandedDownReply:
    """Keep a plan or a model that the plant hands down. Nothing is planned and nothing moves by it."""
    plant = asker.tablet_name or asker.name
    asking().reason = f"handed down by {wanted.person}, as the plant says" if plant else None
    new = NewHandedDown(plant, wanted.kind, wanted.name, wanted.person, wanted.document)
    kept = HandedDownRepository(here.database)
    number = await kept.add(new, key)
    response.headers["Location"] = f"/api/v1/hand-downs/{number}"
    return handed_down_reply(await kept.get(number))


@router.get("", responses=listing(422, 503))
async def list_hand_downs(here: Here, paging: Paged) -> list[HandedDownReply]:
    """List what the plant handed down, oldest first."""
    return paging.shown(await HandedDownRepository(here.database).page(paging.page), handed_down_reply)


@router.get("/{id}", responses=problems(404, 422, 503))
async def get_hand_down(here: Here, id: Id) -> HandedDownReply:
    """Show what was handed down: of a plan, the body that `POST /sessions` takes."""
    return handed_down_reply(await HandedDownRepository(here.database).get(id))


@router.get("/{id}/check", responses=problems(404, 409, 422, 503))
async def get_hand_down_check(here: Here, id: Id) -> ModelCheckReply:
    """Show how far a handed-down model moves the tool here, and which values are far from their priors."""
    told = _require_model(await HandedDownRepository(here.database).get(id))
    return model_check_reply(await asyncio.to_thread(fitting_model, told.document, here.cell))


@router.post(
    "/{id}/acceptance",
    status_code=status.HTTP_201_CREATED,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
)
async def accept_handed_down_model(
    here: Here, id: Id, wanted: AcceptanceRequest, response: Response
) -> ModelReply:
    """Accept a model that was handed down as one of this cell, of the same robot and with the same tool.

    It then corrects programs and is validated as one that was identified here. Once is enough (409). One
    that moves the tool beyond the cell's limit needs the shift confirmed (409 says which).
    """
    kept = HandedDownRepository(here.database)
    told = _require_model(await kept.get(id))
    model = await asyncio.to_thread(accepted_model, told.document, here.cell, wanted.accepted_shift_mm)
    number = await kept.accept_model(id, model, wanted.person)
    response.headers["Location"] = f"/api/v1/models/{number}"
    return model_reply(await here.results.model(number))


@router.post(
    "/{id}/uses",
    status_code=status.HTTP_201_CREATED,
    responses=problems(400, 404, 409, 413, 415, 422, 503),
)
async def use_hand_down(here: Here, id: Id, wanted: UseRequest) -> HandedDownReply:
    """Put on record that somebody used what was handed down, and for what; the plant sees it as well."""
    kept = HandedDownRepository(here.database)
    await kept.note_use(id, wanted.person, wanted.note)
    return handed_down_reply(await kept.get(id))


def _require_model(record: HandedDownRecord) -> NewHandedDown:
    told = record.handed_down
    if told.kind != "model":
        raise ConflictError(
            f"Hand-down {record.id} is a {told.kind} and no model; a session is planned with it."
        )
    return told
