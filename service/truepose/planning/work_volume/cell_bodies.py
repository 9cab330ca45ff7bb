"""Arm and tool of a cell as capsules, and their room: above the floor, outside keep-outs, tool off the arm.

One notion of room for stops (`stop_room`) and for the ways between them (`way_room`), by the capsules that
ballbar plans have (`ballbar/bodies`). The links of the arm are not held against each other: their capsules
are outlines rounded up, and say of a twentieth of what an LR Mate can be chosen to do that forearm and
shoulder touch.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.cell.description import Cell
from truepose.domain.cell.keep_outs import KeepOuts
from truepose.domain.robot import FramePlacement, JointRange, Nest, Robot
from truepose.kinematics.chain import Chain
from truepose.planning.ballbar.clear_ways.bodies import (
    BallbarCell,
    arm_body,
    arm_links,
    chain_of,
    moved_pieces,
)
from truepose.planning.ballbar.clear_ways.capsules import Capsules, gaps
from truepose.planning.work_volume.keep_outs import gaps_mm
from truepose.planning.work_volume.work_space import WorkSpace

_NEST_RADIUS_MM: Final = 8.0  # a cup with its reflector, which stands above its rim
_COLUMN_LINKS: Final = 2  # foot and what the first joint turns: they stand on the floor
_WRIST_LINKS: Final = 3  # that the tool is beside in every position
# About keep-out volumes where the service chooses; a nest that passes an edge between two looks at a way then
# keeps off it by some millimetres still.
_KEPT_OFF_MM: Final = 10.0
_BELOW: Final = "below floor or table"
_INSIDE: Final = "inside the arm itself"


@dataclass(frozen=True, slots=True)
class CellBodies:
    """What is looked at of a cell."""

    arm: BallbarCell  # its outline; that asks for three nests, those of the tool are beside it
    nests_mm: FloatArray  # (K, 3) in the last frame
    floor_z_mm: float  # world
    floor_is_stated: bool  # False: assumed
    keep_outs: KeepOuts = field(default_factory=KeepOuts)
    kept_off_mm: float = 0.0  # room that is wanted about keep-out volumes


@dataclass(frozen=True, slots=True)
class Rooms:
    """Free space [mm] of each body at n configurations, negative where it would touch."""

    names: tuple[str, ...]  # of the m bodies
    places: tuple[str, ...]  # where a body without room would be
    room_mm: FloatArray  # (m, n)

    def least_mm(self) -> FloatArray:
        """Return the least room of each configuration, shape (n,)."""
        return np.asarray(self.room_mm.min(axis=0))

    def what_touches(self, row: int) -> str:
        """Return in words the first body that has no room in a configuration; nests come first."""
        body = int(np.argmax(self.room_mm[:, row] < 0.0))
        return f"{self.names[body]} would be {-self.room_mm[body, row]:.0f} mm {self.places[body]}"


def bodies_of(cell: Cell) -> CellBodies:
    """Return the bodies of a cell; a nest whose centre nobody knows is none."""
    stated = cell.limits.floor_z_mm
    floor_mm = min(0.0, cell.base_nominal.z_mm) if stated is None else stated
    return CellBodies(
        arm_outline(cell.robot, cell.base_nominal),
        _centres_mm(cell.nests),
        floor_mm,
        stated is not None,
        cell.limits.keep_outs,
    )


def bodies_in(space: WorkSpace) -> CellBodies:
    """Return the bodies of a work space, whose table counts as stated."""
    return CellBodies(
        arm_outline(space.robot, space.base),
        _centres_mm(space.nests),
        space.table_z_mm,
        floor_is_stated=True,
        keep_outs=space.keep_outs,
        kept_off_mm=_KEPT_OFF_MM,
    )


def are_outside_keep_outs(space: WorkSpace, joints_rad: FloatArray) -> BoolArray:
    """Whether arm and tool keep their room about all keep-out volumes at configurations (n, J)."""
    outside: BoolArray = np.ones(len(joints_rad), dtype=bool)
    if not space.keep_outs or not len(joints_rad):
        return outside
    bodies = bodies_in(space)
    frames = chain_of(bodies.arm, joints_rad)
    arm, tool = arm_body(bodies.arm, frames), _tool(bodies, frames)
    found = _outside_keep_outs(bodies, arm, arm_links(bodies.arm), tool)
    for _, _, room_mm in found:
        outside &= room_mm >= 0.0
    return outside


def arm_outline(robot: Robot, base: FramePlacement) -> BallbarCell:
    """Return the arm alone, with nothing on its flange, free to turn anywhere."""
    return BallbarCell(robot, base, np.zeros((3, 3)), (JointRange(-np.pi, np.pi),) * robot.n_joints)


def _centres_mm(nests: Sequence[Nest]) -> FloatArray:
    return np.array([nest.centre_mm for nest in nests if nest.centre_mm is not None]).reshape(-1, 3)


def rooms(bodies: CellBodies, joints_rad: FloatArray, *, floor_only: bool = False) -> Rooms:
    """Return the room of every body at configurations (n, J).

    With `floor_only` the tool is not held against the arm: to the floor, and to keep-out volumes.
    """
    frames = chain_of(bodies.arm, joints_rad)
    arm, links = arm_body(bodies.arm, frames), arm_links(bodies.arm)
    tool = _tool(bodies, frames)
    found = list(_above_floor(bodies, arm, links, tool))
    found += list(_outside_keep_outs(bodies, arm, links, tool))
    found += [] if floor_only else list(_off_the_arm(arm, links, tool))
    names, places, room_mm = zip(*found, strict=True)
    return Rooms(names, places, np.array(room_mm))


def _tool(bodies: CellBodies, frames: Chain) -> Capsules:
    """Return what leads from the flange to each nest."""
    flange = frames.points(np.zeros(3))
    nests = np.array([frames.points(nest) for nest in bodies.nests_mm]).reshape(-1, *flange.shape)
    return Capsules(np.broadcast_to(flange, nests.shape), nests, np.full(len(nests), _NEST_RADIUS_MM))


def _above_floor(
    bodies: CellBodies, arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> Iterator[tuple[str, str, FloatArray]]:
    for nest, height in enumerate(_heights(tool), start=1):
        yield f"tool nest {nest}", _BELOW, height - bodies.floor_z_mm
    for link, height in zip(links, _heights(arm), strict=True):
        if link >= _COLUMN_LINKS:
            yield f"link {link} of the arm", _BELOW, height - bodies.floor_z_mm


def _outside_keep_outs(
    bodies: CellBodies, arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> Iterator[tuple[str, str, FloatArray]]:
    """Yield the rooms of tool and moving arm to every keep-out volume."""
    moved = moved_pieces(bodies.arm)
    names = [f"tool nest {nest}" for nest in range(1, len(tool) + 1)]
    names += [f"link {links[piece]} of the arm" for piece in moved]
    for volume in bodies.keep_outs:
        gap_mm = np.concatenate([gaps_mm(volume, tool), gaps_mm(volume, arm.some(moved))])
        for name, own in zip(names, gap_mm - bodies.kept_off_mm, strict=True):
            yield name, f"inside the keep-out volume {volume.name}", own


def _off_the_arm(
    arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> Iterator[tuple[str, str, FloatArray]]:
    """Yield the rooms of the tool beside the links before the wrist."""
    inner = [k for k, link in enumerate(links) if link <= max(links) - _WRIST_LINKS]
    for nest, gap in enumerate(np.min(gaps(tool, arm.some(inner)), axis=1, initial=np.inf), start=1):
        yield f"tool nest {nest}", _INSIDE, gap


def _heights(capsules: Capsules) -> FloatArray:
    """Return the height of the lowest point of each capsule [mm], shape (m, n)."""
    ends = np.minimum(capsules.start_mm[..., 2], capsules.end_mm[..., 2])
    return np.asarray(ends - capsules.radius_mm[:, None])
