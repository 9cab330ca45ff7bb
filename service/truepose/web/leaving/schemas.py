"""What a plant is told of a cell, and what it hands down."""

import math
from typing import Any, Final, Literal

from pydantic import Field

from truepose.domain.people.names import LONGEST_NAME
from truepose.exchange.models.document import in_file_units
from truepose.exchange.models.of_cell import HandedModel
from truepose.judgement.largest_shift import FarValue
from truepose.storage.leaving.handed_down import HandedDownRecord
from truepose.web.schemas.base import VISIBLE, FreeDocument, PersonName, RecordedAt, RecordId, Reply, Request

_OF_VALUE: Final = ("name", "value", "unit", "prior_width")
LINES: Final = "application/x-ndjson"  # media type of links


class ChainHeadReply(Reply):
    """How far the chain of a cell goes, and what time it is there."""

    cell: str = Field(description="Name in the cell file.", examples=["left arm"])
    version: str = Field(description="Of the program.", examples=["0.1.0"])
    schema_revision: str = Field(alias="schema", description="Of the database.", examples=["0014"])
    newest: int = Field(description="Number of the newest link.", examples=[4711])
    links: int = Field(description="How many links the head stands for.", examples=[4711])
    head: str = Field(description="As reports print it.", examples=["4711-K3QF-7ZWD-M2PA-XY5R"])
    hash: str | None = Field(
        description="Of the last of these links, in hexadecimal; null: there is none.",
        examples=["9f86d081884c7d659a2feaa0c55ad015a3bf4f1b2b0b822cd15d6c15b0f00a08"],
    )
    time: str = Field(
        description="Time of day as this computer has it: UTC, ISO 8601.",
        examples=["2026-05-04T09:12:33.125000+00:00"],
    )


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

    digest: Literal["intact", "no digest"]
    largest_shift_mm: float = Field(
        description="Of a tool nest or the flange, from the nominal robot as the cell file has it.",
        examples=[137.2],
    )
    at_joints_deg: list[float] = Field(examples=[[0.0, 90.0, 0.0, 0.0, 0.0, 0.0]])
    nest: int = Field(description="Which is moved so far; 0: the flange.", examples=[1])
    limit_mm: float = Field(description="`model_shift_mm` of the cell file.", examples=[5.0])
    far_from_prior: list[FarValueReply]
    confirmation_needed: bool = Field(description="It is accepted only with `accepted_shift_mm`.")


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
    said_by: str = Field(
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
    shift = handed.shift
    return ModelCheckReply.model_validate({
        "digest": handed.integrity.value,
        "largest_shift_mm": shift.shift_mm,
        "at_joints_deg": [math.degrees(angle) for angle in shift.joints_rad],
        "nest": shift.nest,
        "limit_mm": handed.limit_mm,
        "far_from_prior": [_far_value(one) for one in handed.far],
        "confirmation_needed": handed.needs_confirmation,
    })


def _far_value(far: FarValue) -> FarValueReply:
    fields = {key: value for key, value in in_file_units(far.parameter).items() if key in _OF_VALUE}
    return FarValueReply.model_validate(fields | {"widths": far.widths})


def handed_down_reply(record: HandedDownRecord) -> HandedDownReply:
    """Return what was handed down, as it travels."""
    told = record.handed_down
    return HandedDownReply.model_validate({
        "id": record.id,
        "recorded_at": record.recorded_at,
        "plant": told.plant,
        "kind": told.kind,
        "name": told.name,
        "person": told.person,
        "said_by": told.plant,
        "document": told.document,
        "model_id": record.model_id,
        "uses": [
            {"recorded_at": use.recorded_at, "person": use.person, "note": use.note} for use in record.uses
        ],
    })
