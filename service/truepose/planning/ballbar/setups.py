"""Where the robot holds the setting ball while a base cup is clamped on it: tool nest 1 at the cup."""

from collections.abc import Iterator
from itertools import islice
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.ballbar import PlannedSetup
from truepose.domain.robot import JointRange
from truepose.kinematics.frames import (
    poses_of,
    rotation_x,
    rotation_y,
    rotation_z,
)
from truepose.kinematics.inverse import all_branches, brought_within
from truepose.planning.ballbar.clear_ways.bodies import BallbarCell, pose_in_base, tool_normal
from truepose.planning.ballbar.clear_ways.clearance import arm_room_mm, bodies_at, without_cups
from truepose.planning.ballbar.clear_ways.short_moves import Stop, Surroundings, can_lift
from truepose.planning.ballbar.fixture import BaseFixture
from truepose.planning.errors import WorkSpaceError

_SPINS: Final = 24  # of the tool about the cup's axis
_TILTS_DEG: Final = (
    0.0,
    15.0,
    30.0,
    45.0,
)  # of the tool against the cup; beyond, both cups grasp past the ball
_AT_ONCE: Final = 100  # configurations that are looked at together
_MOST_LIFTS: Final = 40  # configurations of which it is tried whether the tool can leave the cup
_TILT_COST: Final = 0.2  # share of a joint's range that a tilt of one radian is worth


def setups(cell: BallbarCell, fixture: BaseFixture) -> tuple[PlannedSetup, ...]:
    """Return one set-up per base cup: joints far inside their ranges, the tool square on the cup if possible.

    Raises
    ------
    WorkSpaceError
        The arm cannot hold the ball at one of the cups.
    """
    found = []
    for point in range(1, len(fixture.cups_mm) + 1):
        joints = setup_joints(cell, fixture, point)
        if joints is None:
            raise WorkSpaceError(
                f"The arm cannot hold the setting ball at base point {point} of placement {fixture.number}: "
                "place the base fixture nearer to the middle of its work space."
            )
        found.append(PlannedSetup(point, tuple(float(q) for q in joints)))
    return tuple(found)


def setup_joints(cell: BallbarCell, fixture: BaseFixture, point: int) -> FloatArray | None:
    """Return the joints (J,) at which tool nest 1 is at a cup (1-based); None where the arm cannot be."""
    rotations, tilt = orientations_facing(cell, fixture.axes[point - 1])
    poses = poses_of(rotations, fixture.cups_mm[point - 1] - rotations @ cell.nests_mm[0])
    joints = all_branches(cell.robot, pose_in_base(cell, poses))
    tilts = np.repeat(tilt, joints.shape[1])
    turned, within = brought_within(joints.reshape(-1, cell.robot.n_joints), cell.ranges)
    turned, tilts = turned[within], tilts[within]
    if not len(turned):
        return None
    worth = inside(cell.ranges, turned) - _TILT_COST * tilts
    best_first = turned[np.argsort(-worth, kind="stable")]
    around = Surroundings(cell, fixture)
    for one in islice(_clear(cell, fixture, best_first, point), _MOST_LIFTS):
        if can_lift(around, Stop(one, point)):
            return one
    return None


def _clear(
    cell: BallbarCell, fixture: BaseFixture, joints_rad: FloatArray, point: int
) -> Iterator[FloatArray]:
    """Yield those of (n, J) configurations that are clear; the first ones will mostly do."""
    for start in range(0, len(joints_rad), _AT_ONCE):
        some = joints_rad[start : start + _AT_ONCE]
        yield from some[_room(cell, fixture, some, point) >= cell.arm_room_mm]


def orientations_facing(cell: BallbarCell, axis: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return orientations of the last frame, the tool facing against an axis, and their tilts [rad]."""
    towards = _frame_with_z(-axis) @ rotation_z(np.linspace(0, 2 * np.pi, _SPINS, endpoint=False))
    own = _frame_with_z(tool_normal(cell.nests_mm)).T
    rotations, tilts = [], []
    for tilt in np.radians(_TILTS_DEG):
        for lean in (rotation_x(tilt), rotation_x(-tilt), rotation_y(tilt), rotation_y(-tilt)):
            rotations.append(towards @ lean @ own)
            tilts.append(np.full(_SPINS, tilt))
    return np.concatenate(rotations), np.concatenate(tilts)


def _frame_with_z(axis: FloatArray) -> FloatArray:
    """Return a rotation whose third column is `axis`."""
    aside = np.eye(3)[int(np.argmin(np.abs(axis)))]
    x = np.cross(aside, axis)
    x /= np.linalg.norm(x)
    return np.stack([x, np.cross(axis, x), axis], axis=1)


def inside(ranges: tuple[JointRange, ...], joints_rad: FloatArray) -> FloatArray:
    """Return how far the worst joint is inside its range, as a share of the range, shape (n,)."""
    low = np.array([limit.lower_rad for limit in ranges])
    high = np.array([limit.upper_rad for limit in ranges])
    span = np.maximum(high - low, 1e-9)
    return np.asarray((np.minimum(joints_rad - low, high - joints_rad) / span).min(axis=1))


def _room(cell: BallbarCell, fixture: BaseFixture, joints_rad: FloatArray, point: int) -> FloatArray:
    return arm_room_mm(without_cups(bodies_at(cell, fixture, joints_rad), point))
