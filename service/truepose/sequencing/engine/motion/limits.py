"""Limits that bind together: a motion keeps to each of several sets, hence to the tightest."""

import math
from typing import Final

from truepose.domain.measurement.ballbar import BallbarPlan
from truepose.domain.measurement.contacts import ContactPlan
from truepose.domain.measurement.session import SessionPlan
from truepose.domain.robot import JointRange, Robot
from truepose.sequencing.errors import PlanRefusedError
from truepose_drivers.api import MotionGuard, MotionLimits

_REDUCED_MM_S: Final = 250.0  # ISO 10218-1: reduced speed control


def common_ranges(
    first: tuple[JointRange, ...] | None, second: tuple[JointRange, ...] | None
) -> tuple[JointRange, ...] | None:
    """Return what lies within both; None, which is unknown, binds nothing. Raises PlanRefusedError."""
    if first is None or second is None:
        return first or second
    if len(first) != len(second):
        raise PlanRefusedError(
            f"The session has limits of {len(first)} joints, the cell of {len(second)}; it is another robot."
        )
    return tuple(
        JointRange(max(a.lower_rad, b.lower_rad), min(a.upper_rad, b.upper_rad))
        for a, b in zip(first, second, strict=True)
    )


def motion_limits(robot: Robot, joint_limits: tuple[JointRange, ...] | None) -> tuple[JointRange, ...]:
    """Return what every move must keep to; raises PlanRefusedError where nothing is known."""
    known = joint_limits or robot.joint_limits or robot.calibration_ranges
    if known is None:
        raise PlanRefusedError(
            "Neither the cell nor the robot states joint limits; nothing moves without them."
        )
    return known


def binding_speed(
    planned: SessionPlan | BallbarPlan | ContactPlan, limits: MotionLimits | None
) -> MotionLimits:
    """Return the speed of a session's motions: as planned, and never above the limits of its cell."""
    speed = MotionLimits(planned.tool_speed_mm_s, planned.orientation_speed_rad_s)
    return slowest(speed, limits or speed)


def reduced(limits: MotionLimits) -> MotionLimits:
    """Return the limits of a robot whose plans nobody has seen run: the standard's reduced speed."""
    return slowest(limits, MotionLimits(_REDUCED_MM_S, limits.orientation_speed_rad_s))


def slowest(*limits: MotionLimits) -> MotionLimits:
    """Return the lowest speed of each kind."""
    return MotionLimits(
        min(limit.tool_speed_mm_s for limit in limits),
        min(limit.orientation_speed_rad_s for limit in limits),
    )


def speed_sentence(speed: MotionLimits, guard: MotionGuard) -> str:
    """Return what keeps the arm to its speed, for the record."""
    read_back = (
        "and states it itself" if guard.speed_read_back else "and cannot be asked whether it keeps to that"
    )
    return (
        f"The robot was told to move at {speed.tool_speed_mm_s:g} mm/s and "
        f"{math.degrees(speed.orientation_speed_rad_s):.3g} deg/s at most, {read_back}."
    )
