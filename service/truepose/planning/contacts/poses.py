"""Random places and directions of the tool at its targets, with joint angles and ways there.

A goal is a place of the nest, a direction t of the tool's axis a, and the direction w of the last
millimetres. The rotation R turns a into t and spins about it at random; the flange then has its origin, b
mm before the stop, at

    o = tip - b w - R nest

and its joint angles come from the inverse of the nominal robot, on one branch all the way.
"""

from dataclasses import dataclass
from typing import Final, NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.contacts import Target, TargetKind
from truepose.domain.robot import JointRange
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.kinematics.inverse import all_branches, brought_within
from truepose.planning.contacts.plan_request import ContactPlanRequest, mean_normal, normal_of, place_of
from truepose.planning.workspace.bodies import CellBodies, rooms
from truepose.planning.workspace.path_clearance import Ways, least_rooms_mm
from truepose.planning.workspace.space import WorkSpace

_CAP_COSINE: Final = 0.25  # of a sphere: the rest is where its stem is
_PROBE_TILT_RAD: Final = float(np.radians(12.0))  # of the probe against what it touches
_STEM_TILT_RAD: Final = float(np.radians(50.0))  # of a ball's stem, or a sensor, against the way in
_SHARE: Final = 0.15  # of the usable stroke, in which stops are planned: arm and fixture err as well


class Goals(NamedTuple):
    """n wanted places of the tool."""

    group: IntArray  # (n,) which targets are read: a place in `groups_of`
    tip_mm: FloatArray  # (n, 3) of the nest, world
    points: FloatArray  # (n, 3) unit: where the tool's axis points
    way_in: FloatArray  # (n, 3) unit: direction of the last millimetres

    def taken(self, rows: IntArray) -> "Goals":
        """Return some of them, in the order of `rows` (k,)."""
        return Goals(self.group[rows], self.tip_mm[rows], self.points[rows], self.way_in[rows])


def groups_of(wish: ContactPlanRequest) -> tuple[tuple[Target, ...], ...]:
    """Return which targets are read together at a stop: a probe touches one, all else reads all.

    Parameters
    ----------
    wish : ContactPlanRequest

    Returns
    -------
    tuple of tuples of Target
    """
    if wish.loop == "probe":
        return tuple((target,) for target in wish.targets)
    return (wish.targets,)


def draw_goals(wish: ContactPlanRequest, n: int, rng: np.random.Generator) -> Goals:
    """Draw n places of a tool that touches, or comes near.

    Parameters
    ----------
    wish : ContactPlanRequest
        Of a probe, gauges or a sensor: wires have no goals, they hang on the tool anywhere.
    n : int
    rng : numpy.random.Generator

    Returns
    -------
    Goals
        Each of a group of targets drawn evenly.

    Raises
    ------
    WorkSpaceError
        Targets that are read together have directions that cancel each other.
    """
    groups = groups_of(wish)
    group = rng.integers(len(groups), size=n)
    # n for each group, of which each row takes that of its own: a draw per row would be as many calls.
    goals = [_of_group(wish, targets, n, rng) for targets in groups]
    rows = np.arange(n)
    return Goals(group, *(np.stack(column)[group, rows] for column in zip(*goals, strict=True)))


