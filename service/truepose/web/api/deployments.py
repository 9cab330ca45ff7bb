"""Models and plans that the plant hands down to this cell: kept and shown, and used by a person or nobody."""

import asyncio
import math
from typing import Annotated, Any, Final, Literal

from fastapi import Response, status
from pydantic import Field

from truepose.domain.people import LONGEST_NAME
from truepose.exchange.models.acceptance import HandedModel, accepted_model, fitting_model
from truepose.exchange.models.document import in_file_units
from truepose.exchange.results.document import FieldSource
from truepose.messages.message import message
from truepose.storage.errors import ConflictError
from truepose.storage.plant.deployments import HandedDownRecord, HandedDownRepository, NewHandedDown
from truepose.validation.model_comparison import FarValue
from truepose.web.api.models import ModelReply, model_reply
from truepose.web.context import Here
from truepose.web.middleware.rights import CurrentCaller, current_request
from truepose.web.resources import ACT, CHANGE, LIST, READ, Id, Paged, RequiredKey, resource
from truepose.web.schemas import VISIBLE, FreeDocument, PersonName, RecordedAt, RecordId, Reply, Request

_OF_VALUE: Final = ("name", "value", "unit", "prior_width")


class HandedDownRequest(Request):
    """A plan or a model that a plant hands down."""

    person_asks = False  # the plant's service asks, for somebody whom the cell need not know
    kind: Literal["plan", "model"]
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["monthly check"])
    person: str = Field(
        min_length=1,
        max_length=LONGEST_NAME,
        description="Who hands it down, at the plant.",
        examples=["Ada Byron"],
    )
    document: FreeDocument = Field(
        description="Of a plan, what `POST /sessions` takes; of a model, the model as it is downloaded.",
        examples=[{"name": "monthly check"}],
    )


class UseRequest(Request):
    """Who used what was handed down."""

    person: PersonName
    note: str = Field(
        default="", max_length=1000, description="For what.", examples=["Session 12 was planned with it."]
    )


class AcceptanceRequest(Request):
    """Who accepts a model that was handed down, and which shift of the tool by it."""

    person: PersonName
    accepted_shift_mm: float | None = Field(
        default=None,
        ge=0.0,
        description="Largest shift that the person accepts; asked for where `confirmation_needed`.",
        examples=[8.5],
    )


class FarValueReply(Reply):
    """A value far from what its prior expects, in the units of model files."""

    name: str = Field(examples=["theta_2"])
    value: float = Field(examples=[40.0])
    unit: str = Field(examples=["deg"])
    prior_width: float = Field(examples=[2.86])
    widths: float = Field(description="How many prior widths it is off.", examples=[14.0])


class ModelCheckReply(Reply):
    """What a handed-down model does to the tool in this cell."""

    digest: Annotated[Literal["intact", "no digest"], FieldSource("integrity")]
    largest_shift_mm: Annotated[float, FieldSource("shift_mm")] = Field(
        description="Of a tool nest or the flange, from the nominal robot as the cell file has it.",
        examples=[137.2],
    )
    at_joints_deg: list[float] = Field(examples=[[0.0, 90.0, 0.0, 0.0, 0.0, 0.0]])
    nest: int = Field(description="Which is moved so far; 0: the flange.", examples=[1])
    limit_mm: float = Field(description="`model_shift_mm` of the cell file.", examples=[5.0])
    far_from_prior: list[FarValueReply]
    confirmation_needed: Annotated[bool, FieldSource("needs_confirmation")] = Field(
        description="It is accepted only with `accepted_shift_mm`."
    )


class UseReply(Reply):
    """Somebody used what was handed down."""

    recorded_at: RecordedAt
    person: str
    note: str = Field(examples=["Session 12 was planned with it."])


class HandedDownReply(Reply):
    """A plan or a model that was handed down."""

    id: RecordId
    recorded_at: RecordedAt
    plant: str = Field(description="As its token is called; empty: nobody is asked.", examples=["plant"])
    kind: Literal["plan", "model"]
    name: str = Field(examples=["monthly check"])
    person: str = Field(description="Who handed it down, at the plant.")
    said_by: Annotated[str, FieldSource("plant")] = Field(
        description="The plant that says so; the cell need not know them. Empty: nobody is asked.",
        examples=["plant"],
    )
    document: dict[str, Any] = Field(examples=[{"name": "monthly check"}])
    uses: list[UseReply]
    model_id: RecordId | None = Field(
        description="As which it was accepted in this cell; null: it was not.", examples=[7]
    )


def model_check_reply(handed: HandedModel) -> ModelCheckReply:
    """Return what a model does here, as it travels."""
    return ModelCheckReply.of(
        handed,
        handed.shift,
        at_joints_deg=[math.degrees(angle) for angle in handed.shift.joints_rad],
        far_from_prior=[_far_value(one) for one in handed.far],
    )


def _far_value(far: FarValue) -> FarValueReply:
    fields = {key: value for key, value in in_file_units(far.parameter).items() if key in _OF_VALUE}
    return FarValueReply.model_validate(fields | {"widths": far.widths})


def handed_down_reply(record: HandedDownRecord) -> HandedDownReply:
    """Return what was handed down, as it travels."""
    return HandedDownReply.of(record, record.handed_down)


router = resource("/hand-downs", tags=["plant"])


@router.post("", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def accept_hand_down(
    here: Here, asker: CurrentCaller, response: Response, wanted: HandedDownRequest, key: RequiredKey
) -> HandedDownReply:
    """Keep a plan or a model that the plant hands down. Nothing is planned and nothing moves by it."""
    # The token names the plant. The person is the plant's word alone, as the cell need not know them.
    plant = asker.tablet_name or asker.name
    current_request().reason = f"handed down by {wanted.person}, as the plant says" if plant else None
    new = NewHandedDown(plant, wanted.kind, wanted.name, wanted.person, wanted.document)
    kept = HandedDownRepository(here.database)
    number = await kept.add(new, key)
    response.headers["Location"] = f"/api/v1/hand-downs/{number}"
    return handed_down_reply(await kept.get(number))


@router.get("", responses=LIST)
async def list_hand_downs(here: Here, paging: Paged) -> list[HandedDownReply]:
    """List what the plant handed down, oldest first."""
    return paging.shown(await HandedDownRepository(here.database).page(paging.page), handed_down_reply)


@router.get("/{id}", responses=READ)
async def get_hand_down(here: Here, id: Id) -> HandedDownReply:
    """Show what was handed down: of a plan, the body that `POST /sessions` takes."""
    return handed_down_reply(await HandedDownRepository(here.database).get(id))


@router.get("/{id}/check", responses=ACT)
async def get_hand_down_check(here: Here, id: Id) -> ModelCheckReply:
    """Show how far a handed-down model moves the tool here, and which values are far from their priors."""
    told = _require_model(await HandedDownRepository(here.database).get(id))
    return model_check_reply(await asyncio.to_thread(fitting_model, told.document, here.cell))


@router.post("/{id}/acceptance", status_code=status.HTTP_201_CREATED, responses=CHANGE)
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


@router.post("/{id}/uses", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def use_hand_down(here: Here, id: Id, wanted: UseRequest) -> HandedDownReply:
    """Put on record that somebody used what was handed down, and for what; the plant sees it as well."""
    kept = HandedDownRepository(here.database)
    await kept.note_use(id, wanted.person, wanted.note)
    return handed_down_reply(await kept.get(id))


def _require_model(record: HandedDownRecord) -> NewHandedDown:
    told = record.handed_down
    if told.kind != "model":
        raise ConflictError(message("refused.not_a_model", number=record.id, kind=str(told.kind)))
    return told
