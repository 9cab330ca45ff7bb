"""What tests of ISO 9283:1998 command: five poses in a cube, directions, and drift (6.8, 6.9, 7.2.3, 7.6).

*Cube* (6.8, 6.9). The edges of the cube are parallel to the axes of the base. The poses lie in a diagonal
plane: P1 in its middle, P2 to P5, in order around it, a tenth of its diagonal away from its corners. A cycle:
P5 P4 P3 P2 P1.

*Directions* (7.2.3). P4, P2 and P1 are visited in cycles: first all cycles of one direction, then those of
the next. Each visit ends with a motion parallel to an axis of the base. It is a joint motion; over so short a
way the arm leaves the straight line by little, and the last motion of each joint is what counts.

*Drift* (7.6): one pose from cold, in groups, while the robot works. P1 is visited ten times in a group, each
time from P2. Between two groups the arm goes round all five poses. The first groups follow each other
closely, since a cold robot changes fastest; after two hours half an hour to an hour lies between two.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot
from truepose.domain.session import PlannedStop, SessionPlan, Work
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import poses_of
from truepose.kinematics.inverse import all_branches, brought_within
from truepose.validation.iso9283.drift import LEAST_VISITS
from truepose.validation.iso9283.performance import CYCLES, DIRECTION_POSES, DIRECTIONS, POSES
from truepose.validation.iso9283.visits import CommandedPose

Plane = Literal["x+", "x-", "y+", "y-"]
PoseTestKind = Literal["poses", "directions", "drift"]  # AP RP AD RD; vAP; dAP dRP

FROM_CORNER: Final = 0.10  # of the diagonal; the standard allows 0.08 to 0.12
_ORDER: Final = (5, 4, 3, 2, 1)


@dataclass(frozen=True, slots=True)
class Cube:
    """Where the test takes place.

    Attributes
    ----------
    centre_mm : tuple of float
        In the base.
    edge_mm : float
    plane : str
        "x+", "x-", "y+" or "y-": the letter is the axis of the base that its two level edges follow, the sign
        says whether it rises or falls along the other one.

    Raises
    ------
    ConfigurationError
        It has no size, or is nowhere.
    """

    centre_mm: tuple[float, float, float]
    edge_mm: float
    plane: Plane = "y+"

    def __post_init__(self) -> None:
        if not np.isfinite(self.centre_mm).all():
            raise ConfigurationError("The cube centre must be given as three numbers in mm.")
        if not (np.isfinite(self.edge_mm) and self.edge_mm > 0.0):
            raise ConfigurationError(f"The cube edge must be greater than 0 mm (got {self.edge_mm:g} mm).")

    @property
    def poses(self) -> tuple[CommandedPose, ...]:
        """P1 to P5: the centre, and (1 - 2 * 0.1) of the way to each corner of the diagonal plane."""
        half = 0.5 * self.edge_mm
        across = half * np.eye(3)["xy".index(self.plane[0])]
        along = half * np.eye(3)["yx".index(self.plane[0])]
        up = np.array([0.0, 0.0, half if self.plane[1] == "+" else -half])
        corners = (across + along + up, -across + along + up, -across - along - up, across - along - up)
        inwards = 1.0 - 2.0 * FROM_CORNER
        places = [np.zeros(3), *(inwards * corner for corner in corners)]
        return tuple(CommandedPose.at(k, self.centre_mm + place) for k, place in enumerate(places, start=1))


@dataclass(frozen=True, slots=True)
class PosePlan:
    """Poses that the robot can take, and how its joints stand there.

    Attributes
    ----------
    poses : tuple of CommandedPose
        P1 to P5.
    joints_rad : ndarray, shape (5, J)
        P1 first.
    branch : int
        As `kinematics.inverse` numbers them; the same at all poses.
    """

    poses: tuple[CommandedPose, ...]
    joints_rad: FloatArray
    branch: int

    def session(self, nest: int, cycles: int = CYCLES) -> SessionPlan:
        """Return the cycles as a session; every visit after the first says which one it repeats.

        Nothing comes between two poses: a further approach would measure another robot. The arm begins at P1,
        so that the first cycle comes to P5 from where all others do. Measured on the simulated everyday IRB
        120: from elsewhere, with backlash, that one visit of thirty made RP of P5 0.163 mm instead of 0.05
        mm.

        Parameters
        ----------
        nest : int
            1-based, of the tool.
        cycles : int

        Returns
        -------
        SessionPlan
        """
        return SessionPlan("validation", tuple(self._stops(nest, cycles)), approach_offset_rad=None)

    def _stops(self, nest: int, cycles: int) -> Iterator[PlannedStop]:
        """Yield the visits of all cycles, P5 to P1."""
        in_order: list[list[float]] = self.joints_rad[np.array(_ORDER) - 1].tolist()
        for visit in range(POSES * cycles):
            place = visit % POSES
            repeat_of = place + 1 if visit >= POSES else None
            begin_rad = tuple(in_order[-1]) if visit == 0 else None
            yield PlannedStop(visit + 1, tuple(in_order[place]), nest, repeat_of, begin_rad)


def plan_poses(
    robot: Robot, cube: Cube, rotation: FloatArray, nest_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)
) -> PosePlan:
    """Return how the robot takes the five poses without changing its branch.

    Parameters
    ----------
    robot : Robot
        Its joint limits count where they are known.
    cube : Cube
    rotation : ndarray, shape (3, 3)
        Orientation of the flange frame in the base, the same at all poses.
    nest_mm : tuple of float
        The point of the tool that stands in the poses, in the flange frame.

    Returns
    -------
    PosePlan
        Of the first branch in which the robot reaches all five.

    Raises
    ------
    ConfigurationError
        There is none; the sentence names the poses that it reaches in no branch.
    """
    joints, reached = _branches(robot, [cube], rotation, nest_mm)
    whole = next(_whole([cube], joints, reached), None)
    if whole is None:
        raise ConfigurationError(_unreached(cube.poses, reached[0]))
    return whole


def possible_plans(
    robot: Robot, cubes: Sequence[Cube], rotation: FloatArray, nest_mm: tuple[float, float, float]
) -> Iterator[PosePlan]:
    """Yield how the robot takes the five poses of each cube, in each branch that reaches them all.

    All places go through the inverse together where it is a closed form: many cubes take hardly longer than
    one.

    Parameters
    ----------
    robot : Robot
    cubes : sequence of Cube
    rotation : ndarray, shape (3, 3)
    nest_mm : tuple of float
        As of `plan_poses`.

    Yields
    ------
    PosePlan
        In the order of the cubes, then of the branches.
    """
    return _whole(cubes, *_branches(robot, cubes, rotation, nest_mm))


def _branches(
    robot: Robot, cubes: Sequence[Cube], rotation: FloatArray, nest_mm: tuple[float, float, float]
) -> tuple[FloatArray, BoolArray]:
    """Return the joints of each branch, shape (c, 5, 8, J), and whether it reaches, shape (c, 5, 8)."""
    places = [pose.position_mm for cube in cubes for pose in cube.poses]
    joints, reached = joints_in_branches(robot, places, rotation, nest_mm)
    return joints.reshape(len(cubes), POSES, *joints.shape[1:]), reached.reshape(len(cubes), POSES, -1)


def _whole(cubes: Sequence[Cube], joints: FloatArray, reached: BoolArray) -> Iterator[PosePlan]:
    """Yield a plan for each cube and branch in which all five poses are reached."""
    for place, branch in np.argwhere(reached.all(axis=1)):
        yield PosePlan(cubes[place].poses, joints[place, :, branch], int(branch))


def joints_in_branches(
    robot: Robot, places_mm: ArrayLike, rotation: FloatArray, nest_mm: tuple[float, float, float]
) -> tuple[FloatArray, BoolArray]:
    """Return how the robot takes places of a nest, and whether it can.

    Parameters
    ----------
    robot : Robot
    places_mm : array_like, shape (n, 3)
        Of the nest, in the base.
    rotation : ndarray, shape (3, 3)
        Orientation of the flange frame in the base.
    nest_mm : tuple of float
        In the flange frame.

    Returns
    -------
    joints_rad : ndarray, shape (n, branches, J)
        NaN where a branch does not reach.
    reached : ndarray of bool, shape (n, branches)
        Within the limits, where they are known.
    """
    places = np.asarray(places_mm, dtype=np.float64) - rotation @ np.array(nest_mm)
    wanted = poses_of(np.broadcast_to(rotation, (len(places), 3, 3)), places)
    return _within_limits(robot, all_branches(robot, wanted))


def _within_limits(robot: Robot, joints: FloatArray) -> tuple[FloatArray, BoolArray]:
    """Return joints (n, branches, J) turned by whole turns into the limits, and which of them are within."""
    if robot.joint_limits is None:
        return joints, np.asarray(np.isfinite(joints).all(axis=2))
    flat, within = brought_within(joints.reshape(-1, robot.n_joints), robot.joint_limits)
    return flat.reshape(joints.shape), within.reshape(joints.shape[:2])


def _unreached(poses: tuple[CommandedPose, ...], reached: BoolArray) -> str:
    """Return the sentence that names the poses out of reach."""
    never = [pose.name for pose, found in zip(poses, reached, strict=True) if not found.any()]
    if not never:
        return (
            "The robot reaches all five poses, but not all in the same branch. Choose a smaller or closer "
            "cube."
        )
    verb = "is" if len(never) == 1 else "are"
    return f"{', '.join(never)} {verb} out of the robot's reach. Choose a smaller or closer cube."


APPROACH_MM: Final = 50.0
_DIRECTION_ORDER: Final = tuple(reversed(DIRECTION_POSES))
_SIGNS: Final = (1.0, -1.0)
_NEAR_RAD: Final = float(np.pi / 2.0)  # one that turns further on 50 mm passes a singularity


@dataclass(frozen=True, slots=True)
class DirectionPlan:
    """P4, P2 and P1, and where the last motion to each begins.

    Attributes
    ----------
    joints_rad : ndarray, shape (3, J)
        In the order of a cycle.
    begin_rad : ndarray, shape (3, 3, J)
        By direction x, y, z, then by pose.
    """

    joints_rad: FloatArray
    begin_rad: FloatArray

    def session(self, nest: int, cycles: int = CYCLES) -> SessionPlan:
        """Return the cycles as a session; a stop has the number of its direction as its group.

        Parameters
        ----------
        nest : int
            1-based, of the tool.
        cycles : int

        Returns
        -------
        SessionPlan
        """
        return SessionPlan("validation", tuple(self._stops(nest, cycles)), approach_offset_rad=None)

    def _stops(self, nest: int, cycles: int) -> Iterator[PlannedStop]:
        """Yield the visits: all cycles of one direction, then those of the next."""
        visits = np.ndindex(DIRECTIONS, cycles, len(_DIRECTION_ORDER))
        for config, (direction, _, place) in enumerate(visits, start=1):
            yield PlannedStop(
                config,
                tuple(self.joints_rad[place].tolist()),
                nest,
                repeat_of=place + 1 if config > len(_DIRECTION_ORDER) else None,
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
        The point of the tool that stands in the poses, in the flange frame.
    approach_mm : float
        Length of the last motion.

    Returns
    -------
    DirectionPlan
        Of each axis one side, the same at all poses: the negative one where both are free.

    Raises
    ------
    ConfigurationError
        From neither side is there a way to all poses along an axis, which the sentence names.
    """
    if not (np.isfinite(approach_mm) and approach_mm > 0.0):
        raise ConfigurationError(f"The approach distance must be greater than 0 mm (got {approach_mm:g} mm).")
    rows = [number - 1 for number in _DIRECTION_ORDER]
    poses = np.array([plan.poses[row].position_mm for row in rows])
    joints = plan.joints_rad[rows]
    # Of the first pose: the orientation is the same at all of them.
    rotation = nominal_chain(robot, joints[:1]).end_rotation[0]
    places = poses - approach_mm * np.array(_SIGNS)[:, None, None] * np.eye(DIRECTIONS)[:, None, None]
    begins, _ = joints_in_branches(robot, places.reshape(-1, 3), rotation, nest_mm)
    begins = _nearest(begins[:, plan.branch].reshape(*places.shape[:3], -1), joints)
    possible = np.asarray(_can_begin(robot, begins, joints).all(axis=-1))  # (axis, sign)
    if not possible.any(axis=1).all():
        raise ConfigurationError(_refused(possible))
    # The first side that works, so that the same robot and cube always give the same plan.
    signs = np.argmax(possible, axis=1)
    return DirectionPlan(joints, begins[np.arange(DIRECTIONS), signs])


