"""Errors in space, as pictures of results show them to be turned; and plans in space."""

import asyncio
from typing import TYPE_CHECKING, Annotated, Any, Literal, TypeAlias

from fastapi import Query
from pydantic import Field

from truepose.analysis.job_queue.tasks import judging_or_own, stored_campaign
from truepose.domain.identification import Model
from truepose.storage.errors import NotFoundError
from truepose.web.context import Context, Here
from truepose.web.resources import ACT, Id, resource
from truepose.web.schemas import NUMBER_LIMIT, Point, Reply

if TYPE_CHECKING:
    from truepose.domain.arrays import FloatArray
    from truepose.reports.error_vectors_3d import ErrorSpace, Pose
    from truepose.reports.plan_3d import PlanSpace


StopState: TypeAlias = Literal["measured", "skipped", "to_come"]
_PLACE_MM = 1  # decimals of places
_ERROR_MM = 5  # and of errors


class PoseReply(Reply):
    """The arm in one configuration."""

    config: int = Field(examples=[12])
    pieces_mm: list[list[float]] = Field(
        description="Links and tool as capsules: start (3), end (3) and radius, in the world.",
        examples=[[[0.0, 0.0, 0.0, 0.0, 0.0, 290.0, 90.0]]],
    )
    before_mm: float = Field(description="Largest error there of the nominal robot.", examples=[1.21])
    after_mm: float = Field(description="Of the identified model.", examples=[0.052])


class SpaceReply(Reply):
    """Readings in space, before and after; vectors are seen minus foreseen."""

    robot: str = Field(examples=["ABB IRB 120"])
    points_mm: list[Point] = Field(description="Where the tool stood, in the world.")
    before_mm: list[Point] = Field(description="Errors of the nominal robot, base and tool fitted.")
    after_mm: list[Point] = Field(description="Errors of the identified model.")
    times_before: float = Field(
        description="How many times longer the errors are best drawn.", examples=[200.0]
    )
    times_after: float = Field(examples=[2000.0])
    poses: list[PoseReply] = Field(description="The arm where the identified model is worst, worst first.")
    instrument_mm: Point | None = Field(description="Where the tracker stood; null: not known.")
    total: int = Field(description="Readings, of which an even selection is given.", examples=[300])


def space_reply(space: "ErrorSpace") -> SpaceReply:
    """Return errors in space with the digits that a picture needs."""
    return SpaceReply(
        robot=space.robot,
        points_mm=_rounded(space.points_mm, _PLACE_MM),
        before_mm=_rounded(space.before_mm, _ERROR_MM),
        after_mm=_rounded(space.after_mm, _ERROR_MM),
        times_before=space.times_before,
        times_after=space.times_after,
        poses=[_pose_reply(pose) for pose in space.poses],
        instrument_mm=None if space.instrument_mm is None else list(space.instrument_mm),
        total=space.total,
    )


def _pose_reply(pose: "Pose") -> PoseReply:
    return PoseReply(
        config=pose.config,
        pieces_mm=_rounded(pose.pieces_mm, _PLACE_MM),
        before_mm=round(pose.before_mm, _ERROR_MM),
        after_mm=round(pose.after_mm, _ERROR_MM),
    )


def _rounded(values: "FloatArray", decimals: int) -> Any:
    return values.round(decimals).tolist()


class PlannedPlaceReply(Reply):
    """Where a plan sends the arm."""

    config: int = Field(examples=[12])
    state: StopState = Field(examples=["measured"])
    place_mm: Point = Field(description="Of the nest that is measured there, else of the flange; world.")
    pieces_mm: list[list[float]] = Field(
        description="Arm, tool and bars as capsules: start (3), end (3) and radius, in the world.",
        examples=[[[0.0, 0.0, 0.0, 0.0, 0.0, 290.0, 90.0]]],
    )


class PlanSpaceReply(Reply):
    """A session in space, by the nominal robot."""

    robot: str = Field(examples=["ABB IRB 120"])
    stops: list[PlannedPlaceReply] = Field(description="In the order of the plan; of many an even selection.")
    next_config: int | None = Field(description="The configuration that comes next; null: none is left.")
    fixed_mm: list[Point] = Field(description="Fixed nests and cups, in the world.")
    instrument_mm: Point | None = Field(description="Where the tracker stands; null: not known yet.")


def plan_space_reply(space: "PlanSpace") -> PlanSpaceReply:
    """Return a plan in space with the digits that a picture needs."""
    return PlanSpaceReply(
        robot=space.robot,
        stops=[
            PlannedPlaceReply(
                config=stop.config,
                state=stop.state,
                place_mm=_rounded(stop.place_mm, _PLACE_MM),
                pieces_mm=_rounded(stop.pieces_mm, _PLACE_MM),
            )
            for stop in space.stops
        ],
        next_config=None if space.next is None else space.stops[space.next].config,
        fixed_mm=_rounded(space.fixed_mm, _PLACE_MM),
        instrument_mm=None if space.instrument_mm is None else list(space.instrument_mm),
    )


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
    model, content = await model_and_campaign(here, model_id, campaign_id)
    return await asyncio.to_thread(_drawn, model, content, config)


async def model_and_campaign(here: Context, model_id: int | None, campaign_id: int) -> tuple[Model, bytes]:
    """Return a model and, as it is stored, the campaign that it is held against.

    The campaign is unpacked off the loop: a session that measures waits for no picture. Raises NotFoundError
    where the result has no model.
    """
    if model_id is None:
        raise NotFoundError("model of that result", campaign_id)
    return (await here.results.model(model_id)).model, await here.campaigns.content(campaign_id)


def _drawn(model: Model, content: bytes, config: int | None) -> SpaceReply:
    from truepose.reports.error_vectors_3d import error_space

    return space_reply(error_space(model, judging_or_own(stored_campaign(content)), config))
