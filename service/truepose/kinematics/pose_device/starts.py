"""Poses from which the least squares may start: every solution of the smallest sets of legs.

Three ways to solve six legs, tried in this order:

1. one nest hangs on three cups, another on two, the third on one: three trilaterations in cascade;
2. the same with cups and nests exchanged, seen from the tool;
3. each nest hangs on two cups: the first one runs round a circle, the other two follow by trilateration, and
   where their distance is right the pose is.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations, permutations, product

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import Leg
from truepose.kinematics.frames import rigid_alignment
from truepose.kinematics.poses import Pose, pose_of
from truepose.kinematics.trilateration import tri

# A start only has to lead to its minimum; two that lead to the same one are told apart after the fit.
_APART_MM = 1.0  # poses closer than this lead to the same minimum; noise alone separates them by less
_MOST = 64  # eight for each way the legs can be read is the rule; far more means noise, not geometry
_WORSE_MM = 20.0  # a ballbar's range of 1 mm either way, magnified ten times by the weakest geometry in use
_AROUND = 1440  # steps of the circle: a quarter of a degree, 1 mm at the end of a leg of 300 mm
_SIDES = np.array(list(product((1.0, -1.0), repeat=3)))  # (8, 3)


def starting_poses(
    cups_mm: FloatArray, nests_mm: FloatArray, legs: Sequence[Leg], length_mm: FloatArray
) -> tuple[Pose, ...]:
    """Return poses near which a fit to all legs may be; empty where the legs meet nowhere.

    Parameters
    ----------
    cups_mm : ndarray, shape (K, 3)
    nests_mm : ndarray, shape (3, 3)
        In the flange frame.
    legs : sequence of (cup, nest), n >= 6
        Numbers from 1; one may stand there more than once.
    length_mm : ndarray, shape (n,)

    Returns
    -------
    tuple of Pose
        At most 64, of least misfit of the worst leg first; those seen from the tool in the order of the
        search.
    """
    mean = _mean_lengths(legs, length_mm)
    ways = _cascades(mean)
    # Once one of the three ways solves six of the legs it has all of their solutions: the others would only
    # repeat them. The circle comes last, since it needs a search where the other two have a closed form.
    if len(ways):
        points = _solved(ways, cups_mm, nests_mm, mean)
        return tuple(pose_of(nests_mm, one) for one in _best(points, cups_mm, mean))
    exchanged = {(nest, cup): length for (cup, nest), length in mean.items()}
    ways = _cascades(exchanged)
    if len(ways):
        return _seen_from_the_tool(ways, cups_mm, nests_mm, exchanged)
    circling = _best(_round_the_circle(cups_mm, nests_mm, mean), cups_mm, mean)
    return tuple(pose_of(nests_mm, one) for one in circling)


def _mean_lengths(legs: Sequence[Leg], length_mm: FloatArray) -> dict[Leg, float]:
    """Return one length for each leg, numbers from 0 on; of a leg that was read twice, the mean."""
    taken: dict[Leg, list[float]] = {}
    for (cup, nest), length in zip(legs, length_mm, strict=True):
        taken.setdefault((cup - 1, nest - 1), []).append(float(length))
    return {leg: float(np.mean(lengths)) for leg, lengths in taken.items()}


def _cascades(lengths: Mapping[Leg, float]) -> IntArray:
    """Return all cascades, shape (m, 9): three moving points, then the 3, 2, 1 fixed ones they hang on."""
    held: dict[int, list[int]] = {}
    for fixed, moving in lengths:
        held.setdefault(moving, []).append(fixed)
    rows = [
        (*order, *three, *two, one)
        for order in permutations(sorted(held), 3)
        for three in combinations(held[order[0]], 3)
        for two in combinations(held[order[1]], 2)
        for one in held[order[2]]
    ]
    return np.array(rows, dtype=np.int64).reshape(len(rows), 9)


def _solved(
    ways: IntArray, fixed_mm: FloatArray, moving_mm: FloatArray, lengths: Mapping[Leg, float]
) -> FloatArray:
    """Return the moving points of all cascades and sides, NaN where legs do not meet.

    Parameters
    ----------
    ways : ndarray of int, shape (m, 9)
        As of `_cascades`.
    fixed_mm, moving_mm : ndarray, shape (points, 3)
        The latter in a frame of their own: only their distances are used.
    lengths : mapping of (fixed, moving) to float
        [mm]

    Returns
    -------
    ndarray, shape (8 m, points, 3)
        By number; only three are ever moved, the rest is NaN.
    """
    table = np.full((len(fixed_mm), len(moving_mm)), np.nan)
    for leg, length in lengths.items():
        table[leg] = length
    a, b, c, i, j, k, p, q, r = (column[:, None] for column in ways.T)
    side1, side2, side3 = (np.broadcast_to(side, (len(ways), 8)) for side in _SIDES.T)

    def between(first: IntArray, second: IntArray) -> FloatArray:
        return np.asarray(np.linalg.norm(moving_mm[first] - moving_mm[second], axis=-1))

    t1 = tri(fixed_mm[i], fixed_mm[j], fixed_mm[k], table[i, a], table[j, a], table[k, a], side1)
    t2 = tri(fixed_mm[p], fixed_mm[q], t1, table[p, b], table[q, b], between(a, b), side2)
    t3 = tri(fixed_mm[r], t2, t1, table[r, c], between(b, c), between(c, a), side3)
    points = np.full((len(ways), 8, len(moving_mm), 3), np.nan)
    row = np.arange(len(ways))
    for number, point in ((a, t1), (b, t2), (c, t3)):
        points[row, :, number[:, 0]] = point
    return points.reshape(-1, len(moving_mm), 3)


def _best(points_mm: FloatArray, cups_mm: FloatArray, lengths: Mapping[Leg, float]) -> list[FloatArray]:
    """Return nests that differ, those first that fit all legs best."""
    points = points_mm[np.isfinite(points_mm).all(axis=(1, 2))]
    cup, nest = np.array(list(lengths)).T
    predicted = np.linalg.norm(points[:, nest] - cups_mm[cup], axis=-1)
    misfit = np.abs(predicted - np.array(list(lengths.values()))).max(axis=1)
    order = np.argsort(misfit, kind="stable")
    # Cascades of more than six legs solve the same pose many times over: once is enough to start from.
    kept: list[FloatArray] = []
    # By the worst leg: of more than six a cascade leaves some out, and these tell its solutions apart.
    for one in points[order[misfit[order] < misfit.min(initial=np.inf) + _WORSE_MM]]:
        if all(np.abs(one - other).max() > _APART_MM for other in kept):
            kept.append(one)
        if len(kept) == _MOST:
            break
    return kept


def _seen_from_the_tool(
    ways: IntArray, cups_mm: FloatArray, nests_mm: FloatArray, lengths: Mapping[Leg, float]
) -> tuple[Pose, ...]:
    """Return poses from cascades in which the cups hang on the nests, moved back by rigid alignment."""
    # Each way moves three cups of its own; with six legs there are few.
    found: list[Pose] = []
    for way in ways:
        used = way[:3]
        for points in _solved(way[None], nests_mm, cups_mm, lengths):
            if np.isfinite(points[used]).all():
                found.append(Pose(*rigid_alignment(points[used], cups_mm[used])))
    return tuple(found)


def _round_the_circle(cups_mm: FloatArray, nests_mm: FloatArray, lengths: Mapping[Leg, float]) -> FloatArray:
    """Return places of the nests (m, 3, 3) that nearly fit six legs, two at each nest.

    The first nest runs round the circle of its two legs; the other two follow from theirs and from the sides
    of the tool, and where the third side comes out right within a step of the circle there is a solution.
    """
    held = [[cup for cup, own in lengths if own == nest] for nest in range(3)]
    if any(len(cups) != 2 for cups in held):
        return np.empty((0, 3, 3))
    legs = [[lengths[cup, nest] for cup in held[nest]] for nest in range(3)]
    t12, t23, t31 = np.linalg.norm(nests_mm - np.roll(nests_mm, -1, axis=0), axis=1)
    first = _circle(cups_mm[held[0]], *legs[0])
    found = []
    for side2, side3 in product((1.0, -1.0), repeat=2):
        second = tri(cups_mm[held[1][0]], cups_mm[held[1][1]], first, legs[1][0], legs[1][1], t12, side2)
        third = tri(cups_mm[held[2][0]], cups_mm[held[2][1]], first, legs[2][0], legs[2][1], t31, side3)
        gap = np.abs(np.linalg.norm(second - third, axis=1) - t23)
        gap[np.isnan(gap)] = np.inf
        # Local minima, and not changes of sign: a solution in which the circle only touches has none of
        # these.
        least = np.isfinite(gap) & (gap <= np.roll(gap, 1)) & (gap <= np.roll(gap, -1))
        found.append(np.stack([first, second, third], axis=1)[least])
    return np.concatenate(found)


def _circle(centres_mm: FloatArray, l1: float, l2: float) -> FloatArray:
    """Return points at distances l1, l2 from two centres, shape (_AROUND, 3); NaN where there are none."""
    axis = centres_mm[1] - centres_mm[0]
    apart = float(np.linalg.norm(axis))
    along = 0.5 * (l1**2 - l2**2 + apart**2) / apart
    # Two directions across the line of the centres, whichever: the whole circle is run through.
    _, _, across = np.linalg.svd(axis[None])
    angle = np.linspace(0.0, 2.0 * np.pi, _AROUND, endpoint=False)[:, None]
    with np.errstate(invalid="ignore"):  # NaN: the two legs are too short to meet
        radius = np.sqrt(l1**2 - along**2)
    around: FloatArray = np.cos(angle) * across[1] + np.sin(angle) * across[2]
    return np.asarray(centres_mm[0] + along * axis / apart + radius * around)
