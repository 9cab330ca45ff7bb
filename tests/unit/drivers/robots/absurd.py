"""What no robot's driver may send on: targets that six joints cannot have, speeds that are none."""

import math

import pytest

from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import ConfigurationError

TARGETS = [(0.0,) * 5, (0.0,) * 7, (), (math.nan,) * 6, (math.inf, 0, 0, 0, 0, 0), (100.0,) * 6]
SPEEDS = [0.0, -1.0, math.nan, math.inf]


async def require_speed_refused(robot, speed):
    """Hold that neither the tool nor its orientation may be that fast."""
    with pytest.raises(ConfigurationError, match="speed"):
        await robot.set_limits(MotionLimits(tool_speed_mm_s=speed))
    with pytest.raises(ConfigurationError, match="speed"):
        await robot.set_limits(MotionLimits(orientation_speed_rad_s=speed))