def _nearest(begin_rad: FloatArray, joints_rad: FloatArray) -> FloatArray:
    """Return the same configurations, with joints turned by whole turns towards where they go."""
    turns = np.round((begin_rad - joints_rad) / (2.0 * np.pi))
    return np.asarray(begin_rad - 2.0 * np.pi * turns)


def _can_begin(robot: Robot, begin_rad: FloatArray, joints_rad: FloatArray) -> BoolArray:
    """Return which beginnings are reached, near enough and within the limits; of one axis less."""
    near = np.abs(begin_rad - joints_rad).max(axis=-1) < _NEAR_RAD  # NaN: out of reach
    if robot.joint_limits is None:
        return np.asarray(near)
    low, high = np.array([(limit.lower_rad, limit.upper_rad) for limit in robot.joint_limits]).T
    return np.asarray(near & ((begin_rad >= low) & (begin_rad <= high)).all(axis=-1))


def _refused(possible: BoolArray) -> str:
    """Return the sentence that names the axes along which no approach is possible."""
    lost = " and ".join("xyz"[axis] for axis in range(DIRECTIONS) if not possible[axis].any())
    return (
        f"P4, P2 and P1 cannot all be approached from the same side along {lost} of the base. Choose a "
        "smaller or closer cube, or a shorter approach distance."
    )


