"""Ballbar cells for tests: the two arms of the thesis with the triangular tool, base fixtures before them."""

import numpy as np

from truepose.domain.cell import Cell
from truepose.domain.robot import FramePlacement
from truepose.exchange.robots.named import load_robot_with_tool
from truepose.planning.ballbar.bodies import BallbarCell, base_fixture

LR_MATE = "fanuc-lr-mate-200ic"
IRB_120 = "abb-irb-120"


def frame(x, y, z, rx=0.0, ry=0.0, rz=0.0):
    """Place a frame, angles in degrees."""
    return FramePlacement(x, y, z, *np.radians([rx, ry, rz]))


def ballbar_cell(name=LR_MATE, **given):
    """Return an arm with its tool."""
    shipped = load_robot_with_tool(name)
    nests = np.array([nest.centre_mm for nest in shipped.nests])
    return BallbarCell(
        shipped.robot, given.pop("base", FramePlacement()), nests, shipped.robot.calibration_ranges, **given
    )


def domain_cell(name=LR_MATE, **given):
    """Return an arm with its tool as a cell of the domain."""
    shipped = load_robot_with_tool(name)
    return Cell("bench", name, shipped.robot, nests=shipped.nests, **given)


def fixture_before_the_arm(points=3, number=1):
    """Return a base fixture from which the LR Mate reaches many poses, with three or four cups."""
    place = frame(450, -200, 150, 0, -30, 60) if points == 3 else frame(300, -150, 300, -60, 20, 0)
    return base_fixture(number, place, points)
