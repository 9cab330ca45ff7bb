"""Where a test of ISO 9283 is done when nobody says: in the largest cube that a cell has room and sight for.

Only the poses are looked at, by the rules of `planning.work_volume`: whoever confirms that the cell is clear
watches the first cycle.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.judgement.iso9283.plan import Cube, Plane, PosePlan, possible_plans
from truepose.kinematics.frames import rotation_x, rotation_y, rotation_z
from truepose.kinematics.inverse import has_closed_form
from truepose.planning.work_volume.work_space import (
    WorkSpace,
    cosines_to_tracker,
    is_clear,
    nominal_chain,
)

_EDGES_MM: Final = (1000.0, 630.0, 400.0, 250.0, 160.0, 100.0)  # preferred numbers R5, ISO 3:1973
_LARGEST: Final = 0.5  # edge over the length of the stretched arm; larger ones fit nowhere
_TILTS_RAD: Final = np.radians([0.0, 30.0, 60.0, 90.0])  # of the tool from looking at the floor, outwards
_SPINS_RAD: Final = np.radians(np.arange(0.0, 360.0, 45.0))  # of the tool about its own axis
_OUT: Final = (0.45, 0.35, 0.55)  # centre along x, over the length of the stretched arm
_ASIDE: Final = (0.0, -0.15, 0.15)
_UP: Final = (0.35, 0.5, 0.2)


@dataclass(frozen=True, slots=True)
class Wish:
    """What was asked for; what is left out is chosen."""

    plane: Plane
    rotation: FloatArray | None = None  # (3, 3) of the last frame in the base
    nest: int | None = None


def usual_poses(space: WorkSpace, wish: Wish) -> tuple[PosePlan, int]:
    """Return the poses in the largest cube, the tool tilted as little as may be, and the nest that is seen.

    Raises ConfigurationError where no such cube was found.
    """
    for cubes, rotation, nest in _candidates(space, wish):
        nest_mm = space.nests[nest - 1].centre_mm
        if nest_mm is None:
            continue
        for plan in possible_plans(space.robot, cubes, rotation, nest_mm):
            if _is_measurable(space, plan, nest):
                return plan, nest
    raise ConfigurationError(
        "No cube of ISO 9283 was found that this cell has room and sight for: give centre and edge of one."
    )


def _candidates(space: WorkSpace, wish: Wish) -> Iterator[tuple[Sequence[Cube], FloatArray, int]]:
    """Yield cubes of one edge, orientation and nest, the most wanted first."""
    arm = sum(abs(row.a_mm) + abs(row.d_mm) for row in space.robot.joints)
    edges = [edge for edge in _EDGES_MM if edge <= _LARGEST * arm]
    rotations = _rotations() if wish.rotation is None else [wish.rotation]
    nests = range(1, len(space.nests) + 1) if wish.nest is None else [wish.nest]
    centres = [(arm * out, arm * aside, arm * up) for aside, up, out in product(_ASIDE, _UP, _OUT)]
    for edge in edges:
        cubes = [Cube(centre, edge, wish.plane) for centre in centres]
        together = [cubes] if has_closed_form(space.robot) else [[cube] for cube in cubes]  # each is searched
        yield from ((some, rotation, nest) for rotation, nest, some in product(rotations, nests, together))


def _rotations() -> Sequence[FloatArray]:
    down = rotation_x(np.pi)
    turns = product(_TILTS_RAD, _SPINS_RAD)
    return [rotation_y(-tilt) @ down @ rotation_z(spin) for tilt, spin in turns]


def _is_measurable(space: WorkSpace, plan: PosePlan, nest: int) -> bool:
    chain = nominal_chain(space, plan.joints_rad)
    seen = cosines_to_tracker(space, chain)[nest - 1] >= np.cos(space.seen_within_rad)
    return bool(seen.all() and is_clear(space, chain).all())
