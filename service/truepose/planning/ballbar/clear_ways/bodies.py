"""The cell around a ballbar pose as capsules: arm, tool fixture, bars. The sizes are stated, not measured.

The arm's radii are those of table robots of the IRB 120's and LR Mate's size, read off their makers'
outline drawings and rounded up; a larger arm needs its own. The tool fixture is a plate of three edges and
three spokes 30 mm behind its nests, on a stem from the flange.
"""

from dataclasses import dataclass, field
from functools import lru_cache
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell.keep_outs import KeepOuts
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement, JointRange, Robot
from truepose.kinematics.chain import Chain, forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.planning.ballbar.clear_ways.capsules import Capsules, joined, still
from truepose.planning.ballbar.fixture import BALL_MM, CUP_RADIUS_MM

PLATE_DEPTH_MM: Final = 30.0
PLATE_RADIUS_MM: Final = 10.0
STEM_RADIUS_MM: Final = 25.0
BAR_RADIUS_MM: Final = 10.0
BAR_NECK_MM: Final = 30.0  # slim part between the ball and the body of the bar, at either end
_POINT_MM: Final = 1.0  # shorter pieces of the arm are inside their neighbours

# Base, then the link that each joint turns: foot, shoulder, upper arm, elbow, forearm, wrist, flange.
_TABLE_ARM_RADII_MM: Final = (90.0, 90.0, 70.0, 70.0, 60.0, 45.0, 40.0)


def table_arm_radii_mm(joints: int) -> tuple[float, ...]:
    """Return radii of base and links; an arm of another number of joints thins from foot to flange alike."""
    place = np.linspace(0.0, 1.0, joints + 1)
    known = np.linspace(0.0, 1.0, len(_TABLE_ARM_RADII_MM))
    return tuple(float(radius) for radius in np.interp(place, known, _TABLE_ARM_RADII_MM))


@dataclass(frozen=True, slots=True)
class BallbarCell:
    """What limits the arm: the robot, its tool nests, ranges, the table, and how much room is kept."""

    robot: Robot
    base: FramePlacement  # nominal, in the world
    nests_mm: FloatArray  # (3, 3) tool nests in the last frame
    ranges: tuple[JointRange, ...]  # in which configurations are chosen
    leg_mm: float = 300.0  # of the ballbar, and of the sides of the base fixture that it measures
    table_z_mm: float = 0.0  # world
    link_radii_mm: tuple[float, ...] = ()  # base and each link; empty: those of a table robot
    bar_room_mm: float = 5.0  # around the ballbar
    arm_room_mm: float = 10.0  # around arm and tool
    keep_outs: KeepOuts = field(default_factory=KeepOuts)

    def __post_init__(self) -> None:
        if self.nests_mm.shape != (3, 3) or not np.all(np.isfinite(self.nests_mm)):
            raise ConfigurationError("A ballbar pose needs three tool nests with known centres; enter them.")
        if len(self.ranges) != self.robot.n_joints:
            raise ConfigurationError(
                f"{len(self.ranges)} joint ranges are given for {self.robot.n_joints} joints."
            )
        if not self.link_radii_mm:
            object.__setattr__(self, "link_radii_mm", table_arm_radii_mm(self.robot.n_joints))
        if len(self.link_radii_mm) != self.robot.n_joints + 1:
            raise ConfigurationError(
                f"{len(self.link_radii_mm)} radii are given for the base and {self.robot.n_joints} links."
            )


def chain_of(cell: BallbarCell, joints_rad: FloatArray) -> Chain:
    """Return the nominal frames of configurations (n, J) in the world."""
    rotation, origin = placement_rotation(cell.base), placement_translation(cell.base)
    return forward(nominal_values(cell.robot, joints_rad), rotation, origin)


def pose_in_base(cell: BallbarCell, poses: FloatArray) -> FloatArray:
    """Return poses (n, 4, 4) of the world in the robot's base."""
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = placement_rotation(cell.base), placement_translation(cell.base)
    return np.asarray(np.linalg.inv(base) @ poses)


