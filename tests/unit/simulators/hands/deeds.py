"""What the tests have a person and the arm of the LR Mate do, and where it stands meanwhile."""

import numpy as np

from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.instruments.accuracy import BallbarSetup

FAST = SpeedLimits(tool_mm_s=1e6, orientation_rad_s=1e6)
# The LR Mate holds the ball of nest 1 at corners 300 mm apart, then stands above them.
SETUPS = [
    [-58.48574, 79.58569, 65.86075, -33.78310, -80.99835, -0.30652],
    [-7.36556, 15.04747, 61.63422, -10.50180, -26.94399, 3.73691],
    [52.10598, 57.72268, 66.68768, 33.82612, -65.95850, -0.76965],
]
POSE = [-11.16534, 12.98009, 37.42969, 8.87272, 74.18729, 118.66923]
OTHER_POSE = [-79.08867, -59.17122, 82.21463, 49.5281, 65.18911, 152.87311]
LEG = {"base": 3, "tool": 2}  # one of the six of POSE


async def move(cell, joints_deg):
    await cell.move_robot([np.radians(joints_deg)], FAST, np.zeros(3))


async def clamp_all(cell, placement=1, points=(1, 2, 3)):
    cell.hands.do("place_base", {"placement": placement})
    cell.hands.do("fit_ball", {})
    for point in points:
        await move(cell, SETUPS[point - 1])
        cell.hands.do("clamp", {"base_point": point})
    await move(cell, POSE)
    cell.hands.do("remove_ball", {})


def shown(cell):
    return cell.ballbar.sample(cell.clock.now_s)


def wide(**changes):
    """A ballbar that is in range wherever it can be attached."""
    return BallbarSetup(range_mm=3.0, **changes)
