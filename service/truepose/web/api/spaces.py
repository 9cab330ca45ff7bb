"""What pictures and charts are drawn from: results and plans in space, and how far each reading is off."""

import asyncio
from typing import Annotated, Final, Literal, TypeAlias

from fastapi import Query
from pydantic import BeforeValidator, Field

from truepose.analysis.job_queue.tasks import judging_or_own, stored_campaign
from truepose.domain.campaign import Quantity
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
        description="Links and tool as capsules: start (3), end (3) and radius, in the world.",
        examples=[[[0.0, 0.0, 0.0, 0.0, 0.0, 290.0, 90.0]]],
    )
    before_mm: ErrorMm = Field(description="Largest error there of the nominal robot.", examples=[1.21])
    after_mm: ErrorMm = Field(description="Of the identified model.", examples=[0.052])


class SpaceReply(Reply):
    """Readings in space, before and after; vectors are seen minus foreseen."""

    robot: str = Field(examples=["ABB IRB 120"])
    points_mm: Annotated[list[Point], _PLACES] = Field(description="Where the tool stood, in the world.")
    before_mm: Annotated[list[Point], _ERRORS] = Field(
        description="Errors of the nominal robot, base and tool fitted."
    )
    after_mm: Annotated[list[Point], _ERRORS] = Field(description="Errors of the identified model.")
    times_before: float = Field(
        description="How many times longer the errors are best drawn.", examples=[200.0]
    )
    times_after: float = Field(examples=[2000.0])
    poses: list[PoseReply] = Field(description="The arm where the identified model is worst, worst first.")
    instrument_mm: Point | None = Field(description="Where the tracker stood; null: not known.")
    total: int = Field(description="Readings, of which an even selection is given.", examples=[300])


class PlannedPlaceReply(Reply):
    """Where a plan sends the arm."""

    config: int = Field(examples=[12])
    state: StopState = Field(examples=["measured"])
    place_mm: Annotated[Point, _PLACES] = Field(
        description="Of the nest that is measured there, else of the flange; world."
    )
    pieces_mm: Capsules = Field(
        description="Arm, tool and bars as capsules: start (3), end (3) and radius, in the world.",
        examples=[[[0.0, 0.0, 0.0, 0.0, 0.0, 290.0, 90.0]]],
    )


class PlanSpaceReply(Reply):
    """A session in space, by the nominal robot."""

    robot: str = Field(examples=["ABB IRB 120"])
    stops: list[PlannedPlaceReply] = Field(description="In the order of the plan; of many an even selection.")
    next_config: int | None = Field(description="The configuration that comes next; null: none is left.")
    fixed_mm: Annotated[list[Point], _PLACES] = Field(description="Fixed nests and cups, in the world.")
    instrument_mm: Point | None = Field(description="Where the tracker stands; null: not known yet.")


Errors = Annotated[
    list[list[float]],
    _ERRORS,
    Field(
        description="Observed minus predicted: x, y, z of a position, one number of a length.",
        examples=[[[0.012, -0.004, 0.021]]],
    ),
]


class VariableReply(Reply):
    """What an error may depend on, of each reading."""

    name: str = Field(
        description="joint, torque, reach, x, y, z, number, time, temperature or attachment.",
        examples=["joint"],
    )
    joint: int | None = Field(description="Of an angle or a torque; null otherwise.", examples=[4])
    unit: str = Field(description="Empty of what is counted.", examples=["deg"])
    values: Annotated[Quantities, _VALUES] = Field(
        description="Null where it is not known.", examples=[[12.5, -80.0]]
    )


class ResidualsReply(Reply):
    """The readings of a result, a value of each column for each reading."""

    robot: str = Field(examples=["ABB IRB 120"])
    quantity: Quantity = Field(examples=["position"])
    config: Integers = Field(description="Number of the configuration.", examples=[[1, 1, 2]])
    nest: Integers = Field(description="Of the tool, from 1.", examples=[[1, 2, 1]])
    before_mm: Errors
    after_mm: Errors
    expected_mm: Annotated[list[float], _ERRORS] = Field(
        description="Root mean square of the size to be expected of noise, scatter and the uncertain model.",
        examples=[[0.031, 0.029, 0.033]],
    )
    variables: list[VariableReply]


