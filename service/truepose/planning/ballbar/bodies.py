"""The cell around a ballbar pose as capsules: arm, tool fixture, base fixture, bars. Sizes are stated.

The base fixture: three cups 300 mm apart, or four at the corners of a regular tetrahedron, on a stand. Cup 4
lies below the plane of cups 1, 2, 3 (in the frame of the fixture), because above it, at 300 mm from all
three, is where a tool nest comes. Every face of the tetrahedron that does not look down on the table carries
poses, and each cup opens halfway between those of its faces.

The arm's radii are those of table robots of the IRB 120's and LR Mate's size, read off their makers'
outline drawings and rounded up; a larger arm needs its own. The tool fixture is a plate of three edges and
three spokes 30 mm behind its nests, on a stem from the flange.
"""

from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from itertools import combinations
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell import KeepOuts
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FramePlacement, JointRange, Robot
from truepose.kinematics.chain import Chain, forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.planning.workspace.capsules import Capsules, join_capsules, still

BALL_MM: Final = 10.0  # from the centre of a half-inch ball to the body of the cup behind it
CUP_RADIUS_MM: Final = 8.0
HUB_DEPTH_MM: Final = 60.0  # of the star that carries three cups, below their plane
POST_MM: Final = 40.0  # below which a cup hangs on an arm
STAND_RADIUS_MM: Final = 20.0
_LOWEST_FACE: Final = -0.05  # upward part of the normal of a face that still carries poses


# Without slots: searches ask thousands of times where the cups of one fixture open.
@dataclass(frozen=True)
class BaseFixture:
    """A base fixture at its nominal place: cup k in row k - 1."""

    number: int  # of the placement, from 1
    frame: FramePlacement  # of the base triangle in the world
    cups_mm: FloatArray  # (3, 3) or (4, 3), world

    @property
    def normal(self) -> FloatArray:
        """Unit vector of the side of the base triangle on which the tool is, shape (3,)."""
        return np.asarray(placement_rotation(self.frame)[:, 2])

    @property
    def own_cups_mm(self) -> FloatArray:
        """The cups in the frame of the fixture, shape (K, 3)."""
        return np.asarray((self.cups_mm - placement_translation(self.frame)) @ placement_rotation(self.frame))

    @cached_property
    def hub_mm(self) -> FloatArray:
        """Where the arms to the cups meet, shape (3,)."""
        centre = np.asarray(self.cups_mm.mean(axis=0))
        return centre if len(self.cups_mm) == 4 else centre - HUB_DEPTH_MM * self.normal

    @cached_property
    def axes(self) -> FloatArray:
        """Direction in which each cup opens, shape (K, 3)."""
        axes = np.zeros_like(self.cups_mm)
        for face in self.faces:
            axes[[point - 1 for point in face]] += self._outwards(face)
        # A cup whose faces all look down carries no poses, but is clamped and measured like the
        # others: it opens away from the middle.
        idle = ~axes.any(axis=1)
        axes[idle] = (self.cups_mm - self.hub_mm)[idle]
        return np.asarray(axes / np.linalg.norm(axes, axis=1, keepdims=True))

    @cached_property
    def faces(self) -> tuple[tuple[int, ...], ...]:
        """Every three base points (1-based) that carry poses."""
        if len(self.cups_mm) == 3:
            return ((1, 2, 3),)
        every = combinations((1, 2, 3, 4), 3)
        return tuple(face for face in every if self._outwards(face)[2] > _LOWEST_FACE)

    def _outwards(self, face: tuple[int, ...]) -> FloatArray:
        """Return the unit normal of a face, away from the middle of the fixture, shape (3,).

        From the hub to the middle of the face: of a regular tetrahedron that is its normal; three cups have
        the hub below their middle.
        """
        away = self.cups_mm[[point - 1 for point in face]].mean(axis=0) - self.hub_mm
        return np.asarray(away / np.linalg.norm(away))


def base_fixture(number: int, frame: FramePlacement, points: int = 3, side_mm: float = 300.0) -> BaseFixture:
    """Return a fixture of three or four cups at a place.

    Parameters
    ----------
    number : int
        Of the placement, from 1.
    frame : FramePlacement
        In the world: cup 1 its origin, cup 2 on x, cup 3 in the xy plane, cup 4 below it.
    points : int
        3 or 4.
    side_mm : float
        Between every two cups.

    Returns
    -------
    BaseFixture

    Raises
    ------
    ConfigurationError
        Another number of cups, or a length that is none.
    """
    if points not in {3, 4}:
        raise ConfigurationError(f"A base fixture has 3 or 4 cups, not {points}.")
    if not 0.0 < side_mm < np.inf:
        raise ConfigurationError(
            f"The distance between the cups must be greater than 0 mm (got {side_mm:g} mm)."
        )
    height = np.sqrt(3.0) / 2.0
    unit = np.array([
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [0.5, height, 0.0],
        [0.5, height / 3.0, -np.sqrt(2.0 / 3.0)],
    ])
    cups = side_mm * unit[:points] @ placement_rotation(frame).T + placement_translation(frame)
    return BaseFixture(number, frame, cups)


