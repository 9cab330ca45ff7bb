"""Errors in space, as a picture that can be turned shows them."""

from typing import TYPE_CHECKING, Any

from pydantic import Field

from truepose.web.schemas.base import Point, Reply

if TYPE_CHECKING:
    from truepose.domain.arrays import FloatArray
    from truepose.reports.spaces.errors import ErrorSpace, Pose

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