router = resource(tags=["spaces"])
FirstConfig = Annotated[
    int | None,
    Query(
        ge=0,
        le=NUMBER_LIMIT,
        description="A configuration whose arm comes first among the poses.",
        examples=[12],
    ),
]


@router.get("/identifications/{id}/space", responses=ACT)
async def get_identification_space(here: Here, id: Id, config: FirstConfig = None) -> SpaceReply:
    """Show errors where the tool stood: at readings kept for validation, else at those identified from."""
    record = await here.results.identification(id)
    return await _space(here, record.model_id, record.campaign_id, config)


@router.get("/validations/{id}/space", responses=ACT)
async def get_validation_space(here: Here, id: Id, config: FirstConfig = None) -> SpaceReply:
    """Show errors where the tool stood, at the readings that judged the model."""
    record = await here.results.validation(id)
    return await _space(here, record.model_id, record.campaign_id, config)


@router.get("/diagnoses/{id}/space", responses=ACT)
async def get_diagnosis_space(here: Here, id: Id, config: FirstConfig = None) -> SpaceReply:
    """Show errors where the tool stood: of the nominal robot, and of the model a diagnosis ends with."""
    record = await here.diagnoses.get(id)
    return await _space(here, record.model_id, record.campaign_id, config)


async def _space(here: Context, model_id: int | None, campaign_id: int, config: int | None) -> SpaceReply:
    model, content = await _model_and_campaign(here, model_id, campaign_id)
    return await asyncio.to_thread(_drawn, model, content, config)


def _drawn(model: Model, content: bytes, config: int | None) -> SpaceReply:
    from truepose.reports.error_vectors_3d import error_space

    return SpaceReply.of(error_space(model, judging_or_own(stored_campaign(content)), config))


residuals_router = resource(tags=["residuals"])


@residuals_router.get("/identifications/{id}/residuals", responses=ACT)
async def get_identification_residuals(here: Here, id: Id) -> ResidualsReply:
    """Show how far each reading is off: of those kept for validation, else of those identified from."""
    record = await here.results.identification(id)
    return await _residuals(here, record.model_id, record.campaign_id)


@residuals_router.get("/validations/{id}/residuals", responses=ACT)
async def get_validation_residuals(here: Here, id: Id) -> ResidualsReply:
    """Show how far each reading is off, of those that judged the model."""
    record = await here.results.validation(id)
    return await _residuals(here, record.model_id, record.campaign_id)


@residuals_router.get("/diagnoses/{id}/residuals", responses=ACT)
async def get_diagnosis_residuals(here: Here, id: Id) -> ResidualsReply:
    """Show how far each reading is off: of the nominal robot, and of the model a diagnosis ends with."""
    record = await here.diagnoses.get(id)
    return await _residuals(here, record.model_id, record.campaign_id)


async def _residuals(here: Context, model_id: int | None, campaign_id: int) -> ResidualsReply:
    model, content = await _model_and_campaign(here, model_id, campaign_id)
    return await asyncio.to_thread(_judged, model, content)


def _judged(model: Model, content: bytes) -> ResidualsReply:
    from truepose.reports.reading_residuals import reading_residuals

    return ResidualsReply.of(reading_residuals(model, judging_or_own(stored_campaign(content))))


async def _model_and_campaign(here: Context, model_id: int | None, campaign_id: int) -> tuple[Model, bytes]:
    """Return a model and, as it is stored, the campaign that it is held against.

    The campaign is unpacked off the loop: a session that measures waits for no picture. Raises NotFoundError
    where the result has no model.
    """
    if model_id is None:
        raise NotFoundError("model of that result", campaign_id)
    return (await here.results.model(model_id)).model, await here.campaigns.content(campaign_id)
