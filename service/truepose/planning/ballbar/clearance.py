"""What keeps clear of what: arm and tool of table, base fixture and each other; every bar of everything.

Bodies are capsules (`planning.workspace.capsules`), rooms their smallest gaps [mm]. A bar between cup c and
nest t, with w the unit vector from c to t and a, m the directions in which the two open, leans by

    max(arccos(w . a), arccos(-w . m))

which may be 100 deg: further over, it touches a rim.
"""

from dataclasses import dataclass, replace
from functools import cache
from itertools import combinations, product
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.kinematics.chain import Chain
from truepose.planning.ballbar.bodies import (
    BallbarCell,
    BaseFixture,
    arm_body,
    arm_links,
    bars,
    chain_of,
    fixture_body,
    moved_pieces,
    nest_places,
    tool_body,
    tool_normal,
)
from truepose.planning.workspace.capsules import (
    Capsules,
    gaps,
    gaps_mm,
    join_capsules,
    lowest_mm,
    smallest_gap,
    smallest_gap_of_pairs,
    still,
)

# A half-inch ball lies in its magnetic cup to a bit below its middle; further over, the bar touches the rim.
LEAN_RAD: Final = float(np.radians(100.0))
_COLUMN_LINKS = 2  # foot and what the first joint turns: they stand on the table
# Capsules of links up to two apart, as upper arm and forearm, touch in every position of some shipped arm; of
# those three apart, as shoulder and forearm, none touch at home.
_NEIGHBOURS = 2


@dataclass(frozen=True, slots=True)
class Bodies:
    """The bodies of n configurations about one placement of the base fixture."""

    cell: BallbarCell
    chain: Chain
    arm: Capsules
    links: tuple[int, ...]  # of each piece of the arm
    tool: Capsules
    fixture: Capsules
    nests_mm: FloatArray  # (3, n, 3)
    tool_normal: FloatArray  # (n, 3) direction in which the tool nests open
    fixture_cups_mm: FloatArray  # (K, 3)
    fixture_axes: FloatArray  # (K, 3)


@dataclass(frozen=True, slots=True)
class Bars:
    """Which cup and which nest the L bars of n configurations join, one after the other."""

    base_point: IntArray  # (L, n) 1-based
    nest: IntArray  # (L, n) 1-based


def bodies_at(cell: BallbarCell, fixture: BaseFixture, joints_rad: FloatArray) -> Bodies:
    """Return the bodies of configurations.

    Parameters
    ----------
    cell : BallbarCell
    fixture : BaseFixture
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    Bodies
    """
    chain = chain_of(cell, joints_rad)
    return Bodies(
        cell,
        chain,
        arm_body(cell, chain),
        arm_links(cell),
        tool_body(cell, chain),
        fixture_body(fixture, cell.table_z_mm),
        nest_places(cell, chain),
        np.asarray(chain.end_rotation @ tool_normal(cell.nests_mm)),
        fixture.cups_mm,
        fixture.axes,
    )


def arm_room_mm(bodies: Bodies) -> FloatArray:
    """Return the free space about arm and tool.

    To table, base fixture, keep-out volumes and to themselves.

    Parameters
    ----------
    bodies : Bodies
        Of n configurations.

    Returns
    -------
    ndarray, shape (n,)
        [mm]; negative where something touches.
    """
    off_table = _of_links(bodies, range(_COLUMN_LINKS, len(bodies.cell.link_radii_mm)))
    beside_table = np.minimum(lowest_mm(off_table), lowest_mm(bodies.tool)) - bodies.cell.table_z_mm
    whole = join_capsules([bodies.arm, bodies.tool])
    beside_fixture = smallest_gap(whole, bodies.fixture)
    # Only what moves: where the foot stands the cell's owner has decided, volume or not.
    outside = _outside_keep_outs(bodies.cell, whole.some(_moved(bodies)))
    return np.asarray(np.min([beside_table, beside_fixture, *outside, _self_gap(bodies, whole)], axis=0))


def _moved(bodies: Bodies) -> list[int]:
    """Return the pieces of arm and tool that some joint moves."""
    arm = len(bodies.arm)
    return [*moved_pieces(bodies.cell), *range(arm, arm + len(bodies.tool))]


def _outside_keep_outs(cell: BallbarCell, moving: Capsules) -> list[FloatArray]:
    """Return the smallest gap of a set to each keep-out volume, shape (n,) each."""
    return [gaps_mm(volume, moving).min(axis=0) for volume in cell.keep_outs]


def hands_room_mm(bodies: Bodies) -> FloatArray:
    """Return the free space about the sides of the base, to tool and moving links.

    Parameters
    ----------
    bodies : Bodies
        Of n configurations.

    Returns
    -------
    ndarray, shape (n,)
        [mm]; from the lines between cups, where hands and bar are.
    """
    links = len(bodies.cell.link_radii_mm)
    moving = join_capsules([_of_links(bodies, range(_COLUMN_LINKS, links)), bodies.tool])
    return smallest_gap(moving, still(list(combinations(bodies.fixture_cups_mm, 2)), 0.0))


