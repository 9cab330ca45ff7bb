"""A test of ISO 9283 as the plan of a session in a cell."""

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.session import SessionPlan
from truepose.judgement.iso9283.plan import Cube, plan_poses
from truepose.kinematics.frames import rotation_from_quaternion

if TYPE_CHECKING:
    from truepose.analysis.workers.tasks import PosePlanTask

_SHORTEST: Final = 1e-3  # of a quaternion; rounded ones are of length 1 to the third digit


def plan_pose_session(wanted: "PosePlanTask") -> SessionPlan:
    """Return the cycles; raises ConfigurationError where nest or poses cannot be had."""
    cell = wanted.setup.cell
    if not 1 <= wanted.nest <= len(cell.nests):
        raise ConfigurationError(f"There is no tool nest {wanted.nest}: the cell has {len(cell.nests)}.")
    centre_mm = cell.nests[wanted.nest - 1].centre_mm
    if centre_mm is None:
        raise ConfigurationError(f"Tool nest {wanted.nest} has no centre; enter a rough one.")
    limits = cell.limits.joints or cell.robot.joint_limits
    rotation = _rotation(np.array(wanted.quaternion))
    cube = Cube(wanted.centre_mm, wanted.edge_mm, wanted.plane)
    poses = plan_poses(replace(cell.robot, joint_limits=limits), cube, rotation, centre_mm)
    cycles = poses.session(wanted.nest, wanted.cycles)
    return replace(wanted.template, stops=cycles.stops, approach_offset_rad=cycles.approach_offset_rad)


def _rotation(quaternion: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(quaternion))
    if length < _SHORTEST:
        raise ConfigurationError("A quaternion of zeros is no orientation: by default the tool looks down.")
    return rotation_from_quaternion(quaternion / length)
