"""What pictures and charts are drawn from: results and plans in space, and how far each reading is off."""

import asyncio
from dataclasses import dataclass
from typing import Annotated, Final, Literal, TypeAlias

from fastapi import Query
from pydantic import BeforeValidator, Field

from truepose.analysis.job_queue.tasks import judging_or_own, stored_campaign
from truepose.domain.campaign import Quantity, Readings, ReadingsSetAside
from truepose.domain.identification import Model
from truepose.exchange.results.document import Integers, Quantities
from truepose.storage.errors import NotFoundError
from truepose.web.context import Context, Here
from truepose.web.resources import ACT, Id, resource
from truepose.web.schemas import NUMBER_LIMIT, Point, Reply

StopState: TypeAlias = Literal["measured", "skipped", "to_come"]


def _rounded(decimals: int) -> BeforeValidator:
    """Return what takes an array with the digits that a picture or a chart needs."""
    return BeforeValidator(lambda values: values.round(decimals).tolist())


_PLACES: Final = _rounded(1)
_ERRORS: Final = _rounded(5)
_VALUES: Final = _rounded(3)  # micrometres, thousandths of a degree
ErrorMm = Annotated[float, BeforeValidator(lambda error_mm: round(error_mm, 5))]
Capsules = Annotated[list[list[float]], _PLACES]


class PoseReply(Reply):
    """The arm in one configuration."""

    config: int = Field(examples=[12])
    pieces_mm: Capsules = Field(
        description="Links and tool as capsules: start (3), end (3) and radius, in the world frame.",
        examples=[[[0.0, 0.0, 0.0, 0.0, 0.0, 290.0, 90.0]]],
    )
    before_mm: ErrorMm = Field(
        description="Largest error of the nominal robot in this configuration.", examples=[1.21]
    )
    after_mm: ErrorMm = Field(
        description="Largest error of the identified model in this configuration.", examples=[0.052]
    )


class SpaceReply(Reply):
    """Readings in 3D, with errors before and after identification (measured minus predicted)."""

    robot: str = Field(examples=["ABB IRB 120"])
    points_mm: Annotated[list[Point], _PLACES] = Field(
        description="Measured tool positions, in the world frame."
    )
    before_mm: Annotated[list[Point], _ERRORS] = Field(
        description="Errors of the nominal robot with fitted base and tool."
    )
    after_mm: Annotated[list[Point], _ERRORS] = Field(description="Errors of the identified model.")
    times_before: float = Field(
        description="Recommended magnification of the error vectors before identification.", examples=[200.0]
    )
    times_after: float = Field(examples=[2000.0])
    poses: list[PoseReply] = Field(
        description="Configurations with the largest errors of the identified model, largest first."
    )
    instrument_mm: Point | None = Field(description="Position of the tracker; null if not known.")
    total: int = Field(
        description="Total number of readings; the list contains an evenly spaced selection.", examples=[300]
    )


class PlannedPlaceReply(Reply):
    """Position and configuration at one stop of a plan."""

    config: int = Field(examples=[12])
    state: StopState = Field(examples=["measured"])
    place_mm: Annotated[Point, _PLACES] = Field(
        description="Position of the measured nest, or of the flange if no nest is measured, in the world "
        "frame."
    )
    pieces_mm: Capsules = Field(
        description="Arm, tool and bars as capsules: start (3), end (3) and radius, in the world frame.",
        examples=[[[0.0, 0.0, 0.0, 0.0, 0.0, 290.0, 90.0]]],
    )


class PlanSpaceReply(Reply):
    """A session in 3D, with the nominal robot."""

    robot: str = Field(examples=["ABB IRB 120"])
    stops: list[PlannedPlaceReply] = Field(
        description="Configurations in the order of the plan; an evenly spaced selection if there are many."
    )
    next_config: int | None = Field(
        description="Number of the next configuration; null if no configuration is left."
    )
    fixed_mm: Annotated[list[Point], _PLACES] = Field(description="Fixed nests and cups, in the world frame.")
    instrument_mm: Point | None = Field(description="Position of the tracker; null if not known yet.")


Errors = Annotated[
    list[list[float]],
    _ERRORS,
    Field(
        description="Observed minus predicted: x, y, z for a position, one number for a length.",
        examples=[[[0.012, -0.004, 0.021]]],
    ),
]


class VariableReply(Reply):
    """A variable on which an error may depend, with its value at each reading."""

    name: str = Field(
        description="Name of the variable: joint, torque, reach, x, y, z, number, time, temperature or "
        "attachment.",
        examples=["joint"],
    )
    joint: int | None = Field(
        description="Number of the joint, for an angle or a torque; otherwise null.", examples=[4]
    )
    unit: str = Field(description="Unit of the values; empty for counts.", examples=["deg"])
    values: Annotated[Quantities, _VALUES] = Field(
        description="Value at each reading; null if not known.", examples=[[12.5, -80.0]]
    )