def nest_places(cell: BallbarCell, chain: Chain) -> FloatArray:
    """Return the tool nests in the world [mm], shape (3, n, 3)."""
    return chain.places(cell.nests_mm)


def arm_body(cell: BallbarCell, chain: Chain) -> Capsules:
    """Return the arm's links from the base to the flange; piece k belongs to link `arm_links(cell)[k]`."""
    starts, ends = [], []
    for joint, row in enumerate(cell.robot.joints):
        if _is_long(row.a_mm):
            starts.append(chain.origin_before[joint])
            ends.append(chain.origin_middle[joint])
        if _is_long(row.d_mm):
            starts.append(chain.origin_middle[joint])
            ends.append(chain.origin[joint])
    radii = np.array([cell.link_radii_mm[link] for link in arm_links(cell)])
    return Capsules(np.stack(starts), np.stack(ends), radii)


def arm_links(cell: BallbarCell) -> tuple[int, ...]:
    """Return the link (0: base) of each piece of `arm_body`: an a belongs to the link before its joint."""
    links = []
    for joint, row in enumerate(cell.robot.joints):
        links += [joint] * _is_long(row.a_mm) + [joint + 1] * _is_long(row.d_mm)
    return tuple(links)


def moved_pieces(cell: BallbarCell) -> tuple[int, ...]:
    """Return the pieces of `arm_body` that some joint moves: all but those along axis 1."""
    first = cell.robot.joints[0]
    return tuple(range(_is_long(first.a_mm) + _is_long(first.d_mm), len(arm_links(cell))))


def _is_long(piece_mm: float) -> bool:
    return abs(piece_mm) > _POINT_MM


def tool_normal(nests_mm: FloatArray) -> FloatArray:
    """Return the unit normal of the nests' plane on the side away from the flange, last frame, shape (3,)."""
    normal = np.cross(nests_mm[1] - nests_mm[0], nests_mm[2] - nests_mm[0])
    normal /= np.linalg.norm(normal)
    return np.asarray(normal if normal @ nests_mm.mean(axis=0) > 0 else -normal)


def tool_body(cell: BallbarCell, chain: Chain) -> Capsules:
    """Return the tool fixture: cups (first, in order), plate, stem."""
    tool = _tool_on_flange(tuple(map(tuple, cell.nests_mm.tolist())))
    placed = chain.places(np.concatenate([tool.start_mm[:, 0], tool.end_mm[:, 0]]))
    return Capsules(placed[: len(tool)], placed[len(tool) :], tool.radius_mm)


@lru_cache(maxsize=8)  # of a cell: every step of a search for a way asks for it
def _tool_on_flange(nests_mm: tuple[tuple[float, ...], ...]) -> Capsules:
    """Return the tool fixture in the last frame, at the one configuration that it always has there."""
    nests = np.array(nests_mm)
    normal = tool_normal(nests)
    corners = nests - PLATE_DEPTH_MM * normal
    centre = corners.mean(axis=0)
    cups = zip(nests - BALL_MM * normal, corners, strict=True)
    edges = zip(corners, np.roll(corners, 1, axis=0), strict=True)
    spokes = ((corner, centre) for corner in corners)
    return joined([
        still(list(cups), CUP_RADIUS_MM),
        still([*edges, *spokes], PLATE_RADIUS_MM),
        still([(np.zeros(3), centre)], STEM_RADIUS_MM),
    ])


def bars(cups_mm: FloatArray, nests_mm: FloatArray) -> Capsules:
    """Return bars between cups (L, n, 3) and nests (L, n, 3), without the slim ends at the balls."""
    way = nests_mm - cups_mm
    neck = BAR_NECK_MM * way / np.linalg.norm(way, axis=-1, keepdims=True)
    return Capsules(cups_mm + neck, nests_mm - neck, np.full(len(cups_mm), BAR_RADIUS_MM))
