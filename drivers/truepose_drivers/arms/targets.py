"""What drivers of arms ask of limits and targets before and after a motion, whatever they speak."""

import sys
from collections.abc import Sequence
from typing import Final

from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import ConfigurationError

ARRIVED_DEG: Final = 0.02  # a joint at rest is nearer to its target: encoders resolve far better


def require_speeds(limits: MotionLimits, fastest: float = sys.float_info.max) -> None:
    """Raise ConfigurationError for a speed limit that is none, or above what the controller can hold."""
    for name, value in (
        ("tool_speed_mm_s", limits.tool_speed_mm_s),
        ("orientation_speed_rad_s", limits.orientation_speed_rad_s),
    ):
        if not 0.0 < value <= fastest:  # nor where it is no number
            raise ConfigurationError(f"{name} is {value}: a speed limit must be positive")


def farthest_off(stands: Sequence[float], target: Sequence[float]) -> float:
    """Return by how much that joint is off its target that is off most; in the unit of both."""
    return max(abs(here - there) for here, there in zip(stands, target, strict=True))


def degrees_text(angles_deg: Sequence[float]) -> str:
    """Return angles as a sentence has them."""
    return ", ".join(f"{angle:.3f}" for angle in angles_deg)
