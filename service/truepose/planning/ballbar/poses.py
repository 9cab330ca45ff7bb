"""Poses that can be measured from one placement of the base fixture, and where its cups are clamped.

Every assembly of the pose device (design and solution, all twelve lengths nominal) is one pose of the tool;
the arm reaches it by up to eight branches. A configuration counts when its joints are within the ranges, arm
and tool are clear, and each leg alone finds room between its two balls.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import islice
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.ballbar import Leg, PlannedPose, PlannedSetup
from truepose.domain.robot import JointRange
from truepose.kinematics.frames import (
    placement_rotation,
    placement_translation,
    poses_of,
    rotation_x,
    rotation_y,
    rotation_z,
)
from truepose.kinematics.inverse import BRANCH_NAMES, all_branches, brought_within, has_closed_form
from truepose.kinematics.pose_device import Assembly, assemblies, measurable
from truepose.planning.ballbar.bodies import BallbarCell, BaseFixture, pose_in_base, tool_normal
from truepose.planning.ballbar.clearance import Bars, arm_room_mm, bar_room_mm, bodies_at, without_cups
from truepose.planning.ballbar.motion_clearance import Stop, Surroundings, can_lift
from truepose.planning.errors import WorkSpaceError


@dataclass(frozen=True, slots=True)
class ReachablePoses:
    """Configurations that can be measured, n of them.

    Attributes
    ----------
    joints_rad : ndarray, shape (n, J)
    assembly : tuple of Assembly
        n, in the frame of the fixture.
    branch : tuple of str
        n, in words.
    refused : mapping of str to int
        How many (assembly, branch) pairs each reason kept out.
    """

    joints_rad: FloatArray
    assembly: tuple[Assembly, ...]
    branch: tuple[str, ...]
    refused: Mapping[str, int]

    def __len__(self) -> int:
        return len(self.assembly)

    @property
    def legs(self) -> tuple[tuple[Leg, ...], ...]:
        """The six legs of each configuration, in the order in which the hands take them."""
        return tuple(in_hand_order(assembly.legs) for assembly in self.assembly)


def device(cell: BallbarCell, fixture: BaseFixture) -> tuple[Assembly, ...]:
    """Return the measurable assemblies of tool and base fixture, in the frame of the fixture.

    They are the same wherever the fixture stands.

    Parameters
    ----------
    cell : BallbarCell
        Its tool nests and the length of a leg.
    fixture : BaseFixture

    Returns
    -------
    tuple of Assembly

    References
    ----------
    Thesis of A. Nubiola, 2014, chapter 3.
    """
    return _assembled(_rows(fixture.own_cups_mm), _rows(cell.nests_mm), cell.leg_mm)


_Rows: TypeAlias = tuple[tuple[float, ...], ...]


def _rows(points_mm: FloatArray) -> _Rows:
    return tuple(map(tuple, points_mm.tolist()))


@lru_cache(maxsize=8)  # fixtures of three and four cups with the tools of a few cells
def _assembled(cups_mm: _Rows, nests_mm: _Rows, leg_mm: float) -> tuple[Assembly, ...]:
    cups, nests = np.array(cups_mm), np.array(nests_mm)
    return measurable(assemblies(cups, nests, leg_mm=leg_mm), cups, nests)


def reach(cell: BallbarCell, fixture: BaseFixture, made: Sequence[Assembly] | None = None) -> ReachablePoses:
    """Return every measurable configuration of one placement, in order of assembly and branch.

    Parameters
    ----------
    cell : BallbarCell
    fixture : BaseFixture
    made : sequence of Assembly, optional
        What `device` returns, where many placements are looked at.

    Returns
    -------
    ReachablePoses
        None where nothing can be measured, with the reasons counted.
    """
    made = device(cell, fixture) if made is None else made
    # A face that looks down on the table carries no poses.
    tried = [one for one in made if tuple(sorted(one.design.base)) in fixture.faces]
    joints, index, refused = _within_ranges(cell, _poses(fixture, tried))
    # Arm and tool first: where they are not clear no bar needs to be looked at.
    bodies = bodies_at(cell, fixture, joints)
    clear = arm_room_mm(bodies) >= cell.arm_room_mm
    refused["insufficient clearance of arm or tool"] = int((~clear).sum())
    joints, index = joints[clear], index[clear]
    free = _bars_free(cell, fixture, joints, [tried[row // BRANCHES_PER_POSE] for row in index])
    refused["insufficient clearance of the ballbar"] = int((~free).sum())
    joints, index = joints[free], index[free]
    return ReachablePoses(
        joints,
        tuple(tried[row // BRANCHES_PER_POSE] for row in index),
        tuple(_branch_name(cell, int(row % BRANCHES_PER_POSE)) for row in index),
        refused,
    )


def _poses(fixture: BaseFixture, tried: Sequence[Assembly]) -> FloatArray:
    """Poses of the flange frame in the world, shape (n, 4, 4)."""
    placed = np.eye(4)
    placed[:3, :3], placed[:3, 3] = placement_rotation(fixture.frame), placement_translation(fixture.frame)
    return np.asarray(placed @ np.array([one.pose.matrix for one in tried]).reshape(-1, 4, 4))


BRANCHES_PER_POSE: Final = len(BRANCH_NAMES)


def _branch_name(cell: BallbarCell, branch: int) -> str:
    return BRANCH_NAMES[branch] if has_closed_form(cell.robot) else f"branch {branch + 1}"


def _within_ranges(cell: BallbarCell, poses: FloatArray) -> tuple[FloatArray, IntArray, dict[str, int]]:
    """Joints (n, J) of all branches within the ranges, and their row among poses x branches."""
    joints = all_branches(cell.robot, pose_in_base(cell, poses)).reshape(-1, cell.robot.n_joints)
    # An inverse gives angles of one turn; ranges of more may hold another.
    turned, within = brought_within(joints, cell.ranges)
    exists = np.isfinite(joints).all(axis=1)
    refused = {
        "out of reach": int((~exists).sum()),
        "joints out of range": int((exists & ~within).sum()),
    }
    return turned[within], np.flatnonzero(within).astype(np.int64), refused


def _bars_free(
    cell: BallbarCell, fixture: BaseFixture, joints: FloatArray, tried: Sequence[Assembly]
) -> BoolArray:
    if not tried:
        return np.zeros(0, dtype=bool)
    legs = np.array([assembly.legs for assembly in tried])
    joined = Bars(legs[:, :, 0].T, legs[:, :, 1].T)
    room: BoolArray = np.all(
        bar_room_mm(bodies_at(cell, fixture, joints), joined) >= cell.bar_room_mm, axis=0
    )
    return room


def in_hand_order(legs: Sequence[Leg]) -> tuple[Leg, ...]:
    """Order legs so that from each to the next one ball stays where it is, as far as that is possible.

    The person then moves one end of the ballbar at a time.

    Parameters
    ----------
    legs : sequence of Leg
        Of one pose.

    Returns
    -------
    tuple of Leg
        Sorted by cup and nest where there is no such order.
    """
    best: tuple[Leg, ...] = tuple(sorted(legs))
    for start in sorted(legs):
        path = _walk([start], [leg for leg in sorted(legs) if leg != start])
        if path is not None:
            return path
    return best


def _walk(path: list[Leg], left: list[Leg]) -> tuple[Leg, ...] | None:
    """Return a path on from the last leg through all that are left, by depth first; None: there is none.

    Six legs have 720 orders at most, of which most end soon.
    """
    if not left:
        return tuple(path)
    base, tool = path[-1]
    for leg in left:
        # One ball stays where it is: the end that the hands move is the other.
        if leg[0] == base or leg[1] == tool:
            found = _walk([*path, leg], [other for other in left if other != leg])
            if found is not None:
                return found
    return None


def planned_poses(found: ReachablePoses, placement: int, first_config: int = 1) -> tuple[PlannedPose, ...]:
    """Return configurations as planned poses, in their order.

    Parameters
    ----------
    found : ReachablePoses
    placement : int
        From 1.
    first_config : int
        Number of the first; the others follow.

    Returns
    -------
    tuple of PlannedPose
        Without ways.
    """
    rows = zip(found.joints_rad, found.legs, found.assembly, found.branch, strict=True)
    return tuple(
        PlannedPose(
            config=config,
            placement=placement,
            joints_rad=tuple(float(q) for q in joints),
            legs=legs,
            assembly=f"{branch}, design {assembly.name}",
        )
        for config, (joints, legs, assembly, branch) in enumerate(rows, start=first_config)
    )


def subset(found: ReachablePoses, rows: IntArray) -> ReachablePoses:
    """Return some of the configurations.

    Parameters
    ----------
    found : ReachablePoses
    rows : ndarray, shape (k,)
        Indices.

    Returns
    -------
    ReachablePoses
        In the order of `rows`; what was refused stays as it was counted.
    """
    return replace(
        found,
        joints_rad=found.joints_rad[rows],
        assembly=tuple(found.assembly[row] for row in rows),
        branch=tuple(found.branch[row] for row in rows),
    )


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

    Parameters
    ----------
    cell : BallbarCell
    fixture : BaseFixture

    Returns
    -------
    tuple of PlannedSetup
        In the order of the cups, without ways.

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
                f"The arm cannot hold the setting ball at base point {point} of placement {fixture.number}. "
                "Move the base fixture closer to the middle of the arm's workspace."
            )
        found.append(PlannedSetup(point, tuple(float(q) for q in joints)))
    return tuple(found)


def setup_joints(cell: BallbarCell, fixture: BaseFixture, point: int) -> FloatArray | None:
    """Return the joints at which tool nest 1 is at a cup.

    Parameters
    ----------
    cell : BallbarCell
    fixture : BaseFixture
    point : int
        Base point, 1-based.

    Returns
    -------
    ndarray, shape (J,), or None
        The best of those that are clear and from which the tool can leave the cup; None where the arm cannot
        be.
    """
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
    # From the best one on, a hundred at a time: of hundreds the first will mostly do.
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
    """Return orientations of the flange frame, the tool facing against an axis.

    24 spins about the axis, each tilted by 0 to 45 deg about four axes across.

    Parameters
    ----------
    cell : BallbarCell
        Its tool nests.
    axis : ndarray, shape (3,)
        Unit vector in the world, along which a cup opens.

    Returns
    -------
    rotations : ndarray, shape (k, 3, 3)
    tilts : ndarray, shape (k,)
        [rad].
    """
    towards = _frame_with_z(-axis) @ rotation_z(np.linspace(0, 2 * np.pi, _SPINS, endpoint=False))
    own = _frame_with_z(tool_normal(cell.nests_mm)).T
    rotations, tilts = [], []
    for tilt in np.radians(_TILTS_DEG):
        # Without a tilt it is the same about whichever axis.
        leans = (rotation_x(tilt), rotation_x(-tilt), rotation_y(tilt), rotation_y(-tilt))
        for lean in leans if tilt else leans[:1]:
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
    """Return how far the worst joint is inside its range, as a share of the range.

    Parameters
    ----------
    ranges : tuple of JointRange
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray, shape (n,)
        0.5 in the middle, 0 at an end, negative outside.
    """
    low = np.array([limit.lower_rad for limit in ranges])
    high = np.array([limit.upper_rad for limit in ranges])
    span = np.maximum(high - low, 1e-9)
    return np.asarray((np.minimum(joints_rad - low, high - joints_rad) / span).min(axis=1))


def _room(cell: BallbarCell, fixture: BaseFixture, joints_rad: FloatArray, point: int) -> FloatArray:
    return arm_room_mm(without_cups(bodies_at(cell, fixture, joints_rad), point))
