"""The work space of a measurement, and what makes a configuration feasible in it, by simple stated rules.

The arm is looked at as four kinds of points: tool nests, flange, wrist, and its own column, the upright
cylinder about axis 1 from the base to a little above the shoulder. The rules leave room for the bodies that
they do not know; they are no collision check, and the person who confirms that the cell is clear watches the
first pass. Keep-out volumes are held against the whole arm (`bodies`).

Configurations in which gears stay loaded from one side: unloaded ones are much less stiff, and have play. The
thesis keeps joints 2 and 3 so by their ranges (A. Nubiola, 2014, section 2.4); where masses are known, the
torques say it themselves. Those of the wrist change sign whatever is chosen.
"""

from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.cell import Camera, Cell, KeepOuts
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement, JointRange, Nest, Robot
from truepose.kinematics.chain import Chain, forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.kinematics.gravity import gravity_torques
from truepose.planning.errors import WorkSpaceError

# A corner cube is seen within 30 deg (thesis of A. Nubiola, 2014, section 2.2). One degree is kept from
# that: the tracker may stand 40 mm beside its nominal place 2.6 m away, the arm errs by a tenth of it.
SEEN_WITHIN_RAD: Final = float(np.radians(29.0))
TABLE_CLEARANCE_MM: Final = 60.0  # half a wrist, and the reflector's cup
COLUMN_RADIUS_MM: Final = 150.0  # foot and shoulder of a table robot
COLUMN_ABOVE_SHOULDER_MM: Final = 100.0  # its second motor stands up there

_WRIST_JOINTS = 3  # the last joints, whose origins are wrist and flange
_SHOULDER_JOINTS = 2  # the first joints, whose origins stay with the column


@dataclass(frozen=True, slots=True)
class WorkSpace:
    """A robot with its tool nests before a tracker."""

    robot: Robot
    base: FramePlacement  # nominal, in the world
    nests: tuple[Nest, ...]  # tool nests, all with a centre
    ranges: tuple[JointRange, ...]  # in which configurations are chosen
    tracker_position_mm: tuple[float, float, float] | None  # nominal, in the world
    joint_limits: tuple[JointRange, ...] | None = None  # that no motion may leave; None: unknown
    table_z_mm: float = 0.0  # world; nothing goes near it
    approach_offset_rad: float | None = None
    keep_outs: KeepOuts = field(default_factory=KeepOuts)
    seen_within_rad: float = SEEN_WITHIN_RAD  # of where a nest faces
    camera: Camera | None = None  # reads poses at one nest; None: a tracker reads points, at any

    @property
    def motion_limits(self) -> tuple[JointRange, ...]:
        """What no motion may leave, the approach included."""
        # Where nobody states limits, what the ranges and their approaches need counts as allowed.
        return self.joint_limits or widen_ranges(self.ranges, self.approach_offset_rad)


def widen_ranges(ranges: tuple[JointRange, ...], approach_offset_rad: float | None) -> tuple[JointRange, ...]:
    """Return ranges that contain the approach, which begins outside them for stops at their edge.

    Parameters
    ----------
    ranges : tuple of JointRange
    approach_offset_rad : float or None
        Added to all joints where an approach begins; None: there is none.

    Returns
    -------
    tuple of JointRange
    """
    offset = approach_offset_rad or 0.0
    return tuple(
        JointRange(limit.lower_rad + min(0.0, offset), limit.upper_rad + max(0.0, offset)) for limit in ranges
    )


def require_consistent(space: WorkSpace) -> None:
    """Raise, with one sentence, for what no configuration can satisfy.

    Parameters
    ----------
    space : WorkSpace

    Raises
    ------
    WorkSpaceError
        Ranges or limits are not one a joint or end below where they begin, there is no tool nest, a nest has
        no centre, or a nest faces somewhere and nobody says where the tracker is.
    """
    for what, limits in (("ranges", space.ranges), ("limits", space.motion_limits)):
        if len(limits) != space.robot.n_joints:
            raise WorkSpaceError(
                f"{len(limits)} joint {what} were given for {space.robot.n_joints} joints. Give one per "
                "joint."
            )
        for number, limit in enumerate(limits, start=1):
            if not limit.lower_rad <= limit.upper_rad:
                raise WorkSpaceError(f"The upper end of the {what} of joint {number} is below the lower end.")
    if not space.nests:
        raise WorkSpaceError(
            "The cell has no tool nest, so there is nothing to measure. Enter at least one tool nest."
        )
    for number, nest in enumerate(space.nests, start=1):
        if nest.centre_mm is None:
            raise WorkSpaceError(f"Tool nest {number} has no centre. Enter an approximate centre.")
    if space.tracker_position_mm is None and any(nest.facing is not None for nest in space.nests):
        raise WorkSpaceError(
            "A tool nest has a facing direction, but the nominal position of the tracker is missing. "
            "Enter this position."
        )


