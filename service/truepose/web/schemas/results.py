"""Identifications, validations and models: requests, records, and the documents of the command line."""

from typing import Annotated, Any, Literal

from pydantic import BaseModel, ConfigDict, Field

from truepose.domain.results import Status
from truepose.effects.registry import EFFECTS
from truepose.exchange.models.document import model_document
from truepose.exchange.results.documents import identification_document, validation_document
from truepose.storage.records import IdentificationRecord, ModelRecord, ValidationRecord
from truepose.web.schemas.base import Number, RecordedAt, RecordId, Reply, Request, Simulated, example

EffectName = Annotated[str, Field(examples=["geometry"], json_schema_extra={"enum": sorted(EFFECTS)})]

EffectNames = Annotated[
    list[EffectName], Field(min_length=1, max_length=32, json_schema_extra={"uniqueItems": True})
]


class Document(BaseModel):
    """A document of the command line; keys may be added to it, never renamed."""

    model_config = ConfigDict(extra="allow")


class StatisticsDocument(Document):
    """Norms of errors of n observations; `noise_mm` is the mean norm that stated uncertainties alone give."""

    n: int = Field(examples=[50])
    mean_mm: float | None = Field(examples=[0.021])
    rms_mm: float | None = Field(examples=[0.023])
    sd_mm: float | None = Field(examples=[0.009])
    max_mm: float | None = Field(examples=[0.047])
    noise_mm: float | None = Field(examples=[0.019])


class PairDocument(Document):
    """The same statistics for the nominal model and the identified one."""

    nominal: StatisticsDocument
    identified: StatisticsDocument


class BlocksDocument(Document):
    """Statistics by the readings they are of; `cross_validation` stands where there is no `validation`."""

    calibration: PairDocument | None = None
    calibration_without_outliers: PairDocument | None = None
    validation: PairDocument | None = None
    cross_validation: PairDocument | None = None
    validation_position: PairDocument | None = Field(
        None, description="Of a model of lengths: held-out positions, tied to the world by the measured cups."
    )
    validation_position_aligned: PairDocument | None = Field(
        None, description="Of a model of lengths: held-out positions after the best rigid alignment."
    )


class ParameterDocument(Document):
    """An identified parameter in the unit that it names."""

    name: str = Field(examples=["a_3"])
    effect: str = Field(examples=["geometry"])
    value: float | None = Field(examples=[0.236])
    unit: str = Field(examples=["mm"])
    standard_uncertainty: float | None = Field(examples=[0.011])


class NotIdentifiableDocument(Document):
    """Parameters that the data see only together, or not at all."""

    parameters: list[str] = Field(examples=[["theta_6", "nest_1_x"]])
    reason: str


class OutlierDocument(Document):
    """A reading that was given no weight; it stays in the data."""

    config: int
    reason: str


class CountsDocument(Document):
    """How many of what took part."""

    configurations: int
    observations: int
    parameters: int
    outliers: int


class IdentificationDocument(Document):
    """What `truepose identify --json` prints."""

    robot: str
    status: Status
    message: str
    quantity: Literal["position", "length"]
    effects: list[str]
    counts: CountsDocument
    parameters: list[ParameterDocument]
    not_identifiable: list[NotIdentifiableDocument]
    outliers: list[OutlierDocument]
    statistics: BlocksDocument
    chi2_per_dof: float | None


class ValidationDocument(Document):
    """What `truepose validate --json` prints."""

    quantity: Literal["position", "length"]
    position: PairDocument
    distance: PairDocument | None
    limit_mm: float | None
    passed: bool = Field(alias="pass")


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
    identification_id: RecordId | None = Field(description="Which made it; null: a diagnosis did.")
    diagnosis_id: RecordId | None = Field(description="Which made it; null: an identification did.")
    robot: str = Field(examples=["ABB IRB 120"])
    simulated: Simulated
    effects: list[str] = Field(examples=[["base", "geometry", "compliance"]])
    parameters: list[ParameterDocument]
    repeatability_mm: float | None = Field(description="Of the arm, per axis.", examples=[0.0035])
    discrepancy_mm: float | None = Field(description="What held-out residuals show beyond noise, per axis.")
    program_version: str
    file_url: str = Field(examples=["/api/v1/models/3/file"])


def identification_reply(record: IdentificationRecord) -> IdentificationReply:
    """Return an identification as it travels."""
    document = identification_document(record.identification, record.robot)
    return IdentificationReply(
        id=record.id,
        recorded_at=record.recorded_at,
        job_id=record.job_id,
        campaign_id=record.campaign_id,
        model_id=record.model_id,
        simulated=record.simulated,
        document=IdentificationDocument.model_validate(document),
    )


def validation_reply(record: ValidationRecord) -> ValidationReply:
    """Return a validation as it travels."""
    return ValidationReply(
        id=record.id,
        recorded_at=record.recorded_at,
        job_id=record.job_id,
        model_id=record.model_id,
        campaign_id=record.campaign_id,
        simulated=record.simulated,
        document=ValidationDocument.model_validate(validation_document(record.validation)),
    )


def model_reply(record: ModelRecord) -> ModelReply:
    """Return a model as it travels."""
    document: dict[str, Any] = model_document(record.model)
    return ModelReply(
        id=record.id,
        recorded_at=record.recorded_at,
        identification_id=record.identification_id,
        diagnosis_id=record.diagnosis_id,
        robot=record.robot,
        simulated=record.simulated,
        effects=document["effects"],
        parameters=[ParameterDocument.model_validate(entry) for entry in document["parameters"]],
        repeatability_mm=document["repeatability_mm"],
        discrepancy_mm=document["discrepancy_mm"],
        program_version=document["program_version"],
        file_url=f"/api/v1/models/{record.id}/file",
    )
