"""Arm and tool of a cell as capsules, and their room at configurations.

One notion of room for stops (`first_obstruction`) and for the ways between them (`path_clearance`), by the
capsules that ballbar plans have (`planning.ballbar.bodies`). The links of the arm are not held against each
other: their capsules are outlines rounded up, and say of a twentieth of what an LR Mate can be chosen to do
that forearm and shoulder touch.

Of stops that somebody gives, refused is what would touch; chosen stops keep more room than that (`space`).
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.cell import Cell, KeepOuts
from truepose.domain.robot import FramePlacement, JointRange, Nest, Robot
from truepose.domain.session import PlaceOf, PlannedStop
from truepose.kinematics.chain import Chain
from truepose.messages.message import Message, message
from truepose.planning.ballbar.bodies import (
    BallbarCell,
    arm_body,
    arm_links,
    chain_of,
    moved_pieces,
)
from truepose.planning.workspace.capsules import Capsules, gaps, gaps_mm, join_capsules
from truepose.planning.workspace.space import WorkSpace

_NEST_RADIUS_MM: Final = 8.0  # a cup with its reflector, which stands above its rim
_COLUMN_LINKS: Final = 2  # foot and what the first joint turns: they stand on the floor
_WRIST_LINKS: Final = 3  # that the tool is beside in every position
# About keep-out volumes where the service chooses; a nest that passes an edge between two looks at a way then
# keeps off it by some millimetres still.
_KEPT_OFF_MM: Final = 10.0
_BELOW: Final = message("room.below")
_INSIDE: Final = message("room.inside_arm")
_IN_THE_FIXTURE: Final = message("room.inside_fixture")


@dataclass(frozen=True, slots=True)
class CellBodies:
    """What is looked at of a cell.

    Attributes
    ----------
    arm : BallbarCell
        Its outline; that asks for three nests, those of the tool are beside it.
    nests_mm : ndarray, shape (K, 3)
        In the flange frame.
    floor_z_mm : float
        World.
    floor_is_stated : bool
        False: assumed.
    keep_outs : KeepOuts
    kept_off_mm : float
        Room that is wanted about keep-out volumes.
    fixture : Capsules or None
        Of a ballbar's base fixture, at one configuration; None: none stands there, or it is not looked at.
    """

    arm: BallbarCell
    nests_mm: FloatArray
    floor_z_mm: float
    floor_is_stated: bool
    keep_outs: KeepOuts = field(default_factory=KeepOuts)
    kept_off_mm: float = 0.0
    fixture: Capsules | None = None


@dataclass(frozen=True, slots=True)
class Rooms:
    """Free space of each body at n configurations.

    Attributes
    ----------
    names : tuple of Message
        Of the m bodies.
    places : tuple of Message
        Where a body without room would be.
    room_mm : ndarray, shape (m, n)
        Negative where it would touch.
    """

    names: tuple[Message, ...]
    places: tuple[Message, ...]
    room_mm: FloatArray

    def least_mm(self) -> FloatArray:
        """Return the least room of each configuration, shape (n,); inf where nothing is looked at."""
        return np.asarray(self.room_mm.min(axis=0, initial=np.inf))

    def what_touches(self, row: int) -> Message:
        """Return in words the first body that has no room in a configuration; nests come first.

        Parameters
        ----------
        row : int
            Of a configuration in which something touches.

        Returns
        -------
        Message
            With the depth by which it would be inside [mm].
        """
        body = int(np.argmax(self.room_mm[:, row] < 0.0))
        deep_mm = float(-self.room_mm[body, row])
        return message("room.touches", body=self.names[body], deep_mm=deep_mm, place=self.places[body])


def bodies_of(cell: Cell) -> CellBodies:
    """Return the bodies of a cell; a nest whose centre nobody knows is none.

    Parameters
    ----------
    cell : Cell

    Returns
    -------
    CellBodies
        On the floor of the cell. No room is asked for about keep-out volumes: given stops are refused only
        where something would touch.
    """
    return CellBodies(
        arm_outline(cell.robot, cell.base_nominal),
        _centres_mm(cell.nests),
        cell.floor_z_mm,
        cell.limits.floor_z_mm is not None,
        cell.limits.keep_outs,
    )


def bodies_in(space: WorkSpace) -> CellBodies:
    """Return the bodies of a work space, whose table counts as stated, with room kept off keep-out volumes.

    Parameters
    ----------
    space : WorkSpace

    Returns
    -------
    CellBodies
    """
    return CellBodies(
        arm_outline(space.robot, space.base),
        _centres_mm(space.nests),
        space.table_z_mm,
        floor_is_stated=True,
        keep_outs=space.keep_outs,
        kept_off_mm=_KEPT_OFF_MM,
    )


def are_outside_keep_outs(space: WorkSpace, joints_rad: FloatArray) -> BoolArray:
    """Return whether arm and tool keep their room about all keep-out volumes.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray of bool, shape (n,)
        All where there are no volumes.
    """
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
    """Return the arm alone, with nothing on its flange, free to turn anywhere.

    Parameters
    ----------
    robot : Robot
    base : FramePlacement
        In the world.

    Returns
    -------
    BallbarCell
    """
    # A ballbar's cell has three nests and ranges; the outline of the arm, which is what is wanted, asks
    # for neither.
    return BallbarCell(robot, base, np.zeros((3, 3)), (JointRange(-np.pi, np.pi),) * robot.n_joints)


def _centres_mm(nests: Sequence[Nest]) -> FloatArray:
    return np.array([nest.centre_mm for nest in nests if nest.centre_mm is not None]).reshape(-1, 3)


def rooms(bodies: CellBodies, joints_rad: FloatArray, *, floor_only: bool = False) -> Rooms:
    """Return the room of every body at configurations.

    Parameters
    ----------
    bodies : CellBodies
    joints_rad : ndarray, shape (n, J)
    floor_only : bool
        The tool is not held against the arm: only to the floor, and to keep-out volumes.

    Returns
    -------
    Rooms
        Nests first, so that a sentence names what a person sees first.
    """
    frames = chain_of(bodies.arm, joints_rad)
    arm, links = arm_body(bodies.arm, frames), arm_links(bodies.arm)
    tool = _tool(bodies, frames)
    found = list(_above_floor(bodies, arm, links, tool))
    found += list(_outside_keep_outs(bodies, arm, links, tool))
    found += list(_off_the_fixture(bodies, arm, links, tool))
    found += [] if floor_only else list(_off_the_arm(bodies, arm, links, tool))
    names, places = tuple(name for name, _, _ in found), tuple(place for _, place, _ in found)
    room_mm = np.array([room for _, _, room in found]).reshape(len(found), len(joints_rad))
    return Rooms(names, places, room_mm)


def _tool(bodies: CellBodies, frames: Chain) -> Capsules:
    """Return what leads from the flange to each nest."""
    flange = frames.points(np.zeros(3))
    nests = np.array([frames.points(nest) for nest in bodies.nests_mm]).reshape(-1, *flange.shape)
    return Capsules(np.broadcast_to(flange, nests.shape), nests, np.full(len(nests), _NEST_RADIUS_MM))


def _above_floor(
    bodies: CellBodies, arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> Iterator[tuple[Message, Message, FloatArray]]:
    for nest, height in enumerate(_heights(tool), start=1):
        yield message("room.nest", nest=nest), _BELOW, height - bodies.floor_z_mm
    for link, height in zip(links, _heights(arm), strict=True):
        if link >= _COLUMN_LINKS:
            yield message("room.link", link=link), _BELOW, height - bodies.floor_z_mm


def _outside_keep_outs(
    bodies: CellBodies, arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> Iterator[tuple[Message, Message, FloatArray]]:
    """Yield the rooms of tool and moving arm to every keep-out volume."""
    names, moving = _moving(bodies, arm, links, tool)
    for volume in bodies.keep_outs:
        gap_mm = gaps_mm(volume, moving)
        for name, own in zip(names, gap_mm - bodies.kept_off_mm, strict=True):
            yield name, message("room.inside_keep_out", volume=volume.name), own


def _off_the_fixture(
    bodies: CellBodies, arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> Iterator[tuple[Message, Message, FloatArray]]:
    """Yield the rooms of tool and moving arm beside the base fixture, where one stands there."""
    if bodies.fixture is None:
        return
    names, moving = _moving(bodies, arm, links, tool)
    for name, own in zip(names, np.min(gaps(moving, bodies.fixture), axis=1), strict=True):
        yield name, _IN_THE_FIXTURE, own


def _moving(
    bodies: CellBodies, arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> tuple[list[Message], Capsules]:
    """Return the names of all nests and of what joints move of the arm, and these."""
    # What no joint moves is where the cell's owner put it.
    moved = moved_pieces(bodies.arm)
    names = [message("room.nest", nest=nest) for nest in range(1, len(tool) + 1)]
    names += [message("room.link", link=links[piece]) for piece in moved]
    return names, join_capsules([tool, arm.some(moved)])


def _off_the_arm(
    bodies: CellBodies, arm: Capsules, links: tuple[int, ...], tool: Capsules
) -> Iterator[tuple[Message, Message, FloatArray]]:
    """Yield the rooms of the tool beside the links before the wrist."""
    # By the joints, not by the last piece: an arm whose last link has no length has as long a wrist.
    last = bodies.arm.robot.n_joints - _WRIST_LINKS
    inner = [k for k, link in enumerate(links) if link <= last]
    for nest, gap in enumerate(np.min(gaps(tool, arm.some(inner)), axis=1, initial=np.inf), start=1):
        yield message("room.nest", nest=nest), _INSIDE, gap


def _heights(capsules: Capsules) -> FloatArray:
    """Return the height of the lowest point of each capsule [mm], shape (m, n)."""
    ends = np.minimum(capsules.start_mm[..., 2], capsules.end_mm[..., 2])
    return np.asarray(ends - capsules.radius_mm[:, None])


_IN_THE_WAY: Final[dict[PlaceOf, str]] = {
    "work": "room.at.work",
    "approach": "room.at.approach",
    "stop": "room.at.stop",
}
_AT_ONCE: Final = 2000  # configurations; keeps the arrays small


def first_obstruction(
    bodies: CellBodies,
    stops: Sequence[PlannedStop],
    approach_offset_rad: float | None,
    *,
    floor_only: bool = False,
) -> Message | None:
    """Return one sentence for the first place on the way, or stop, at which something would touch.

    Parameters
    ----------
    bodies : CellBodies
    stops : sequence of PlannedStop
    approach_offset_rad : float or None
        Of the session.
    floor_only : bool
        As of `rooms`.

    Returns
    -------
    Message or None
        None: nothing touches at any of them. The ways between are not looked at.
    """
    places = [(stop.config, *place) for stop in stops for place in stop.places(approach_offset_rad)]
    for first in range(0, len(places), _AT_ONCE):
        some = places[first : first + _AT_ONCE]
        found = rooms(bodies, np.array([place_rad for _, _, place_rad in some]), floor_only=floor_only)
        touching = found.least_mm() < 0.0
        if touching.any():
            row = int(np.argmax(touching))
            config, what, _ = some[row]
            return message(_IN_THE_WAY[what], config=config, touches=found.what_touches(row))
    return None