def nominal_chain(space: WorkSpace, joints_rad: FloatArray) -> Chain:
    """Return the nominal frames of configurations in the world.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)
        As the controller counts them.

    Returns
    -------
    Chain
        Frames of all joints [mm, world].
    """
    rotation, origin = placement_rotation(space.base), placement_translation(space.base)
    return forward(nominal_values(space.robot, joints_rad), rotation, origin)


def nest_places(space: WorkSpace, chain: Chain) -> FloatArray:
    """Return the nominal centres of all K nests [mm, world], shape (K, n, 3)."""
    return np.stack([chain.points(np.array(nest.centre_mm)) for nest in space.nests])


def is_clear(space: WorkSpace, chain: Chain) -> BoolArray:
    """Whether wrist, flange and nests keep off the table and the robot's own column.

    Parameters
    ----------
    space : WorkSpace
    chain : Chain
        Of n configurations, as of `nominal_chain`.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    points = np.concatenate([chain.origin[-_WRIST_JOINTS:], nest_places(space, chain)])
    above_table = points[..., 2] >= space.table_z_mm + TABLE_CLEARANCE_MM
    height, distance = _about_column(space, points)
    beside_column = (distance >= COLUMN_RADIUS_MM) | (height >= _column_top_mm(space))
    clear: BoolArray = np.all(above_table & beside_column, axis=0)
    return clear


def heights_above_table_mm(space: WorkSpace, joints_rad: FloatArray) -> FloatArray:
    """Return how high the lowest of elbow, wrist, flange and nests is above the table.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray, shape (n,)
        [mm]; points, without room for the bodies about them.
    """
    chain = nominal_chain(space, joints_rad)
    points = np.concatenate([chain.origin[_SHOULDER_JOINTS:], nest_places(space, chain)])
    return np.asarray(points[..., 2].min(axis=0) - space.table_z_mm)


def within(limits: tuple[JointRange, ...], joints_rad: FloatArray) -> BoolArray:
    """Whether all joints are within their limits, both ends included.

    Parameters
    ----------
    limits : tuple of JointRange
        One a joint.
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    low = np.array([limit.lower_rad for limit in limits])
    high = np.array([limit.upper_rad for limit in limits])
    inside: BoolArray = np.all((joints_rad >= low) & (joints_rad <= high), axis=1)
    return inside


def cosines_to_tracker(space: WorkSpace, chain: Chain) -> FloatArray:
    """Return the cosines between where each nest's reflector faces and the beam to the tracker.

    Parameters
    ----------
    space : WorkSpace
    chain : Chain
        Of n configurations.

    Returns
    -------
    ndarray, shape (K, n)
        -inf where the beam would pass through the robot's column, and at nests that nothing reads; 1 for a
        reflector seen from everywhere.
    """
    places = nest_places(space, chain)
    if space.tracker_position_mm is None:
        return np.ones(places.shape[:2])
    tracker = np.array(space.tracker_position_mm)
    beams = tracker - places
    beams /= np.linalg.norm(beams, axis=-1, keepdims=True)
    cosines = np.stack([_cosine(nest, chain, beam) for nest, beam in zip(space.nests, beams, strict=True)])
    cosines[_crosses_column(space, places, tracker)] = -np.inf
    if space.camera is not None:
        cosines[np.arange(len(cosines)) != space.camera.nest - 1] = -np.inf
    return cosines


def _cosine(nest: Nest, chain: Chain, beam: FloatArray) -> FloatArray:
    if nest.facing is None:
        return np.ones(len(beam))
    facing = np.array(nest.facing) / np.linalg.norm(nest.facing)
    cosine: FloatArray = np.einsum("nij,j,ni->n", chain.rotation[-1], facing, beam)
    return cosine


