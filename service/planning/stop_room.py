"""Whether the arm has room at stops that somebody gives: bodies above floor or table, tool off the arm.

Refused is what would touch, by the capsules that ballbar plans have (`ballbar/bodies`); chosen stops keep
more room than that (`work_space`), and come in an order whose ways keep off the table (`clear_ways`). Between
two given stops nothing is looked at.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain
from typing import Final

import numpy as np

from service.domain.arrays import FloatArray
from service.domain.cell import Cell
from service.domain.robot import JointRange
from service.domain.session import PlannedStop
from service.planning.ballbar.bodies import BallbarCell, arm_body, arm_links, chain_of
from service.planning.ballbar.capsules import Capsules, gaps

_NEST_RADIUS_MM: Final = 8.0  # a cup with its reflector, which stands above its rim
_COLUMN_LINKS: Final = 2  # foot and what the first joint turns: they stand on the floor
_WRIST_LINKS: Final = 3  # that the tool is beside in every position
_AT_ONCE: Final = 2000  # configurations; keeps the arrays small


def floor_z_mm(cell: Cell) -> float:
    """Return the height of floor or table in the world: as stated, else the world's or the robot's foot."""
    stated = cell.limits.floor_z_mm
    return min(0.0, cell.base_nominal.z_mm) if stated is None else stated


def what_is_in_the_way(
    cell: Cell, stops: Sequence[PlannedStop], approach_offset_rad: float | None, *, floor_only: bool = False
) -> str | None:
    """Return one sentence for the first stop, or approach to one, at which something would touch."""
    for first in range(0, len(stops), _AT_ONCE):
        some = stops[first : first + _AT_ONCE]
        joints = np.array([stop.joints_rad for stop in some])
        found = [("The stop at", _faults(cell, joints, floor_only=floor_only))]
        if approach_offset_rad is not None:
            found.append((
                "The approach to",
                _faults(cell, joints + approach_offset_rad, floor_only=floor_only),
            ))
        for row, stop in enumerate(some):
            for what, faults in found:
                if faults[row] is not None:
                    return f"{what} configuration {stop.config} cannot be: {faults[row]}."
    return None


def _faults(cell: Cell, joints_rad: FloatArray, *, floor_only: bool) -> list[str | None]:
    """Return what would touch in each configuration (n, J), None where nothing does."""
    bodies = _bodies(cell, joints_rad)
    found: list[str | None] = [None] * len(joints_rad)
    rooms = _above_floor(bodies, floor_z_mm(cell))
    for name, room_mm, what in rooms if floor_only else chain(rooms, _off_the_arm(bodies)):
        for row in np.flatnonzero(room_mm < 0.0):
            if found[row] is None:
                found[row] = f"{name} would be {-room_mm[row]:.0f} mm {what}"
    return found


@dataclass(frozen=True, slots=True)
class _Bodies:
    links: tuple[int, ...]  # of each piece of the arm
    arm: Capsules
    tool: Capsules  # from the flange to each nest


def _bodies(cell: Cell, joints_rad: FloatArray) -> _Bodies:
    # the outline of the arm asks for three nests; those of the tool come from the cell
    ranges = (JointRange(-np.pi, np.pi),) * cell.robot.n_joints
    outline = BallbarCell(cell.robot, cell.base_nominal, np.zeros((3, 3)), ranges)
    frames = chain_of(outline, joints_rad)
    centres = [np.array(nest.centre_mm) for nest in cell.nests if nest.centre_mm is not None]
    nests = np.stack([frames.points(centre) for centre in centres])
    flange = np.broadcast_to(frames.points(np.zeros(3)), nests.shape)
    tool = Capsules(flange, nests, np.full(len(nests), _NEST_RADIUS_MM))
    return _Bodies(arm_links(outline), arm_body(outline, frames), tool)


def _above_floor(bodies: _Bodies, floor_mm: float) -> Iterator[tuple[str, FloatArray, str]]:
    """Yield the name of each body, its free space [mm] at each configuration, and where it has none."""
    for nest, height in enumerate(_heights(bodies.tool), start=1):
        yield f"tool nest {nest}", height - floor_mm, "below floor or table"
    heights = _heights(bodies.arm)
    for link, height in zip(bodies.links, heights, strict=True):
        if link >= _COLUMN_LINKS:
            yield f"link {link} of the arm", height - floor_mm, "below floor or table"


def _off_the_arm(bodies: _Bodies) -> Iterator[tuple[str, FloatArray, str]]:
    """Yield the same of the tool beside the links before the wrist."""
    last = max(bodies.links)
    inner = [k for k, link in enumerate(bodies.links) if link <= last - _WRIST_LINKS]
    for nest, gap in enumerate(np.min(gaps(bodies.tool, bodies.arm.some(inner)), axis=1), start=1):
        yield f"tool nest {nest}", gap, "inside the arm itself"


def _heights(capsules: Capsules) -> FloatArray:
    """Return the height of the lowest point of each capsule [mm], shape (m, n)."""
    ends = np.minimum(capsules.start_mm[..., 2], capsules.end_mm[..., 2])
    return np.asarray(ends - capsules.radius_mm[:, None])
