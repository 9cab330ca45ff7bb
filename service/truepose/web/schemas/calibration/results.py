"""Identifications, validations and models: requests, records, and the documents of the command line."""

from typing import Annotated

from pydantic import Field

from truepose.effects.registry import EFFECTS
from truepose.exchange.outgoing import Quantity
from truepose.exchange.results.identification import IdentificationDocument, ParameterDocument
from truepose.exchange.results.validation import ValidationDocument
from truepose.storage.records import IdentificationRecord, ModelRecord, ValidationRecord
from truepose.web.schemas.base import Number, RecordedAt, RecordId, Reply, Request, Simulated, example

EffectName = Annotated[str, Field(examples=["geometry"], json_schema_extra={"enum": sorted(EFFECTS)})]

EffectNames = Annotated[
    list[EffectName], Field(min_length=1, max_length=32, json_schema_extra={"uniqueItems": True})
]


class IdentificationRequest(Request):
    """A campaign to identify."""

    model_config = example({"campaign_id": 1, "effects": ["base", "tool", "geometry", "compliance"]})

    campaign_id: Number
    effects: EffectNames | None = Field(
        None,
        description="Names of effects; null: base, tool as far as unknown, geometry, and compliance "
        "where the campaign gives masses or torques.",
    )


class ValidationRequest(Request):
    """A model to judge on the validation readings of a campaign."""

    model_config = example({"model_id": 1, "campaign_id": 1, "limit_mm": 0.1})

    model_id: Number
    campaign_id: Number
    limit_mm: float | None = Field(
        None,
        gt=0,
        le=1000,
        description="Largest error that passes; null: the mean error must be below the nominal model's "
        "and in keeping with what the model claims.",
    )


class IdentificationReply(Reply):
    """A stored identification; `model_id` is null where nothing could be identified."""

    id: RecordId
    recorded_at: RecordedAt
    job_id: RecordId
    campaign_id: RecordId
    model_id: int | None = Field(examples=[3])
    simulated: Simulated
    document: IdentificationDocument


class ValidationReply(Reply):
    """A stored validation."""

    id: RecordId
    recorded_at: RecordedAt
    job_id: RecordId
    model_id: RecordId
    campaign_id: RecordId
    simulated: Simulated
    document: ValidationDocument


class ModelReply(Reply):
    """An identified model; its file holds all of it, for `truepose predict` and `correct`."""

    id: RecordId
    recorded_at: RecordedAt
    identification_id: RecordId | None = Field(description="Which made it; null: it did not come of one.")
    diagnosis_id: RecordId | None = Field(description="Which made it; null: it did not come of one.")
    handed_down_id: RecordId | None = Field(
        description="Under which number a plant handed it down; null: it was made here."
    )
    accepted_by: str | None = Field(description="Who accepted it; null: it was made here.")
    robot: str = Field(examples=["ABB IRB 120"])
    simulated: Simulated
    effects: list[str] = Field(examples=[["base", "geometry", "compliance"]])
    parameters: list[ParameterDocument]
    repeatability_mm: Quantity = Field(description="Of the arm, per axis.", examples=[0.0035])
    discrepancy_mm: Quantity = Field(description="What held-out residuals show beyond noise, per axis.")
    program_version: str
    file_url: str = Field(examples=["/api/v1/models/3/file"])


def identification_reply(record: IdentificationRecord) -> IdentificationReply:
    """Return an identification as it travels."""
    document = IdentificationDocument.of_robot(record.identification, record.robot)
    return IdentificationReply.of(record, document=document)


def validation_reply(record: ValidationRecord) -> ValidationReply:
    """Return a validation as it travels."""
    return ValidationReply.of(record, document=record.validation)


def model_reply(record: ModelRecord) -> ModelReply:
    """Return a model as it travels."""
    file_url = f"/api/v1/models/{record.id}/file"
    return ModelReply.of(record, record.model, robot=record.robot, file_url=file_url)