class ResidualsReply(Reply):
    """Residuals of a result, with one entry per reading in each list."""

    robot: str = Field(examples=["ABB IRB 120"])
    quantity: Quantity = Field(examples=["position"])
    config: Integers = Field(description="Configuration of each reading.", examples=[[1, 1, 2]])
    nest: Integers = Field(description="Tool nest of each reading, starting at 1.", examples=[[1, 2, 1]])
    base_point: Integers | None = Field(description="Base point of each length; null for other readings.")
    target: Integers | None = Field(description="Target of each contact; null for other readings.")
    before_mm: Errors
    after_mm: Errors
    expected_mm: Annotated[list[float], _ERRORS] = Field(
        description="Expected RMS error from noise, repeatability and the uncertainty of the model.",
        examples=[[0.031, 0.029, 0.033]],
    )
    variables: list[VariableReply]


router = resource(tags=["spaces"])
IdentifiedFrom = Annotated[
    bool,
    Query(description="True: the calibration readings, even if the campaign has validation readings."),
]
FirstConfig = Annotated[
    int | None,
    Query(
        ge=0,
        le=NUMBER_LIMIT,
        description="Configuration to show first.",
        examples=[12],
    ),
]


@router.get("/identifications/{id}/space", responses=ACT)
async def get_identification_space(
    here: Here, id: Id, config: FirstConfig = None, identified_from: IdentifiedFrom = False
) -> SpaceReply:
    """Return errors in 3D at the validation readings, or else at the calibration readings."""
    record = await here.results.identification(id)
    shown = _Shown(record.identification.set_aside, identified_from)
    return await _space(here, record.model_id, record.campaign_id, shown, config)


@router.get("/validations/{id}/space", responses=ACT)
async def get_validation_space(here: Here, id: Id, config: FirstConfig = None) -> SpaceReply:
    """Return errors in 3D at the readings used for the validation."""
    record = await here.results.validation(id)
    return await _space(here, record.model_id, record.campaign_id, _Shown(), config)


@router.get("/diagnoses/{id}/space", responses=ACT)
async def get_diagnosis_space(
    here: Here, id: Id, config: FirstConfig = None, identified_from: IdentifiedFrom = False
) -> SpaceReply:
    """Return errors in 3D of the nominal robot and of the extended model of a diagnosis."""
    record = await here.diagnoses.get(id)
    shown = _Shown(record.diagnosis.set_aside, identified_from)
    return await _space(here, record.model_id, record.campaign_id, shown, config)


@dataclass(frozen=True, slots=True)
class _Shown:
    """Which readings of a campaign a result is held against."""

    set_aside: ReadingsSetAside | None = None
    identified_from: bool = False

    def of(self, content: bytes) -> Readings:
        """Return them; `content` is the campaign as it is stored."""
        campaign = stored_campaign(content, self.set_aside)
        own = campaign.readings
        return judging_or_own(campaign) if own is None or not self.identified_from else own


async def _space(
    here: Context, model_id: int | None, campaign_id: int, shown: _Shown, config: int | None
) -> SpaceReply:
    model, content = await _model_and_campaign(here, model_id, campaign_id)
    return await asyncio.to_thread(_drawn, model, content, shown, config)


def _drawn(model: Model, content: bytes, shown: _Shown, config: int | None) -> SpaceReply:
    from truepose.reports.error_vectors_3d import error_space

    return SpaceReply.of(error_space(model, shown.of(content), config))


residuals_router = resource(tags=["residuals"])


@residuals_router.get("/identifications/{id}/residuals", responses=ACT)
async def get_identification_residuals(
    here: Here, id: Id, identified_from: IdentifiedFrom = False
) -> ResidualsReply:
    """Return the residual of each validation reading, or else of each calibration reading."""
    record = await here.results.identification(id)
    shown = _Shown(record.identification.set_aside, identified_from)
    return await _residuals(here, record.model_id, record.campaign_id, shown)


@residuals_router.get("/validations/{id}/residuals", responses=ACT)
async def get_validation_residuals(here: Here, id: Id) -> ResidualsReply:
    """Return the residual of each reading used for the validation."""
    record = await here.results.validation(id)
    return await _residuals(here, record.model_id, record.campaign_id, _Shown())


@residuals_router.get("/diagnoses/{id}/residuals", responses=ACT)
async def get_diagnosis_residuals(
    here: Here, id: Id, identified_from: IdentifiedFrom = False
) -> ResidualsReply:
    """Return the residuals of the nominal robot and of the extended model of a diagnosis."""
    record = await here.diagnoses.get(id)
    shown = _Shown(record.diagnosis.set_aside, identified_from)
    return await _residuals(here, record.model_id, record.campaign_id, shown)


async def _residuals(here: Context, model_id: int | None, campaign_id: int, shown: _Shown) -> ResidualsReply:
    model, content = await _model_and_campaign(here, model_id, campaign_id)
    return await asyncio.to_thread(_judged, model, content, shown)


def _judged(model: Model, content: bytes, shown: _Shown) -> ResidualsReply:
    from truepose.reports.reading_residuals import reading_residuals

    return ResidualsReply.of(reading_residuals(model, shown.of(content)))


async def _model_and_campaign(here: Context, model_id: int | None, campaign_id: int) -> tuple[Model, bytes]:
    """Return a model and, as it is stored, the campaign that it is held against.

    The campaign is unpacked off the loop: a session that measures waits for no picture. Raises NotFoundError
    where the result has no model.
    """
    if model_id is None:
        raise NotFoundError("model of that result", campaign_id)
    return (await here.results.model(model_id)).model, await here.campaigns.content(campaign_id)
