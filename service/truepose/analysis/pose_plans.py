"""A test of ISO 9283 as the plan of a session in a cell, and where it is done when nobody says.

Only the poses are looked at, by the rules of `planning.work_volume`: whoever confirms that the cell is clear
watches the first cycle.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import product
from typing import Final

import numpy as np

from truepose.analysis.pose_requests import PoseRequest
from truepose.domain.arrays import FloatArray
from truepose.domain.cell import Cell, Vector
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot
from truepose.domain.session import SessionPlan
from truepose.kinematics.frames import rotation_from_quaternion, rotation_x, rotation_y, rotation_z
from truepose.kinematics.inverse import has_closed_form
from truepose.messages.message import message
from truepose.planning.workspace.space import (
    WorkSpace,
    cosines_to_tracker,
    is_clear,
    nominal_chain,
    space_of_cell,
)
from truepose.validation.iso9283.plan import (
    Cube,
    Plane,
    PosePlan,
    drift_session,
    plan_directions,
    plan_poses,
    possible_plans,
)

_EDGES_MM: Final = (1000.0, 630.0, 400.0, 250.0, 160.0, 100.0)  # preferred numbers R5, ISO 3:1973
_LARGEST: Final = 0.5  # edge over the length of the stretched arm; larger ones fit nowhere
_TILTS_RAD: Final = np.radians([0.0, 30.0, 60.0, 90.0])  # of the tool from looking at the floor, outwards
_SPINS_RAD: Final = np.radians(np.arange(0.0, 360.0, 45.0))  # of the tool about its own axis
_OUT: Final = (0.45, 0.35, 0.55)  # centre along x, over the length of the stretched arm
_ASIDE: Final = (0.0, -0.15, 0.15)
_UP: Final = (0.35, 0.5, 0.2)


def usual_poses(
    space: WorkSpace, plane: Plane, rotation: FloatArray | None, nest: int | None
) -> tuple[PosePlan, int]:
    """Return the poses in the largest cube, the tool tilted as little as may be, and the nest that is seen.

    Rotation of the flange frame in the base, (3, 3), and nest are chosen where they are not given. Raises
    ConfigurationError where no such cube was found.
    """
    rotations = _rotations() if rotation is None else [rotation]
    nests = range(1, len(space.nests) + 1) if nest is None else [nest]
    for turned, seen, cubes in _candidates(space, plane, rotations, nests):
        nest_mm = space.nests[seen - 1].centre_mm
        if nest_mm is None:
            continue
        for plan in possible_plans(space.robot, cubes, turned, nest_mm):
            if _is_measurable(space, plan, seen):
                return plan, seen
    raise ConfigurationError(message("refused.no_cube"))


def _candidates(
    space: WorkSpace, plane: Plane, rotations: Sequence[FloatArray], nests: Sequence[int]
) -> Iterator[tuple[FloatArray, int, Sequence[Cube]]]:
    """Yield orientation, nest and cubes of one edge, the most wanted first."""
    arm = sum(abs(row.a_mm) + abs(row.d_mm) for row in space.robot.joints)
    edges = [edge for edge in _EDGES_MM if edge <= _LARGEST * arm]
    centres = [(arm * out, arm * aside, arm * up) for aside, up, out in product(_ASIDE, _UP, _OUT)]
    for edge in edges:
        cubes = [Cube(centre, edge, plane) for centre in centres]
        # A closed form answers all centres in one call. Where joints are searched each cube costs time, and
        # the first that can be measured ends it.
        together = [cubes] if has_closed_form(space.robot) else [[cube] for cube in cubes]  # each is searched
        yield from product(rotations, nests, together)


def _rotations() -> Sequence[FloatArray]:
    down = rotation_x(np.pi)
    turns = product(_TILTS_RAD, _SPINS_RAD)
    return [rotation_y(-tilt) @ down @ rotation_z(spin) for tilt, spin in turns]


def _is_measurable(space: WorkSpace, plan: PosePlan, nest: int) -> bool:
    chain = nominal_chain(space, plan.joints_rad)
    seen = cosines_to_tracker(space, chain)[nest - 1] >= np.cos(space.seen_within_rad)
    return bool(seen.all() and is_clear(space, chain).all())


_SHORTEST: Final = 1e-3  # of a quaternion; rounded ones are of length 1 to the third digit
_DOWN: Final = (0.0, 1.0, 0.0, 0.0)  # the tool looks at the floor


def plan_pose_session(wanted: PoseRequest) -> SessionPlan:
    """Return the cycles; raises ConfigurationError where nest or poses cannot be had."""
    if wanted.centre_mm is not None and wanted.edge_mm is not None:
        plan, nest = _stated(wanted, Cube(wanted.centre_mm, wanted.edge_mm, wanted.plane))
    elif wanted.centre_mm is None and wanted.edge_mm is None:
        plan, nest = _usual(wanted)
    else:
        raise ConfigurationError(message("refused.cube_in_part"))
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
    return usual_poses(space, wanted.plane, rotation, wanted.nest)


def _within_limits(cell: Cell) -> Robot:
    return replace(cell.robot, joint_limits=cell.limits.joints or cell.robot.joint_limits)


def _centre_mm(cell: Cell, nest: int) -> Vector:
    """Return where a nest is; raises ConfigurationError where there is none or nobody knows."""
    if not 1 <= nest <= len(cell.nests):
        raise ConfigurationError(message("refused.no_nest", nest=nest, count=len(cell.nests)))
    centre_mm = cell.nests[nest - 1].centre_mm
    if centre_mm is None:
        raise ConfigurationError(message("refused.nest_without_centre", nest=nest))
    return centre_mm


def _rotation(quaternion: FloatArray) -> FloatArray:
    length = float(np.linalg.norm(quaternion))
    if length < _SHORTEST:
        raise ConfigurationError(message("refused.zero_quaternion"))
    return rotation_from_quaternion(quaternion / length)
