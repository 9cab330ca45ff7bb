"""Identifications, and validations of their models on other readings: ask for one, read the answer."""

from typing import Annotated

from fastapi import Response, status
from pydantic import Field

from truepose.domain.campaign import ReadingName, ReadingsSetAside
from truepose.effects.registry import EFFECTS, chosen_effects
from truepose.exchange.results.document import FieldSource
from truepose.exchange.results.identification import IdentificationDocument
from truepose.exchange.results.validation import ValidationDocument
from truepose.storage.records import IdentificationRecord
from truepose.web.api.jobs import JobReply, queued_job
from truepose.web.context import Context, Here
from truepose.web.resources import CHANGE, LIST, READ, Id, OptionalKey, Paged, Sender, resource
from truepose.web.schemas import (
    NUMBER_LIMIT,
    VISIBLE,
    Number,
    PersonName,
    RecordedAt,
    RecordId,
    Reply,
    Request,
    Simulated,
    example,
)

EffectName = Annotated[str, Field(examples=["geometry"], json_schema_extra={"enum": sorted(EFFECTS)})]

EffectNames = Annotated[
    list[EffectName], Field(min_length=1, max_length=32, json_schema_extra={"uniqueItems": True})
]


class ReadingNameRequest(Request):
    """A reading of a campaign."""

    config: int = Field(ge=0, le=NUMBER_LIMIT, description="Number of the configuration.", examples=[12])
    nest: Number = Field(description="Tool nest, starting at 1.", examples=[2])
    base_point: Number | None = Field(None, description="Base point of a length; null for any.")
    target: Number | None = Field(None, description="Target of a contact; null for any.")


class SetAsideRequest(Request):
    """Readings to exclude from an analysis; the campaign keeps them, and the result lists them."""

    model_config = example({
        "person": "Ada Byron",
        "reason": "a cable lay in the beam",
        "readings": [{"config": 12, "nest": 2}],
    })

    person: PersonName = Field(description="Who sets the readings aside.")
    reason: str = Field(min_length=1, max_length=500, pattern=VISIBLE, examples=["a cable lay in the beam"])
    readings: list[ReadingNameRequest] = Field(
        min_length=1,
        max_length=10_000,
        description="Calibration readings, at most one in five; validation readings cannot be set aside.",
    )

    @property
    def wanted(self) -> ReadingsSetAside:
        """The readings, reason and person."""
        return self.into(ReadingsSetAside, readings=tuple(one.into(ReadingName) for one in self.readings))


SetAside = Annotated[
    SetAsideRequest | None,
    Field(description="Readings to exclude from the analysis; null to use all readings."),
]

KeepSetAside = Annotated[
    bool,
    Field(
        description="Also exclude the readings that the latest identification or diagnosis of the same "
        "session, or of the same uploaded campaign, excluded; ignored if `set_aside` is given.",
    ),
]


class IdentificationRequest(Request):
    """A campaign to identify."""

    model_config = example({"campaign_id": 1, "effects": ["base", "tool", "geometry", "compliance"]})

    campaign_id: Number
    effects: EffectNames | None = Field(
        None,
        description="Names of effects. Null: base, unknown tool parameters, geometry, and compliance if "
        "the campaign states masses or torques.",
    )
    set_aside: SetAside = None
    keep_set_aside: KeepSetAside = False


class ValidationRequest(Request):
    """A model to validate on the validation readings of a campaign."""

    model_config = example({"model_id": 1, "campaign_id": 1, "limit_mm": 0.1})

    model_id: Number
    campaign_id: Number
    limit_mm: float | None = Field(
        None,
        gt=0,
        le=1000,
        description="Largest permissible error. Null: the mean error must be below that of the nominal "
        "model and consistent with the accuracy stated by the model.",
    )


class IdentificationReply(Reply):
    """A stored identification; `model_id` is null if nothing could be identified."""

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
    document: Annotated[ValidationDocument, FieldSource("validation")]


def identification_reply(record: IdentificationRecord) -> IdentificationReply:
    """Return an identification as it travels."""
    document = IdentificationDocument.of_robot(record.identification, record.robot)
    return IdentificationReply.of(record, document=document)


async def readings_to_set_aside(
    here: Context, campaign_id: int, wanted: SetAsideRequest | None, *, keep: bool
) -> ReadingsSetAside | None:
    """Return what a campaign is to be analysed without: what is wanted, else what was set aside before."""
    if wanted is not None:
        return wanted.wanted
    return await here.set_aside.of_campaign(campaign_id) if keep else None


router = resource("/identifications", tags=["identifications"])


@router.post("", status_code=status.HTTP_202_ACCEPTED, responses=CHANGE)
async def identify_campaign(
    here: Here, wanted: IdentificationRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Identify a campaign in a worker process; the result of the job is the identification."""
    effects = None if wanted.effects is None else chosen_effects(wanted.effects)
    aside = await readings_to_set_aside(
        here, wanted.campaign_id, wanted.set_aside, keep=wanted.keep_set_aside
    )
    number = await here.job_desk.identify(wanted.campaign_id, effects, key, sender, set_aside=aside)
    return await queued_job(here, number, response)


@router.get("", response_model_exclude_unset=True, responses=LIST)
async def list_identifications(here: Here, paging: Paged) -> list[IdentificationReply]:
    """List identifications, oldest first."""
    return paging.shown(await here.results.identifications(paging.page), identification_reply)


@router.get("/{id}", response_model_exclude_unset=True, responses=READ)
async def get_identification(here: Here, id: Id) -> IdentificationReply:
    """Return an identification, as printed by `truepose identify --json`."""
    return identification_reply(await here.results.identification(id))


validations_router = resource("/validations", tags=["validations"])


@validations_router.post("", status_code=status.HTTP_202_ACCEPTED, responses=CHANGE)
async def validate_model(
    here: Here, wanted: ValidationRequest, response: Response, key: OptionalKey, sender: Sender
) -> JobReply:
    """Validate a model in a worker process; the result of the job is the validation."""
    number = await here.job_desk.validate(wanted.model_id, wanted.campaign_id, wanted.limit_mm, key, sender)
    return await queued_job(here, number, response)


@validations_router.get("", responses=LIST)
async def list_validations(here: Here, paging: Paged) -> list[ValidationReply]:
    """List validations, oldest first."""
    return paging.shown(await here.results.validations(paging.page), ValidationReply.of)


@validations_router.get("/{id}", responses=READ)
async def get_validation(here: Here, id: Id) -> ValidationReply:
    """Return a validation, as printed by `truepose validate --json`."""
    return ValidationReply.of(await here.results.validation(id))
