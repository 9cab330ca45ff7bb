"""Small straight motions of the tool by the nominal arm, its orientation kept."""

import numpy as np

from truepose.domain.measurement.contacts import Joints
from truepose.domain.measurement.session import Vector
from truepose.domain.robot import FramePlacement, Robot
from truepose.kinematics.frames import placement_rotation
from truepose.kinematics.inverse import all_branches
from truepose.sequencing.engine.motion.nominal_arm import nominal_chain
from truepose.sequencing.errors import ReadingRejectedError

_FURTHEST_RAD = 0.2  # a step of some millimetres that turns a joint further is near a singularity


def nudged(robot: Robot, base: FramePlacement, joints_rad: Joints, by_mm: Vector) -> Joints:
    """Return the joints that put the tool `by_mm` further in the world.

    Parameters
    ----------
    robot, base
        Nominal; the base in the world.
    joints_rad : tuple of float
        Where the arm stands.
    by_mm : tuple of float
        A few millimetres [mm, world].

    Raises
    ------
    ReadingRejectedError
        The arm cannot do that by a small motion.
    """
    here = np.array(joints_rad)
    chain = nominal_chain(robot, FramePlacement(), here[None])
    pose = np.eye(4)
    pose[:3, :3] = chain.rotation[-1][0]
    pose[:3, 3] = chain.origin[-1][0] + placement_rotation(base).T @ np.array(by_mm)
    found = all_branches(robot, pose)
    turned = found - 2 * np.pi * np.round((found - here) / (2 * np.pi))
    away = np.max(np.abs(turned - here), axis=1, initial=0.0)
    away[np.isnan(away)] = np.inf
    nearest = int(np.argmin(away))
    if not away[nearest] <= _FURTHEST_RAD:
        raise ReadingRejectedError("The arm cannot bring the gauge nearer its zero by a small motion.")
    return tuple(float(angle) for angle in turned[nearest])


def straight_mm(robot: Robot, start_rad: Joints, end_rad: Joints) -> float:
    """Return how far apart two configurations put the flange [mm]."""
    flange = nominal_chain(robot, FramePlacement(), np.array([start_rad, end_rad])).origin[-1]
    return float(np.linalg.norm(flange[1] - flange[0]))
