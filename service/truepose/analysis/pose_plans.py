"""A test of ISO 9283 as the plan of a session in a cell."""

from dataclasses import replace
from typing import Final

import numpy as np

from truepose.analysis.pose_requests import PoseRequest
from truepose.analysis.usual_poses import Wish, usual_poses
from truepose.domain.arrays import FloatArray
from truepose.domain.cell.description import Cell, Vector
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.session import SessionPlan
from truepose.domain.robot import Robot
from truepose.judgement.iso9283.direction_plan import plan_directions
from truepose.judgement.iso9283.drift_plan import drift_session
from truepose.judgement.iso9283.plan import Cube, PosePlan, plan_poses
from truepose.kinematics.frames import rotation_from_quaternion
from truepose.planning.work_volume.cell_space import space_of_cell

_SHORTEST: Final = 1e-3  # of a quaternion; rounded ones are of length 1 to the third digit
_DOWN: Final = (0.0, 1.0, 0.0, 0.0)  # the tool looks at the floor


def plan_pose_session(wanted: PoseRequest) -> SessionPlan:
    """Return the cycles; raises ConfigurationError where nest or poses cannot be had."""
    if wanted.centre_mm is not None and wanted.edge_mm is not None:
        plan, nest = _stated(wanted, Cube(wanted.centre_mm, wanted.edge_mm, wanted.plane))
    elif wanted.centre_mm is None and wanted.edge_mm is None:
        plan, nest = _usual(wanted)
    else:
        raise ConfigurationError("Give both centre and edge of the cube, or neither: then both are chosen.")
    test = _session(wanted, plan, nest)
    return replace(
        wanted.template,
        stops=test.stops,
        approach_offset_rad=test.approach_offset_rad,
        ends_when_settled=test.ends_when_settled,
    )


def _session(wanted: PoseRequest, plan: PosePlan, nest: int) -> SessionPlan:
    match wanted.test:
        case "poses":
            return plan.session(nest, wanted.cycles)
        case "directions":
            cell = wanted.setup.cell
            ways = plan_directions(_within_limits(cell), plan, _centre_mm(cell, nest), wanted.approach_mm)
            return ways.session(nest, wanted.cycles)
        case "drift":
            return drift_session(plan, nest, wanted.hours)


def _stated(wanted: PoseRequest, cube: Cube) -> tuple[PosePlan, int]:
    cell, nest = wanted.setup.cell, wanted.nest or 1
    rotation = _rotation(np.array(wanted.quaternion or _DOWN))
    return plan_poses(_within_limits(cell), cube, rotation, _centre_mm(cell, nest)), nest


def _usual(wanted: PoseRequest) -> tuple[PosePlan, int]:
    cell = wanted.setup.cell
    if wanted.nest is not None:
        _centre_mm(cell, wanted.nest)
    space = replace(space_of_cell(cell, (), None), robot=_within_limits(cell))
    rotation = None if wanted.quaternion is None else _rotation(np.array(wanted.quaternion))
    return usual_poses(space, Wish(wanted.plane, rotation, wanted.nest))


def _within_limits(cell: Cell) -> Robot:
    return replace(cell.robot, joint_limits=cell.limits.joints or cell.robot.joint_limits)


def _centre_mm(cell: Cell, nest: int) -> Vector:
    """Return where a nest is; raises ConfigurationError where there is none or nobody knows."""
    if not 1 <= nest <= len(cell.nests):
        raise ConfigurationError(f"There is no tool nest {nest}: the cell has {len(cell.nests)}.")
    centre_mm = cell.nests[nest - 1].centre_mm
    if centre_mm is None:
        raise ConfigurationError(f"Tool nest {nest} has no centre; enter a rough one.")
    return centre_mm


def _rotation(quaternion: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(quaternion))
    if length < _SHORTEST:
        raise ConfigurationError("A quaternion of zeros is no orientation: by default the tool looks down.")
    return rotation_from_quaternion(quaternion / length)