def fixture_body(fixture: BaseFixture, table_z_mm: float) -> Capsules:
    """Return the posts of the cups (first, in order), the arms that carry them, the stand on the table.

    Parameters
    ----------
    fixture : BaseFixture
    table_z_mm : float
        World.

    Returns
    -------
    Capsules
        At one configuration.
    """
    feet = fixture.cups_mm - BALL_MM * fixture.axes
    bottoms = fixture.cups_mm - POST_MM * fixture.axes
    below = np.array([*fixture.hub_mm[:2], table_z_mm])
    posts = still(list(zip(feet, bottoms, strict=True)), CUP_RADIUS_MM)
    arms = still([(bottom, fixture.hub_mm) for bottom in bottoms], CUP_RADIUS_MM)
    return join_capsules([posts, arms, still([(fixture.hub_mm, below)], STAND_RADIUS_MM)])


PLATE_DEPTH_MM: Final = 30.0
PLATE_RADIUS_MM: Final = 10.0
STEM_RADIUS_MM: Final = 25.0
BAR_RADIUS_MM: Final = 10.0
BAR_NECK_MM: Final = 30.0  # slim part between the ball and the body of the bar, at either end
_POINT_MM: Final = 1.0  # shorter pieces of the arm are inside their neighbours

# Base, then the link that each joint turns: foot, shoulder, upper arm, elbow, forearm, wrist, flange.
_TABLE_ARM_RADII_MM: Final = (90.0, 90.0, 70.0, 70.0, 60.0, 45.0, 40.0)


def table_arm_radii_mm(joints: int) -> tuple[float, ...]:
    """Return radii of base and links; an arm of another number of joints thins from foot to flange alike.

    Parameters
    ----------
    joints : int
        J.

    Returns
    -------
    tuple of float
        J + 1 [mm].
    """
    place = np.linspace(0.0, 1.0, joints + 1)
    known = np.linspace(0.0, 1.0, len(_TABLE_ARM_RADII_MM))
    return tuple(float(radius) for radius in np.interp(place, known, _TABLE_ARM_RADII_MM))


@dataclass(frozen=True, slots=True)
class BallbarCell:
    """What limits the arm: the robot, its tool nests, ranges, the table, and how much room is kept."""

    robot: Robot
    base: FramePlacement  # nominal, in the world
    nests_mm: FloatArray  # (3, 3) tool nests in the flange frame
    ranges: tuple[JointRange, ...]  # in which configurations are chosen
    leg_mm: float = 300.0  # of the ballbar, and of the sides of the base fixture that it measures
    table_z_mm: float = 0.0  # world
    link_radii_mm: tuple[float, ...] = ()  # base and each link; empty: those of a table robot
    bar_room_mm: float = 5.0  # around the ballbar
    arm_room_mm: float = 10.0  # around arm and tool
    keep_outs: KeepOuts = field(default_factory=KeepOuts)

    def __post_init__(self) -> None:
        if self.nests_mm.shape != (3, 3) or not np.all(np.isfinite(self.nests_mm)):
            raise ConfigurationError(
                "A ballbar pose needs three tool nests with known centres. Enter their centres."
            )
        if len(self.ranges) != self.robot.n_joints:
            raise ConfigurationError(
                f"{len(self.ranges)} joint ranges were given for {self.robot.n_joints} joints. Give one "
                "range per joint."
            )
        if not self.link_radii_mm:
            object.__setattr__(self, "link_radii_mm", table_arm_radii_mm(self.robot.n_joints))
        if len(self.link_radii_mm) != self.robot.n_joints + 1:
            raise ConfigurationError(
                f"{len(self.link_radii_mm)} radii were given for the base and {self.robot.n_joints} links. "
                "Give one radius for each."
            )


def chain_of(cell: BallbarCell, joints_rad: FloatArray) -> Chain:
    """Return the nominal frames of configurations in the world.

    Parameters
    ----------
    cell : BallbarCell
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    Chain
    """
    rotation, origin = placement_rotation(cell.base), placement_translation(cell.base)
    return forward(nominal_values(cell.robot, joints_rad), rotation, origin)


def pose_in_base(cell: BallbarCell, poses: FloatArray) -> FloatArray:
    """Return poses of the world in the robot's base.

    Parameters
    ----------
    cell : BallbarCell
    poses : ndarray, shape (n, 4, 4)

    Returns
    -------
    ndarray, shape (n, 4, 4)
    """
    base = np.eye(4)
    base[:3, :3], base[:3, 3] = placement_rotation(cell.base), placement_translation(cell.base)
    return np.asarray(np.linalg.inv(base) @ poses)


def nest_places(cell: BallbarCell, chain: Chain) -> FloatArray:
    """Return the tool nests in the world.

    Parameters
    ----------
    cell : BallbarCell
    chain : Chain
        Of n configurations.

    Returns
    -------
    ndarray, shape (3, n, 3)
        [mm].
    """
    return chain.places(cell.nests_mm)


