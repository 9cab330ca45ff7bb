"""What a test of multi-directional pose accuracy variation commands, ISO 9283:1998, 7.2.3.

P4, P2 and P1 are visited in cycles: first all cycles of one direction, then those of the next. Each visit
ends with a motion parallel to an axis of the base. It is a joint motion; over so short a way the arm leaves
the straight line by little, and the last motion of each joint is what counts.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.session import PlannedStop, SessionPlan
from truepose.domain.robot import Robot
from truepose.judgement.iso9283.directions import DIRECTIONS, POSES
from truepose.judgement.iso9283.plan import PosePlan, joints_in_branches
from truepose.judgement.iso9283.pose import CYCLES
from truepose.kinematics.chain import nominal_chain

APPROACH_MM: Final = 50.0
_ORDER: Final = tuple(reversed(POSES))
_SIGNS: Final = (1.0, -1.0)
_NEAR_RAD: Final = float(np.pi / 2.0)  # one that turns further on 50 mm passes a singularity


@dataclass(frozen=True, slots=True)
class DirectionPlan:
    """P4, P2 and P1, and where the last motion to each begins."""

    joints_rad: FloatArray  # (3, J) in the order of a cycle
    begin_rad: FloatArray  # (3, 3, J) direction x, y, z; pose

    def session(self, nest: int, cycles: int = CYCLES) -> SessionPlan:
        """Return the cycles as a session; a stop has the number of its direction as its group."""
        return SessionPlan("validation", tuple(self._stops(nest, cycles)), approach_offset_rad=None)

    def _stops(self, nest: int, cycles: int) -> Iterator[PlannedStop]:
        visits = np.ndindex(DIRECTIONS, cycles, len(_ORDER))
        for config, (direction, _, place) in enumerate(visits, start=1):
            yield PlannedStop(
                config,
                tuple(self.joints_rad[place].tolist()),
                nest,
                repeat_of=place + 1 if config > len(_ORDER) else None,
                begin_rad=tuple(self.begin_rad[direction, place].tolist()),
                group=direction + 1,
            )


def plan_directions(
    robot: Robot,
    plan: PosePlan,
    nest_mm: tuple[float, float, float] = (0.0, 0.0, 0.0),
    approach_mm: float = APPROACH_MM,
) -> DirectionPlan:
    """Return how the robot comes to P4, P2 and P1 from three perpendicular directions.

    Parameters
    ----------
    robot : Robot
        Its joint limits count where they are known.
    plan : PosePlan
        The poses, and how its joints stand there; the orientation and the branch stay.
    nest_mm : tuple of float
        The point of the tool that stands in the poses, in the last frame.
    approach_mm : float
        Length of the last motion.

    Raises
    ------
    ConfigurationError
        From neither side is there a way to all poses along an axis, which the sentence names.
    """
    if not (np.isfinite(approach_mm) and approach_mm > 0.0):
        raise ConfigurationError(f"An approach of {approach_mm:g} mm is none: give one above 0 mm.")
    rows = [number - 1 for number in _ORDER]
    poses = np.array([plan.poses[row].position_mm for row in rows])
    joints = plan.joints_rad[rows]
    rotation = nominal_chain(robot, joints[:1]).end_rotation[0]
    places = poses - approach_mm * np.array(_SIGNS)[:, None, None] * np.eye(DIRECTIONS)[:, None, None]
    begins, _ = joints_in_branches(robot, places.reshape(-1, 3), rotation, nest_mm)
    begins = _nearest(begins[:, plan.branch].reshape(*places.shape[:3], -1), joints)
    possible = np.asarray(_can_begin(robot, begins, joints).all(axis=-1))  # (axis, sign)
    if not possible.any(axis=1).all():
        raise ConfigurationError(_refused(possible))
    signs = np.argmax(possible, axis=1)
    return DirectionPlan(joints, begins[np.arange(DIRECTIONS), signs])


def _nearest(begin_rad: FloatArray, joints_rad: FloatArray) -> FloatArray:
    """Return the same configurations, with joints turned by whole turns towards where they go."""
    turns = np.round((begin_rad - joints_rad) / (2.0 * np.pi))
    return np.asarray(begin_rad - 2.0 * np.pi * turns)


def _can_begin(robot: Robot, begin_rad: FloatArray, joints_rad: FloatArray) -> BoolArray:
    near = np.abs(begin_rad - joints_rad).max(axis=-1) < _NEAR_RAD  # NaN: out of reach
    if robot.joint_limits is None:
        return np.asarray(near)
    low, high = np.array([(limit.lower_rad, limit.upper_rad) for limit in robot.joint_limits]).T
    return np.asarray(near & ((begin_rad >= low) & (begin_rad <= high)).all(axis=-1))


def _refused(possible: BoolArray) -> str:
    lost = " and ".join("xyz"[axis] for axis in range(DIRECTIONS) if not possible[axis].any())
    return (
        f"From neither side can P4, P2 and P1 all be approached along {lost} of the base: "
        "take a smaller or a nearer cube, or a shorter approach."
    )