HOURS: Final = 8.0
_DUE_MIN: Final = (0, 10, 20, 30, 40, 50, 60, 75, 90, 120, 150, 180, 240, 300, 360, 420, 480)
_OVERTIME_S: Final = 180.0  # the groups have to span the hours from middle to middle


def drift_session(poses: PosePlan, nest: int, hours: float = HOURS) -> SessionPlan:
    """Return the groups as a session, which ends early where the drift has become slow.

    Parameters
    ----------
    poses : PosePlan
    nest : int
        1-based, of the tool.
    hours : float
        Until the last group is due; the standard has 8.

    Returns
    -------
    SessionPlan

    Raises
    ------
    ConfigurationError
        Less than ten minutes, or more than eight hours.
    """
    if not _DUE_MIN[1] <= 60.0 * hours <= _DUE_MIN[-1]:
        raise ConfigurationError(
            f"The duration of the drift test must be between 10 min and 8 h (got {hours:g} h)."
        )
    # The first groups follow each other closely, since a cold robot changes fastest (7.6).
    due_s = [60.0 * minute for minute in _DUE_MIN if minute <= 60.0 * hours]
    due_s[-1] += _OVERTIME_S
    stops = tuple(_stops(poses, nest, due_s))
    return SessionPlan("validation", stops, approach_offset_rad=None, ends_when_settled=True)


def _stops(poses: PosePlan, nest: int, due_s: list[float]) -> Iterator[PlannedStop]:
    """Yield the visits of P1 in groups; between two groups the robot works at all poses."""
    p1, p2, *others = (tuple(row) for row in poses.joints_rad.tolist())
    round_trip = (*reversed(others), p2, p1)
    for config, (group, visit) in enumerate(np.ndindex(len(due_s), LEAST_VISITS), start=1):
        # Only a working robot stays warm: between two groups it goes round the poses until the next is due.
        work = Work(due_s[group], round_trip) if group and not visit else None
        first = None if config == 1 else 1
        yield PlannedStop(config, p1, nest, first, begin_rad=p2, group=group + 1, work=work)