def arm_body(cell: BallbarCell, chain: Chain) -> Capsules:
    """Return the arm's links from the base to the flange; piece k belongs to link `arm_links(cell)[k]`.

    A link of the DH table (Craig's) goes along x by a, then along z by d: a piece each, where it is longer
    than 1 mm.

    Parameters
    ----------
    cell : BallbarCell
    chain : Chain
        Of n configurations.

    Returns
    -------
    Capsules
        m pieces; none of an arm of short links alone.
    """
    starts, ends = [], []
    for joint, row in enumerate(cell.robot.joints):
        if _is_long(row.a_mm):
            starts.append(chain.origin_before[joint])
            ends.append(chain.origin_middle[joint])
        if _is_long(row.d_mm):
            starts.append(chain.origin_middle[joint])
            ends.append(chain.origin[joint])
    radii = np.array([cell.link_radii_mm[link] for link in arm_links(cell)])
    shape = (len(radii), len(chain.end_origin), 3)  # of an arm of short links alone: no piece
    return Capsules(np.array(starts).reshape(shape), np.array(ends).reshape(shape), radii)


def arm_links(cell: BallbarCell) -> tuple[int, ...]:
    """Return the link (0: base) of each piece of `arm_body`: an a belongs to the link before its joint.

    Parameters
    ----------
    cell : BallbarCell

    Returns
    -------
    tuple of int
        m, ascending.
    """
    links = []
    for joint, row in enumerate(cell.robot.joints):
        links += [joint] * _is_long(row.a_mm) + [joint + 1] * _is_long(row.d_mm)
    return tuple(links)


def moved_pieces(cell: BallbarCell) -> tuple[int, ...]:
    """Return the pieces of `arm_body` that some joint moves: all but those along axis 1.

    Parameters
    ----------
    cell : BallbarCell

    Returns
    -------
    tuple of int
        Indices.
    """
    first = cell.robot.joints[0]
    return tuple(range(_is_long(first.a_mm) + _is_long(first.d_mm), len(arm_links(cell))))


def _is_long(piece_mm: float) -> bool:
    return abs(piece_mm) > _POINT_MM


def tool_normal(nests_mm: FloatArray) -> FloatArray:
    """Return the unit normal of the nests' plane on the side away from the flange.

    Parameters
    ----------
    nests_mm : ndarray, shape (3, 3)
        In the flange frame, not on a line.

    Returns
    -------
    ndarray, shape (3,)
        In the flange frame.
    """
    normal = np.cross(nests_mm[1] - nests_mm[0], nests_mm[2] - nests_mm[0])
    normal /= np.linalg.norm(normal)
    # Nests open away from the flange: seen from the flange frame's origin their middle lies that way.
    return np.asarray(normal if normal @ nests_mm.mean(axis=0) > 0 else -normal)


def tool_body(cell: BallbarCell, chain: Chain) -> Capsules:
    """Return the tool fixture: cups (first, in order), plate, stem.

    Parameters
    ----------
    cell : BallbarCell
    chain : Chain
        Of n configurations.

    Returns
    -------
    Capsules
        In the world; the stem is the last.
    """
    tool = _tool_on_flange(tuple(map(tuple, cell.nests_mm.tolist())))
    placed = chain.places(np.concatenate([tool.start_mm[:, 0], tool.end_mm[:, 0]]))
    return Capsules(placed[: len(tool)], placed[len(tool) :], tool.radius_mm)


@lru_cache(maxsize=8)  # of a cell: every step of a search for a way asks for it
def _tool_on_flange(nests_mm: tuple[tuple[float, ...], ...]) -> Capsules:
    """Return the tool fixture in the flange frame, at the one configuration that it always has there."""
    nests = np.array(nests_mm)
    normal = tool_normal(nests)
    corners = nests - PLATE_DEPTH_MM * normal
    centre = corners.mean(axis=0)
    cups = zip(nests - BALL_MM * normal, corners, strict=True)
    edges = zip(corners, np.roll(corners, 1, axis=0), strict=True)
    spokes = ((corner, centre) for corner in corners)
    return join_capsules([
        still(list(cups), CUP_RADIUS_MM),
        still([*edges, *spokes], PLATE_RADIUS_MM),
        still([(np.zeros(3), centre)], STEM_RADIUS_MM),
    ])


def bars(cups_mm: FloatArray, nests_mm: FloatArray) -> Capsules:
    """Return bars between cups and nests, without the slim ends at the balls.

    Parameters
    ----------
    cups_mm, nests_mm : ndarray, shape (L, n, 3)
        Farther apart than twice the neck.

    Returns
    -------
    Capsules
        L at n configurations.
    """
    way = nests_mm - cups_mm
    # With its ends it would touch the cups that hold it.
    neck = BAR_NECK_MM * way / np.linalg.norm(way, axis=-1, keepdims=True)
    return Capsules(cups_mm + neck, nests_mm - neck, np.full(len(cups_mm), BAR_RADIUS_MM))
