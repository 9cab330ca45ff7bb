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
    """A plan or a model pushed by a plant."""

    person_asks = False  # the plant's service asks, for somebody whom the cell need not know
    kind: Literal["plan", "model"]
    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["monthly check"])
    person: str = Field(
        min_length=1,
        max_length=LONGEST_NAME,
        description="Person at the plant who pushes the plan or model.",
        examples=["Ada Byron"],
    )
    document: FreeDocument = Field(
        description="For a plan, the body of `POST /sessions`; for a model, the model as downloaded.",
        examples=[{"name": "monthly check"}],
    )


class UseRequest(Request):
    """Person who used a pushed plan or model."""

    person: PersonName
    note: str = Field(
        default="",
        max_length=1000,
        description="Purpose of the use.",
        examples=["Used to plan session 12."],
    )


class AcceptanceRequest(Request):
    """Person who accepts a pushed model, and the accepted shift of the tool."""

    person: PersonName
    accepted_shift_mm: float | None = Field(
        default=None,
        ge=0.0,
        description="Largest shift accepted by the person; required if `confirmation_needed` is true.",
        examples=[8.5],
    )


class FarValueReply(Reply):
    """A value far from its prior, in the units of model files."""

    name: str = Field(examples=["theta_2"])
    value: float = Field(examples=[40.0])
    unit: str = Field(examples=["deg"])
    prior_width: float = Field(examples=[2.86])
    widths: float = Field(description="Deviation in prior standard deviations.", examples=[14.0])


class ModelCheckReply(Reply):
    """Effect of a pushed model on the tool in this cell."""

    digest: Annotated[Literal["intact", "no digest"], FieldSource("integrity")]
    largest_shift_mm: Annotated[float, FieldSource("shift_mm")] = Field(
        description="Largest shift of a tool nest or the flange, relative to the nominal robot in the cell "
        "file.",
        examples=[137.2],
    )
    at_joints_deg: list[float] = Field(examples=[[0.0, 90.0, 0.0, 0.0, 0.0, 0.0]])
    nest: int = Field(description="Nest with the largest shift; 0 for the flange.", examples=[1])
    limit_mm: float = Field(description="Limit from the cell file, `model_shift_mm`.", examples=[5.0])
    far_from_prior: list[FarValueReply]
    confirmation_needed: Annotated[bool, FieldSource("needs_confirmation")] = Field(
        description="True if the model is accepted only with `accepted_shift_mm`."
    )


class UseReply(Reply):
    """A recorded use of a pushed plan or model."""

    recorded_at: RecordedAt
    person: str
    note: str = Field(examples=["Used to plan session 12."])


class HandedDownReply(Reply):
    """A plan or a model pushed by a plant."""

    id: RecordId
    recorded_at: RecordedAt
    plant: str = Field(
        description="Name of the plant's token; empty if the cell has no accounts.", examples=["plant"]
    )
    kind: Literal["plan", "model"]
    name: str = Field(examples=["monthly check"])
    person: str = Field(description="Person at the plant who pushed the plan or model.")
    said_by: Annotated[str, FieldSource("plant")] = Field(
        description="Plant that named the person, who need not be known to the cell; empty if the cell has "
        "no accounts.",
        examples=["plant"],
    )
    document: dict[str, Any] = Field(examples=[{"name": "monthly check"}])
    uses: list[UseReply]
    model_id: RecordId | None = Field(
        description="Number of the model after acceptance in this cell; null if it was not accepted.",
        examples=[7],
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
    """Store a plan or a model pushed by the plant; nothing is planned and nothing moves."""
    # The token names the plant. The person is the plant's word alone, as the cell need not know them.
    plant = asker.tablet_name or asker.name
    current_request().reason = f"pushed by {wanted.person}, according to the plant" if plant else None
    new = NewHandedDown(plant, wanted.kind, wanted.name, wanted.person, wanted.document)
    kept = HandedDownRepository(here.database)
    number = await kept.add(new, key)
    response.headers["Location"] = f"/api/v1/hand-downs/{number}"
    return handed_down_reply(await kept.get(number))


@router.get("", responses=LIST)
async def list_hand_downs(here: Here, paging: Paged) -> list[HandedDownReply]:
    """List the plans and models pushed by the plant, oldest first."""
    return paging.shown(await HandedDownRepository(here.database).page(paging.page), handed_down_reply)


@router.get("/{id}", responses=READ)
async def get_hand_down(here: Here, id: Id) -> HandedDownReply:
    """Return a pushed plan or model; a plan is the body of `POST /sessions`."""
    return handed_down_reply(await HandedDownRepository(here.database).get(id))


@router.get("/{id}/check", responses=ACT)
async def get_hand_down_check(here: Here, id: Id) -> ModelCheckReply:
    """Return how far a pushed model shifts the tool in this cell, and its values far from their priors."""
    told = _require_model(await HandedDownRepository(here.database).get(id))
    return model_check_reply(await asyncio.to_thread(fitting_model, told.document, here.cell))


@router.post("/{id}/acceptance", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def accept_handed_down_model(
    here: Here, id: Id, wanted: AcceptanceRequest, response: Response
) -> ModelReply:
    """Accept a pushed model as a model of this cell; the robot and tool must be the same.

    It can then correct programs and be validated like a model identified here. It can be accepted once (409).
    If it shifts the tool by more than the limit of the cell, the shift must be confirmed (409 gives the
    shift).
    """
    kept = HandedDownRepository(here.database)
    told = _require_model(await kept.get(id))
    model = await asyncio.to_thread(accepted_model, told.document, here.cell, wanted.accepted_shift_mm)
    number = await kept.accept_model(id, model, wanted.person)
    response.headers["Location"] = f"/api/v1/models/{number}"
    return model_reply(await here.results.model(number))


@router.post("/{id}/uses", status_code=status.HTTP_201_CREATED, responses=CHANGE)
async def use_hand_down(here: Here, id: Id, wanted: UseRequest) -> HandedDownReply:
    """Record that a person used a pushed plan or model, and its purpose; the plant sees this record."""
    kept = HandedDownRepository(here.database)
    await kept.note_use(id, wanted.person, wanted.note)
    return handed_down_reply(await kept.get(id))


def _require_model(record: HandedDownRecord) -> NewHandedDown:
    told = record.handed_down
    if told.kind != "model":
        raise ConflictError(message("refused.not_a_model", number=record.id, kind=str(told.kind)))
    return told
