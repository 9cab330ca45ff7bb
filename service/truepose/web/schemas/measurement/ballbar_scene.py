"""Geometry of a step, and the simulated hands."""

from typing import Literal

from pydantic import Field

from truepose.web.schemas.base import Point, Reply


class ScenePointReply(Reply):
    """A cup of the base or a nest of the tool."""

    name: str = Field(examples=["B1"])
    position_mm: Point
    kind: Literal["cup", "nest"]


class SceneReply(Reply):
    """What a page draws of the present step, in the world."""

    points: list[ScenePointReply]
    arm_mm: list[Point] = Field(
        description="From the base to the last frame, for this step; the base alone: not known."
    )
    leg: list[str] | None = Field(
        description="The two points that the ballbar joins.", examples=[["B2", "T3"]]
    )
    stand_mm: Point = Field(description="The person's eyes.")
    look_at_mm: Point
    before_move_arm_mm: list[Point] | None = Field(
        description="Of a motion: where the arm is now, as far as known."
    )


class HandsReply(Reply):
    """What simulated hands can do."""

    simulated: bool = Field(description="False: a person stands at the cell.")
    actions: list[str] = Field(examples=[["connect", "detach"]])
    holding: str = Field(description="Where the ballbar is; empty: in the hand.", examples=["connect base 2"])
