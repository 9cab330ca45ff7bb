"""Limits that bind together: a motion keeps to each of several sets, hence to the tightest."""

from drivers.api import MotionLimits
from service.domain.robot import JointRange
from service.sequencing.errors import PlanRefusedError


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


def slowest(*limits: MotionLimits) -> MotionLimits:
    """Return the lowest speed of each kind."""
    return MotionLimits(
        min(limit.tool_speed_mm_s for limit in limits),
        min(limit.orientation_speed_rad_s for limit in limits),
    )