def _of_links(bodies: Bodies, links: range) -> Capsules:
    return bodies.arm.some([k for k, link in enumerate(bodies.links) if link in links])


def _self_gap(bodies: Bodies, whole: Capsules) -> FloatArray:
    """Return the smallest gap between pieces of arm and tool that are not next to each other, shape (n,)."""
    first, second = _apart(bodies.links, len(bodies.tool), bodies.cell.robot.n_joints)
    return smallest_gap_of_pairs(whole.some(first), whole.some(second))


@cache
def _apart(links: tuple[int, ...], tool: int, last: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Return which two pieces of arm and tool, counted in this order, could meet: indices, one by one.

    The tool's and those of the links before the wrist, and those of links more than two apart. The stem
    leaves the flange, which is next to the forearm's end in every position: it is left out there.
    """
    forearm = last - _NEIGHBOURS
    of_tool = [
        (len(links) + piece, k)
        for piece, (k, link) in product(range(tool), enumerate(links))
        if link < forearm or (link == forearm and piece < tool - 1)
    ]
    of_arm = [
        (upper, lower)
        for (upper, link), (lower, below) in product(enumerate(links), repeat=2)
        if below < link - _NEIGHBOURS
    ]
    pairs = [*of_tool, *of_arm]
    return tuple(first for first, _ in pairs), tuple(second for _, second in pairs)


def bar_room_mm(bodies: Bodies, places: Bars) -> FloatArray:
    """Return the free space about each bar alone in the cell.

    A bar touches the two cups that hold it; how far it may lean over their rims is what limits it there.

    Parameters
    ----------
    bodies : Bodies
        Of n configurations.
    places : Bars
        L each.

    Returns
    -------
    ndarray, shape (L, n)
        [mm]; -inf where it leans too far.
    """
    cups = bodies.fixture_cups_mm[places.base_point - 1]
    nests = np.take_along_axis(bodies.nests_mm, places.nest[:, :, None] - 1, axis=0)
    placed = bars(cups, nests)
    # The bar sits in both: to hold them against it would leave no bar any room.
    own_cup = _gaps_but_one(placed, bodies.fixture, places.base_point - 1)
    own_nest = _gaps_but_one(placed, bodies.tool, places.nest - 1)
    arm = gaps(placed, bodies.arm).min(axis=1)
    ends = np.minimum(placed.start_mm[..., 2], placed.end_mm[..., 2])
    table = ends - placed.radius_mm[:, None] - bodies.cell.table_z_mm
    outside = [gaps_mm(volume, placed) for volume in bodies.cell.keep_outs]
    room = np.min([own_cup, own_nest, arm, table, *outside], axis=0)
    return np.where(_leans(bodies, places, cups, nests) <= LEAN_RAD, room, -np.inf)


def _gaps_but_one(placed: Capsules, others: Capsules, left_out: IntArray) -> FloatArray:
    """Smallest gap of each bar to a set without the member (L, n) that holds it, shape (L, n)."""
    free = gaps(placed, others)
    np.put_along_axis(free, left_out[:, None, :], np.inf, axis=1)
    return np.asarray(free.min(axis=1))


def _leans(bodies: Bodies, places: Bars, cups: FloatArray, nests: FloatArray) -> FloatArray:
    """Larger angle between each bar and the directions in which its two cups open, shape (L, n)."""
    way = (nests - cups) / np.linalg.norm(nests - cups, axis=-1, keepdims=True)
    at_cup = np.einsum("lni,lni->ln", way, bodies.fixture_axes[places.base_point - 1])
    at_nest = -np.einsum("lni,ni->ln", way, bodies.tool_normal)
    return np.asarray(np.arccos(np.clip(np.minimum(at_cup, at_nest), -1.0, 1.0)))


def is_clear(cell: BallbarCell, fixture: BaseFixture, joints_rad: FloatArray) -> BoolArray:
    """Return whether arm and tool keep their room, without a bar.

    Parameters
    ----------
    cell : BallbarCell
        Says how much room that is.
    fixture : BaseFixture
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    room: BoolArray = arm_room_mm(bodies_at(cell, fixture, joints_rad)) >= cell.arm_room_mm
    return room


def without_cups(bodies: Bodies, point: int) -> Bodies:
    """Return the bodies without the two cups that hold the setting ball between them at a base point.

    Parameters
    ----------
    bodies : Bodies
    point : int
        Base point, 1-based; of the tool it is nest 1.

    Returns
    -------
    Bodies
        For their rooms alone: cups are numbered otherwise in it.
    """
    # The ball is half an inch, so that the two cups are nearer to each other than any room that is kept.
    tool = bodies.tool.some(range(1, len(bodies.tool)))
    others = [piece for piece in range(len(bodies.fixture)) if piece != point - 1]
    return replace(bodies, tool=tool, fixture=bodies.fixture.some(others))
