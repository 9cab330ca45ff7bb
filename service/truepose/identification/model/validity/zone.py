"""The zone that was measured: ranges of the joints, and a polytope around the places of the last frame.

The polytope has a face for every direction to a face, an edge or a corner of a cube, 26 in all: a hull of
fixed size that needs no points kept, a little larger than the convex one.
"""

from itertools import product
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import MeasuredZone
from truepose.domain.robot import JointRange, Robot
from truepose.kinematics.chain import nominal_chain

_CUBE = np.array([way for way in product((-1.0, 0.0, 1.0), repeat=3) if any(way)])
DIRECTIONS: Final = _CUBE / np.linalg.norm(_CUBE, axis=1, keepdims=True)  # (26, 3)


def measured_zone(robot: Robot, joints_rad: FloatArray) -> MeasuredZone:
    """Return the zone of configurations, shape (n, J), n >= 1."""
    low, high = joints_rad.min(axis=0), joints_rad.max(axis=0)
    ranges = tuple(JointRange(*ends) for ends in zip(low.tolist(), high.tolist(), strict=True))
    return MeasuredZone(ranges, tuple(_along(robot, joints_rad).max(axis=0).tolist()))


def outside(zone: MeasuredZone, robot: Robot, joints_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return how far configurations are outside the zone, at least.

    Parameters
    ----------
    zone : MeasuredZone
    robot : Robot
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    distance_mm : ndarray, shape (n,)
        Of the last frame's origin from the polytope; 0 within.
    angle_rad : ndarray, shape (n, J)
        Of each joint from its range; 0 within.
    """
    place_mm = nominal_chain(robot, joints_rad).end_origin
    low, high = (np.array([getattr(r, end) for r in zone.joint_ranges]) for end in ("lower_rad", "upper_rad"))
    beyond_rad = np.maximum(low - joints_rad, joints_rad - high)
    return beyond_zone_mm(zone, place_mm), np.maximum(beyond_rad, 0.0)


def beyond_zone_mm(zone: MeasuredZone, place_mm: FloatArray) -> FloatArray:
    """Return how far places (n, 3) of the last frame in the robot's base are outside, at least, (n,)."""
    beyond = (place_mm @ DIRECTIONS.T - np.array(zone.extents_mm)).max(axis=1)
    return np.asarray(np.maximum(beyond, 0.0))


def _along(robot: Robot, joints_rad: FloatArray) -> FloatArray:
    """Return how far out the last frame is in each direction, shape (n, 26) [mm]."""
    return np.asarray(nominal_chain(robot, joints_rad).end_origin @ DIRECTIONS.T)
