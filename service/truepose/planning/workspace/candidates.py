"""Random configurations that can be measured: within the ranges, clear of things, one nest in sight.

The tracker sees a reflector within its cone where nothing is between them. In the way may be the arm, as
capsules, and keep-out volumes; one in which the tracker itself stands is no solid thing and hides nothing.
The last link carries the nests: what it hides is said by where they face.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.kinematics.chain import Chain
from truepose.planning.ballbar.bodies import arm_body, arm_links
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.workspace.bodies import are_outside_keep_outs, bodies_in
from truepose.planning.workspace.capsules import Capsules, gaps_mm, look_at, signed_mm, smallest_gap
from truepose.planning.workspace.space import (
    WorkSpace,
    cosines_to_tracker,
    is_clear,
    nest_places,
    nominal_chain,
    require_consistent,
    within,
)

_BEAM_RADIUS_MM: Final = 5.0


def cosines_in_sight(space: WorkSpace, chain: Chain, among: BoolArray | None = None) -> FloatArray:
    """Return the cosines between where each nest's reflector faces and the tracker.

    Parameters
    ----------
    space : WorkSpace
    chain : Chain
        Of n configurations.
    among : ndarray of bool, shape (n,), optional
        Configurations at which it is looked whether something is in the way; by default all. Looked at is
        only what the tracker would see but for that.

    Returns
    -------
    ndarray, shape (K, n)
        -inf where something stands between nest and tracker.
    """
    cosines = cosines_to_tracker(space, chain)
    if space.tracker_position_mm is None:
        return cosines
    looked_at = is_seen(space, cosines) if among is None else is_seen(space, cosines) & among
    nest, row = np.nonzero(looked_at)
    hidden = _is_hidden(space, chain, nest, row, np.array(space.tracker_position_mm))
    cosines[nest[hidden], row[hidden]] = -np.inf
    return cosines


def is_seen(space: WorkSpace, cosines: FloatArray) -> BoolArray:
    """Return whether reflectors with these cosines return the beam.

    Parameters
    ----------
    space : WorkSpace
        Says within which angle they do.
    cosines : ndarray, any shape
        As of `cosines_in_sight`.

    Returns
    -------
    ndarray of bool, of that shape
    """
    seen: BoolArray = cosines >= np.cos(space.seen_within_rad)
    return seen


def _is_hidden(
    space: WorkSpace, chain: Chain, nest: IntArray, row: IntArray, tracker_mm: FloatArray
) -> BoolArray:
    """Return whether something stands before some nests (0-based) at some configurations, m of each.

    The beam is a capsule from nest to tracker, of 5 mm about its axis.
    """
    start = nest_places(space, chain)[nest, row][None]
    beam = Capsules(start, np.broadcast_to(tracker_mm, start.shape), np.full(1, _BEAM_RADIUS_MM))
    hidden: BoolArray = np.zeros(len(row), dtype=bool)
    for volume in space.keep_outs:
        # A volume round the tracker keeps the arm away from it; solid it is not, or it would see
        # nothing.
        if signed_mm(volume, tracker_mm) > 0.0:
            hidden |= gaps_mm(volume, beam)[0] < 0.0
    hidden |= smallest_gap(_before_the_flange(space, chain).at(row), beam) < 0.0
    return hidden


def _before_the_flange(space: WorkSpace, chain: Chain) -> Capsules:
    arm = bodies_in(space).arm
    # A nest is carried by the last link: its beam would begin inside it and count as hidden everywhere.
    before = [k for k, link in enumerate(arm_links(arm)) if link < space.robot.n_joints]
    return arm_body(arm, chain).some(before)


_BATCH: Final = 8192
_MOST_BATCHES: Final = 60  # half a million draws; a cell in which so many fail is set up wrongly
_HOPELESS: Final = 10  # batches of which none can be measured


@dataclass(frozen=True, slots=True)
class Candidates:
    """n feasible configurations and the nest to measure in each.

    Attributes
    ----------
    joints_rad : ndarray, shape (n, J)
    nest : ndarray, shape (n,)
        1-based, the one that faces the tracker best.
    """

    joints_rad: FloatArray
    nest: IntArray

    def __len__(self) -> int:
        return len(self.nest)

    def subset(self, rows: IntArray) -> "Candidates":
        """Return some of them, in the order of `rows`."""
        return Candidates(self.joints_rad[rows], self.nest[rows])

    def joined(self, others: "Candidates") -> "Candidates":
        """Return these and behind them others."""
        return Candidates(
            np.vstack([self.joints_rad, others.joints_rad]), np.concatenate([self.nest, others.nest])
        )


def draw_candidates(space: WorkSpace, n: int, rng: np.random.Generator) -> Candidates:
    """Draw n feasible configurations, uniformly in the joint ranges, by rejection.

    Parameters
    ----------
    space : WorkSpace
    n : int
    rng : numpy.random.Generator
        The same state gives the same candidates.

    Returns
    -------
    Candidates

    Raises
    ------
    WorkSpaceError
        What is said of the cell contradicts itself.
    TooFewCandidatesError
        Hardly any configuration is feasible: fewer than n of half a million, or none of the first 80,000.
    """
    require_consistent(space)
    joints: list[FloatArray] = []
    nests: list[IntArray] = []
    found = 0
    for batch in range(1, _MOST_BATCHES + 1):
        drawn = _draw(space, rng)
        feasible, nest = judge(space, drawn, rng)
        joints.append(drawn[feasible])
        nests.append(nest[feasible])
        found += int(feasible.sum())
        if found >= n:
            return Candidates(np.concatenate(joints)[:n], np.concatenate(nests)[:n])
        # Out of reach altogether is said at once, not after half a million draws.
        if batch == _HOPELESS and not found:
            break
    raise TooFewCandidatesError(
        f"{found} of {_BATCH * batch} random configurations can be measured; {n} are needed. Check the joint "
        "ranges, the tracker position, the directions the reflectors face and the table height."
        f"{look_at(space.keep_outs)}"
    )


def _draw(space: WorkSpace, rng: np.random.Generator) -> FloatArray:
    low = np.array([limit.lower_rad for limit in space.ranges])
    high = np.array([limit.upper_rad for limit in space.ranges])
    drawn: FloatArray = low + (high - low) * rng.random((_BATCH, len(low)))
    return drawn


def judge(space: WorkSpace, joints_rad: FloatArray, rng: np.random.Generator) -> tuple[BoolArray, IntArray]:
    """Judge configurations by the rules of the work space, the approach included.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)
    rng : numpy.random.Generator
        Decides between nests that face the tracker equally well.

    Returns
    -------
    feasible : ndarray of bool, shape (n,)
    nest : ndarray, shape (n,)
        1-based nest that faces the tracker best, whether it is seen or not.
    """
    chain = nominal_chain(space, joints_rad)
    # From cheap to dear: cones, then rooms, then beams past arm and volumes, each among what is left.
    feasible = is_seen(space, cosines_to_tracker(space, chain).max(axis=0))
    feasible[feasible] = have_room_to_approach(space, joints_rad[feasible])
    cosines = cosines_in_sight(space, chain, feasible)
    # Without facings all nests are seen alike, and argmax would take the first of them every time.
    shuffled = rng.permutation(len(cosines))
    best = shuffled[np.argmax(cosines[shuffled], axis=0)]
    feasible &= is_seen(space, np.max(cosines, axis=0))
    return feasible, (best + 1).astype(np.int64)


def have_room_to_approach(space: WorkSpace, joints_rad: FloatArray) -> BoolArray:
    """Return whether the arm may be at configurations, and where it approaches them from.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray of bool, shape (n,)
        The way between the two is not looked at.
    """
    room = has_room(space, joints_rad, nominal_chain(space, joints_rad))
    if space.approach_offset_rad is not None:
        begin = joints_rad[room] + space.approach_offset_rad
        room[room] = has_room(space, begin, nominal_chain(space, begin))
    return room


def has_room(space: WorkSpace, joints_rad: FloatArray, chain: Chain) -> BoolArray:
    """Return whether the arm may be at configurations: within its limits, clear of everything known.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)
    chain : Chain
        Of these configurations.

    Returns
    -------
    ndarray of bool, shape (n,)
    """
    room: BoolArray = is_clear(space, chain) & within(space.motion_limits, joints_rad)
    # Last, and only of what is left: bodies against volumes cost more than points.
    room[room] = are_outside_keep_outs(space, joints_rad[room])
    return room
