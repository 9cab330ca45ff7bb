"""What a test of ISO 9283:1998 commands: five poses in a cube, and the order of their cycles (6.8, 6.9).

The edges of the cube are parallel to the axes of the base. The poses lie in a diagonal plane: P1 in its
middle, P2 to P5, in order around it, a tenth of its diagonal away from its corners. A cycle: P5 P4 P3 P2 P1.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import ArrayLike

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.session import PlannedStop, SessionPlan
from truepose.domain.robot import Robot
from truepose.judgement.iso9283.pose import CYCLES, POSES
from truepose.judgement.iso9283.visits import CommandedPose
from truepose.kinematics.frames import poses_of
from truepose.kinematics.inverse import all_branches, brought_within

Plane = Literal["x+", "x-", "y+", "y-"]
PoseTestKind = Literal["poses", "directions", "drift"]  # AP RP AD RD; vAP; dAP dRP

FROM_CORNER: Final = 0.10  # of the diagonal; the standard allows 0.08 to 0.12
_ORDER: Final = (5, 4, 3, 2, 1)


@dataclass(frozen=True, slots=True)
class Cube:
    """Where the test takes place.

    `plane`: the letter is the axis of the base that its two level edges follow, the sign says whether it
    rises or falls along the other one.
    """

    centre_mm: tuple[float, float, float]  # in the base
    edge_mm: float
    plane: Plane = "y+"

    def __post_init__(self) -> None:
        if not (np.isfinite(self.edge_mm) and self.edge_mm > 0.0 and np.isfinite(self.centre_mm).all()):
            raise ConfigurationError(
                f"A cube with an edge of {self.edge_mm:g} mm is none: give one above 0 mm."
            )

    @property
    def poses(self) -> tuple[CommandedPose, ...]:
        """P1 to P5."""
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
    """Poses that the robot can take, and how its joints stand there."""

    poses: tuple[CommandedPose, ...]
    joints_rad: FloatArray  # (5, J), P1 first
    branch: int  # as `kinematics.inverse` numbers them; the same at all poses

    def session(self, nest: int, cycles: int = CYCLES) -> SessionPlan:
        """Return the cycles as a session; every visit after the first says which one it repeats.

        Nothing comes between two poses: a further approach would measure another robot. The arm begins at P1,
        so that the first cycle comes to P5 from where all others do.
        """
        return SessionPlan("validation", tuple(self._stops(nest, cycles)), approach_offset_rad=None)

    def _stops(self, nest: int, cycles: int) -> Iterator[PlannedStop]:
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
        Orientation of the last frame in the base, the same at all poses.
    nest_mm : tuple of float
        The point of the tool that stands in the poses, in the last frame.

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

    Otherwise as `plan_poses`; many cubes together take hardly longer than one.
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
    for place, branch in np.argwhere(reached.all(axis=1)):
        yield PosePlan(cubes[place].poses, joints[place, :, branch], int(branch))


def joints_in_branches(
    robot: Robot, places_mm: ArrayLike, rotation: FloatArray, nest_mm: tuple[float, float, float]
) -> tuple[FloatArray, BoolArray]:
    """Return how the robot takes (n, 3) places of a nest, and whether it can.

    Returns
    -------
    joints_rad : ndarray, shape (n, branches, J)
    reached : ndarray, shape (n, branches)
        Within the limits, where they are known.
    """
    places = np.asarray(places_mm, dtype=np.float64) - rotation @ np.array(nest_mm)
    wanted = poses_of(np.broadcast_to(rotation, (len(places), 3, 3)), places)
    return _within_limits(robot, all_branches(robot, wanted))


def _within_limits(robot: Robot, joints: FloatArray) -> tuple[FloatArray, BoolArray]:
    if robot.joint_limits is None:
        return joints, np.asarray(np.isfinite(joints).all(axis=2))
    flat, within = brought_within(joints.reshape(-1, robot.n_joints), robot.joint_limits)
    return flat.reshape(joints.shape), within.reshape(joints.shape[:2])


def _unreached(poses: tuple[CommandedPose, ...], reached: BoolArray) -> str:
    never = [pose.name for pose, found in zip(poses, reached, strict=True) if not found.any()]
    if not never:
        return "The robot reaches all five poses, but in no single branch: take a smaller or a nearer cube."
    verb = "is" if len(never) == 1 else "are"
    return f"{', '.join(never)} {verb} out of the robot's reach: take a smaller or a nearer cube."