def _about_column(space: WorkSpace, points: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return height above the base and distance from axis 1 of points (..., 3) [mm], both of shape (...).

    Axis 1 is taken for z of the base, as it is in the tables of the thesis (A. Nubiola, 2014, Annex I).
    """
    in_base = (points - placement_translation(space.base)) @ placement_rotation(space.base)
    return in_base[..., 2], np.hypot(in_base[..., 0], in_base[..., 1])


def _column_top_mm(space: WorkSpace) -> float:
    return space.robot.joints[0].d_mm + COLUMN_ABOVE_SHOULDER_MM


def _crosses_column(space: WorkSpace, places: FloatArray, tracker: FloatArray) -> BoolArray:
    """Return whether the beam passes the column below its top; judged where it comes closest to axis 1.

    Seen along axis 1, with the way w from nest p to tracker: share = -p . w / w . w, clamped to [0, 1].
    """
    origin, rotation = placement_translation(space.base), placement_rotation(space.base)
    start, end = (places - origin) @ rotation, (tracker - origin) @ rotation
    way = end - start
    flat = np.sum(way[..., :2] ** 2, axis=-1)
    share = -np.sum(start[..., :2] * way[..., :2], axis=-1) / np.maximum(flat, 1e-12)
    closest = start + np.clip(share, 0.0, 1.0)[..., None] * way
    near = np.hypot(closest[..., 0], closest[..., 1]) < COLUMN_RADIUS_MM
    crosses: BoolArray = near & (closest[..., 2] < _column_top_mm(space))
    return crosses


def space_of_cell(cell: Cell, ranges: tuple[JointRange, ...], approach_offset_rad: float | None) -> WorkSpace:
    """Return the work space of a cell.

    Parameters
    ----------
    cell : Cell
    ranges : tuple of JointRange
        In which configurations are chosen.
    approach_offset_rad : float or None
        From where each configuration is approached, added to all joints.

    Returns
    -------
    WorkSpace
        Its table at the floor of the cell.
    """
    return WorkSpace(
        robot=cell.robot,
        base=cell.base_nominal,
        nests=cell.nests,
        ranges=ranges,
        tracker_position_mm=cell.tracker_position_mm,
        joint_limits=cell.limits.joints or cell.robot.joint_limits,
        table_z_mm=cell.floor_z_mm,
        approach_offset_rad=approach_offset_rad,
        keep_outs=cell.limits.keep_outs,
        seen_within_rad=cell.limits.seen_within_rad or SEEN_WITHIN_RAD,
        camera=cell.camera,
    )


def space_to_measure(cell: Cell, approach_offset_rad: float | None) -> WorkSpace:
    """Return the work space in which the configurations of a session are chosen.

    Parameters
    ----------
    cell : Cell
    approach_offset_rad : float or None
        As in `space_of_cell`.

    Returns
    -------
    WorkSpace

    Raises
    ------
    ConfigurationError
        Neither cell nor robot says in which ranges they are.
    """
    ranges = cell.limits.calibration or cell.robot.calibration_ranges
    if ranges is None:
        raise ConfigurationError(
            f"Joint ranges for choosing configurations are missing for both the cell and {cell.robot.name}. "
            "Give them under [limits] in the cell file, or give the configurations."
        )
    return space_of_cell(cell, ranges, approach_offset_rad)


def without_tracker(space: WorkSpace) -> WorkSpace:
    """Return a work space in which nothing looks at the nests: where a ballbar, gauge or wire reads.

    Parameters
    ----------
    space : WorkSpace

    Returns
    -------
    WorkSpace
    """
    nests = tuple(replace(nest, facing=None) for nest in space.nests)
    return replace(space, nests=nests, tracker_position_mm=None)


_GRAVITY_M_S2: Final = np.array([0.0, 0.0, -9.81])  # a robot on a table; world
_JOINTS_OF_WRIST: Final = 3
_MOSTLY: Final = 2.0 / 3.0  # of configurations: a gear loaded from either side alike is left so


def are_loaded_one_way(space: WorkSpace, joints_rad: FloatArray) -> BoolArray:
    """Return whether gears keep the side from which most of these configurations load them.

    At the stop and at its approach, of the joints between the first and the wrist.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)
        They are judged together: which side is the usual one, they say.

    Returns
    -------
    ndarray of bool, shape (n,)
        All where masses are unknown.

    References
    ----------
    Thesis of A. Nubiola, 2014, section 2.4 (there by ranges of joints 2 and 3).
    """
    if not space.robot.masses or not len(joints_rad):
        return np.ones(len(joints_rad), dtype=bool)
    # The approach counts too: a gear whose load changes sides on the way to the stop crosses its play
    # there.
    ends = [joints_rad, joints_rad + (space.approach_offset_rad or 0.0)]
    positive = np.array([_torques(space, joints) > 0.0 for joints in ends])  # (2, n, carrying joints)
    share = positive.mean(axis=(0, 1))
    kept = (positive == (share > 0.5)) | (np.maximum(share, 1.0 - share) < _MOSTLY)
    one_way: BoolArray = kept.all(axis=(0, 2))
    return one_way


def _torques(space: WorkSpace, joints_rad: FloatArray) -> FloatArray:
    """Return the torques about the axes of the joints that carry the arm [N mm], shape (n, k).

    The first is left out: its axis is plumb on a table, where gravity has no torque about it.
    """
    found = gravity_torques(nominal_chain(space, joints_rad), space.robot.masses, _GRAVITY_M_S2)
    return found[:, 1 : space.robot.n_joints - _JOINTS_OF_WRIST]