def _of_group(
    wish: ContactPlanRequest, targets: tuple[Target, ...], n: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return places of the nest (n, 3) [mm], where the tool points (n, 3), and the way in (n, 3).

    A sphere is touched at its zero from its centre, within a cap; a plane in a square about its place.
    """
    first = targets[0]
    match first.kind:
        case TargetKind.SPHERE:
            outwards = _within_cone(normal_of(first), np.arccos(_CAP_COSINE), n, rng)
            tip_mm = place_of(first) + (first.zero_mm or 0.0) * outwards
            return _probing(tip_mm, -outwards, rng)
        case TargetKind.PLANE:
            normal = normal_of(first)
            across = np.linalg.svd(normal[None])[2][1:]
            beside_mm = wish.plane_mm * rng.uniform(-1.0, 1.0, (n, 2)) @ across
            return _probing(place_of(first) + beside_mm, np.broadcast_to(-normal, (n, 3)), rng)
        case _:
            return _approaching(wish, targets, n, rng)


def _probing(
    tip_mm: FloatArray, inwards: FloatArray, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    points = np.array([_within_cone(way, _PROBE_TILT_RAD, 1, rng)[0] for way in inwards])
    return tip_mm, points, points  # a probe is pushed in along its own axis


def _approaching(
    wish: ContactPlanRequest, targets: tuple[Target, ...], n: int, rng: np.random.Generator
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Into a fixture of gauges along the middle of their directions; down to a ball for a sensor."""
    way = mean_normal(targets) * (-1.0 if wish.loop == "sensor" else 1.0)
    middle_mm = np.mean([place_of(target) for target in targets], axis=0)
    # All within a small part of the stroke: a fixture stands off its place, and the readings with it.
    off_mm = _SHARE * wish.usable_mm * rng.uniform(-1.0, 1.0, (n, 3))
    points = _within_cone(way, _STEM_TILT_RAD, n, rng)
    return middle_mm + off_mm, points, np.broadcast_to(way, (n, 3))


def _within_cone(about: FloatArray, widest_rad: float, n: int, rng: np.random.Generator) -> FloatArray:
    """Draw unit vectors evenly over the cap about a direction, shape (n, 3).

    Over a sphere the cosine of the angle from any axis is uniform (Archimedes' hat-box theorem).
    """
    across = np.linalg.svd(about[None])[2][1:]
    cosine = rng.uniform(np.cos(widest_rad), 1.0, n)
    turn = rng.uniform(-np.pi, np.pi, n)
    sine = np.sqrt(1.0 - cosine**2)
    drawn: FloatArray = (
        cosine[:, None] * about
        + (sine * np.cos(turn))[:, None] * across[0]
        + (sine * np.sin(turn))[:, None] * across[1]
    )
    return drawn


_ROOM_MM: Final = 10.0  # of arm and tool, where the service chooses
_LAST_STEPS: Final = (1.0, 0.75, 0.5, 0.25, 0.0)  # of the stroke, before the stop
_FROM_LIMITS_RAD: Final = 0.1  # targets stand off their place, and the arm follows them
_TURNED_RAD: Final = 0.05  # on a step of a millimetre or so: further is near a singularity


@dataclass(frozen=True, slots=True)
class ReachablePoses:
    """n places that the arm reaches, and the ways there.

    Attributes
    ----------
    goals : Goals
    way_rad : ndarray, shape (n, k, J)
        From where nothing is near to the stop, which is the last.
    """

    goals: Goals
    way_rad: FloatArray

    def taken(self, rows: IntArray) -> "ReachablePoses":
        """Return some of them, in the order of `rows` (k,)."""
        return ReachablePoses(self.goals.taken(rows), self.way_rad[rows])


def step_lengths_mm(wish: ContactPlanRequest) -> tuple[float, ...]:
    """Return how far before its stop each place of a way is.

    Parameters
    ----------
    wish : ContactPlanRequest

    Returns
    -------
    tuple of float
        [mm] descending to 0: the clearance, then the stroke in quarters.
    """
    last = (share * wish.stroke_mm for share in _LAST_STEPS)
    return (wish.clearance_mm, *last)


def reached(
    space: WorkSpace, bodies: CellBodies, wish: ContactPlanRequest, goals: Goals, rng: np.random.Generator
) -> ReachablePoses:
    """Return the goals that the arm reaches with room all the way, each with a branch drawn at random.

    Parameters
    ----------
    space : WorkSpace
    bodies : CellBodies
    wish : ContactPlanRequest
    goals : Goals
        n of them.
    rng : numpy.random.Generator
        Draws the spin about the tool's axis, and the branch.

    Returns
    -------
    ReachablePoses
        n at most, in the order of the goals.
    """
    turn = _tool_rotations(np.array(wish.axis), goals.points, rng)
    poses = [_poses(space, wish, goals, turn, before_mm) for before_mm in step_lengths_mm(wish)]
    branches = np.stack([all_branches(space.robot, pose) for pose in poses], axis=1)  # (n, k, 8, J)
    # The first branch alone would leave all the others of the arm unmeasured.
    rows, drawn = _drawn_branches(branches, rng)
    found, fits = _within(branches[rows, :, drawn], space.motion_limits)
    # Without the first motion, which is long: it is a joint motion, the others follow the way in closely.
    fits &= np.abs(np.diff(found[:, 1:], axis=1)).max(axis=(1, 2)) < _TURNED_RAD
    rows, found = rows[fits], found[fits]
    clear = _has_room(bodies, found)
    clear_rows = np.flatnonzero(clear)
    return ReachablePoses(goals.taken(rows[clear_rows]), found[clear_rows])


def _tool_rotations(axis: FloatArray, points: FloatArray, rng: np.random.Generator) -> FloatArray:
    """Return rotations that turn the tool's axis where it points, spun at random, shape (n, 3, 3)."""
    spin = rng.uniform(-np.pi, np.pi, len(points))
    tool = _frame_about(axis[None], np.zeros(1))[0]
    return np.asarray(_frame_about(points, spin) @ tool.T)


def _frame_about(z: FloatArray, spin_rad: FloatArray) -> FloatArray:
    """Return right-handed frames whose third axis is `z`, shape (n, 3, 3)."""
    unit = z / np.linalg.norm(z, axis=1, keepdims=True)
    helper = np.where(np.abs(unit[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    x = np.cross(helper, unit)
    x /= np.linalg.norm(x, axis=1, keepdims=True)
    y = np.cross(unit, x)
    cosine, sine = np.cos(spin_rad)[:, None], np.sin(spin_rad)[:, None]
    return np.stack([cosine * x + sine * y, cosine * y - sine * x, unit], axis=2)


def _poses(
    space: WorkSpace, wish: ContactPlanRequest, goals: Goals, turn: FloatArray, before_mm: float
) -> FloatArray:
    """Return the poses of the flange frame in the base, shape (n, 4, 4)."""
    nest_mm = np.array(space.nests[wish.nest - 1].centre_mm)
    origin_mm = goals.tip_mm - before_mm * goals.way_in - turn @ nest_mm
    base, foot_mm = placement_rotation(space.base), placement_translation(space.base)
    poses = np.zeros((len(turn), 4, 4))
    poses[:, :3, :3] = base.T @ turn
    poses[:, :3, 3] = (origin_mm - foot_mm) @ base
    poses[:, 3, 3] = 1.0
    return poses


def _drawn_branches(branches: FloatArray, rng: np.random.Generator) -> tuple[IntArray, IntArray]:
    """Return rows that have a branch all the way, and one of these branches each."""
    there: BoolArray = np.all(np.isfinite(branches), axis=(1, 3))  # (n, 8)
    weight = np.where(there, rng.random(there.shape), -1.0)
    rows = np.flatnonzero(np.any(there, axis=1))
    return rows, np.argmax(weight[rows], axis=1)


def _within(ways: FloatArray, limits: tuple[JointRange, ...]) -> tuple[FloatArray, BoolArray]:
    """Turn each way by whole turns into the limits, all its places alike.

    Returns ways (n, k, J), and which of them stay 0.1 rad off all limits (n,).
    """
    n, k, joints = ways.shape
    stops, inside = brought_within(ways[:, -1], limits)
    # Places of one way belong to the same turn: taken by itself each could come out a turn apart.
    turned = ways - 2 * np.pi * np.round((ways - stops[:, None]) / (2 * np.pi))
    _, each_inside = brought_within(turned.reshape(-1, joints), limits)
    low = np.array([limit.lower_rad for limit in limits]) + _FROM_LIMITS_RAD
    high = np.array([limit.upper_rad for limit in limits]) - _FROM_LIMITS_RAD
    kept = np.all((turned >= low) & (turned <= high), axis=(1, 2))
    return turned, inside & kept & each_inside.reshape(n, k).all(axis=1)


def _has_room(bodies: CellBodies, ways: FloatArray) -> BoolArray:
    """Whether arm and tool have room at all places of n ways, and on the first motion of each."""
    n, k, joints = ways.shape
    if not n:
        return np.zeros(0, dtype=bool)
    places = rooms(bodies, ways.reshape(-1, joints)).least_mm().reshape(n, k)
    between = least_rooms_mm(bodies, Ways((), ways[:, 0], ways[:, 1]))
    clear: BoolArray = (places.min(axis=1) >= _ROOM_MM) & (between >= _ROOM_MM)
    return clear
