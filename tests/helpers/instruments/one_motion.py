"""`python -m tests.helpers.instruments.one_motion DRIVER OPTIONS`: moves a robot far, slowly.

It is a program for whoever wants to kill one.
"""

import asyncio
import json
import math
import sys

from tests.integration.drivers_of_checkout import drivers_of_checkout
from truepose_drivers.api import MotionLimits
from truepose_drivers.monotonic_clock import MonotonicClock

FAR_DEG = 60.0
SLOW = MotionLimits(tool_speed_mm_s=30.0, orientation_speed_rad_s=math.radians(4.0))  # a quarter of a minute


async def move(driver: str, options: dict[str, str | int]) -> None:
    robot = drivers_of_checkout().open(driver, options, MonotonicClock())
    await robot.connect()
    await robot.identify()
    await robot.set_limits(SLOW)
    here = (await robot.read_joints()).joints_rad
    await robot.move_joints((here[0] + math.radians(FAR_DEG), *here[1:]))


if __name__ == "__main__":
    asyncio.run(move(sys.argv[1], json.loads(sys.argv[2])))
