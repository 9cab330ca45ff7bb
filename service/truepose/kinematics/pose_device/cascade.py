"""Direct kinematics of the pose device in closed form, and its derivative by all twelve lengths.

How six legs can join three base cups and three tool nests so that the pose has a closed form. One cup carries
two legs, one three, one a single leg: the pattern triple-double-single, in which leg ij joins base cup i and
tool nest j: 11, 12, 21, 22, 23, 31. Every permutation of cups and of nests is a design of its own. The other
pattern of six legs between two triangles (each cup to two nests) has no such cascade and is ill conditioned
when all legs are equal.

Three trilaterations in cascade, in the pattern's own numbering:

    t1 = Tri(b1, b2, b3; r11, r21, r31)
    t2 = Tri(b1, b2, t1; r12, r22, t12)
    t3 = Tri(b2, t2, t1; r23, t23, t31)

Each has two solutions, eight together. The four with t1 below the base are dropped. A design that permutes
the cups by an odd permutation is the mirror image of the pattern, so all three sides change with it: solution
1 of every design is then the same shape.

References
----------
A. Nubiola, PhD thesis, ETS Montreal, 2014, sections 3.2 and 3.3, equations (3.12) to (3.16).
"""

from collections.abc import Collection
from dataclasses import dataclass
from itertools import combinations, permutations

import numpy as np
import numpy.typing as npt

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import Leg
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.kinematics.trilateration import tri, tri_gradient

PATTERN: tuple[Leg, ...] = ((1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (2, 3))  # in the order of the cascade

_TOOL = (1, 2, 3)


@dataclass(frozen=True, slots=True)
class Design:
    """Which cups and nests play the parts 1, 2, 3 of the pattern.

    Attributes
    ----------
    base, tool : tuple of int
        Numbers from 1, by the part that they play.
    """

    base: tuple[int, int, int]
    tool: tuple[int, int, int]

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The six legs, in the order of the cascade: three to the first nest, two to the second, one."""
        return tuple((self.base[i - 1], self.tool[j - 1]) for i, j in PATTERN)

    @property
    def name(self) -> str:
        """The thesis' name: each base cup in ascending order, followed by its nests, e.g. 1_12 2_123 3_1."""
        nests = {cup: sorted(j for i, j in self.legs if i == cup) for cup in sorted(self.base)}
        return " ".join(f"{cup}_" + "".join(map(str, joined)) for cup, joined in nests.items())


def designs(base_points: int = 3) -> tuple[Design, ...]:
    """Return all designs on any three of the base cups: 36 for three cups, 144 for four.

    Parameters
    ----------
    base_points : int
        Number of cups.

    Raises
    ------
    ConfigurationError
        There are fewer than three cups.
    """
    if base_points < 3:
        raise ConfigurationError(f"The base fixture has {base_points} cups; at least three are needed.")
    return tuple(
        Design((b1, b2, b3), (t1, t2, t3))
        for chosen in combinations(range(1, base_points + 1), 3)
        for b1, b2, b3 in permutations(chosen)
        for t1, t2, t3 in permutations(_TOOL)
    )


DESIGNS = designs()


# Sides of t2 and t3 in the four solutions, numbered as in table 3.1.
_SIDES = ((1.0, -1.0), (1.0, 1.0), (-1.0, -1.0), (-1.0, 1.0))
# A cup less than a tenth of a side out of the plane of the others is in no nest's way.
_FLAT = 0.1
# The lengths that a tool triangle has between nests 1-2, 2-3, 3-1, looked up by the two nests' numbers.
_TOOL_SIDE = {frozenset((1, 2)): 0, frozenset((2, 3)): 1, frozenset((1, 3)): 2}


def base_triangle(b12_mm: float, b23_mm: float, b31_mm: float) -> FloatArray:
    """Return cups 1, 2, 3 from their distances: cup 1 the origin, cup 2 on x, cup 3 in the xy plane, y > 0.

    x_3 = (b12^2 + b31^2 - b23^2) / (2 b12), y_3 = sqrt(b31^2 - x_3^2): thesis section 3.2, the base frame.

    Parameters
    ----------
    b12_mm, b23_mm, b31_mm : float
        Complex ones too, for derivatives by complex steps.

    Returns
    -------
    ndarray, shape (3, 3)
        One cup in each row [mm].

    Raises
    ------
    ConfigurationError
        No triangle has these sides.
    """
    x = (b12_mm**2 + b31_mm**2 - b23_mm**2) / (2.0 * b12_mm) if b12_mm else np.nan
    square = b31_mm**2 - x**2
    if not np.real(square) > 0.0:
        raise ConfigurationError(
            f"No triangle has sides of {b12_mm:g}, {b23_mm:g} and {b31_mm:g} mm. Measure the sides again."
        )
    return np.array([[0.0, 0.0, 0.0], [b12_mm, 0.0, 0.0], [x, np.sqrt(square), 0.0]])


def fourth_cup(cups_mm: FloatArray, b14_mm: float, b24_mm: float, b34_mm: float) -> FloatArray:
    """Return the cup at these distances from the first three, below their plane.

    Below, because the place above at 300 mm from all three is where the first tool nest comes.

    Parameters
    ----------
    cups_mm : ndarray, shape (3, 3)
    b14_mm, b24_mm, b34_mm : float

    Returns
    -------
    ndarray, shape (3,)
        [mm]

    Raises
    ------
    ConfigurationError
        The three distances do not meet.
    """
    cup = tri(cups_mm[0], cups_mm[1], cups_mm[2], b14_mm, b24_mm, b34_mm, -1.0)
    if not np.isfinite(cup).all():
        raise ConfigurationError(
            f"No cup can be {b14_mm:g}, {b24_mm:g} and {b34_mm:g} mm from cups 1, 2 and 3. Measure these "
            "distances again."
        )
    return cup


def outward(cups_mm: FloatArray, used: Collection[int]) -> FloatArray:
    """Return the normal of three cups that points to the side on which the tool is.

    With three cups, or all of them about in a plane, it is up: the side of (B2 - B1) x (B3 - B1). Otherwise
    it is the side away from the cup that is not used, which is where a tool nest would come on the other.

    Parameters
    ----------
    cups_mm : ndarray, shape (K, 3)
        All cups of the base fixture.
    used : collection of int
        Numbers of the three cups, from 1.

    Returns
    -------
    ndarray, shape (3,)
        Not normalised: (v2 - v1) x (v3 - v1) or its opposite [mm2].

    Raises
    ------
    ConfigurationError
        The cups are on a line.
    """
    v1, v2, v3 = (cups_mm[cup - 1] for cup in sorted(used))
    up = np.cross(cups_mm[1] - cups_mm[0], cups_mm[2] - cups_mm[0])
    # In ascending order of their numbers, whatever part they play in a design: the side must not depend on
    # it.
    normal = np.cross(v2 - v1, v3 - v1)
    idle = [cup for number, cup in enumerate(cups_mm, start=1) if number not in used]
    away = v1 - np.mean(idle, axis=0) if idle else np.zeros(3)
    size = float(np.abs(normal @ normal)) ** 0.5  # an area: its root is a side
    if size and abs(normal @ away) < _FLAT * size**1.5:
        # Four cups of a flat plate are never flat to the last digit: which side the idle one is on would be
        # chance.
        away = up
    # The real part, because complex steps run through here to test the derivatives.
    side = np.sign(np.real(normal @ away))
    if not size or side == 0.0:
        raise ConfigurationError("The cups of the base fixture lie on a line; they must form a triangle.")
    return np.asarray(side * normal)


def solve(
    design: Design, cups_mm: FloatArray, tool_sides_mm: FloatArray, length_mm: FloatArray
) -> FloatArray:
    """Return the four places of the tool nests that have these leg lengths.

    Parameters
    ----------
    design : Design
    cups_mm : ndarray, shape (K, 3)
        All cups of the base fixture, in any frame.
    tool_sides_mm : ndarray, shape (3,)
        Distances of nests 1-2, 2-3 and 3-1.
    length_mm : ndarray, shape (..., 6)
        Legs in the order of `design.legs`.

    Returns
    -------
    ndarray, shape (..., 4, 3, 3)
        For each solution nests T1, T2, T3 in rows, in the frame of the cups; NaN where there is none.

    Raises
    ------
    ConfigurationError
        A cup or a length is missing, or the three cups are on a line.
    """
    lengths = np.asarray(length_mm)
    if lengths.shape[-1:] != (6,):
        raise ConfigurationError(
            f"A design needs six leg lengths; an array of shape {lengths.shape} was given."
        )
    if max(design.base) > len(cups_mm):
        raise ConfigurationError(
            f"The design uses cup {max(design.base)}, but only {len(cups_mm)} cups were given."
        )
    # In the pattern's own order: every design is solved as the pattern is.
    b1, b2, b3 = (cups_mm[cup - 1] for cup in design.base)
    # The normal of the pattern's own numbering turns round where the cups are permuted oddly.
    side = float(np.sign(np.real(np.cross(b2 - b1, b3 - b1) @ outward(cups_mm, design.base))))
    t12, t23, t31 = (tool_sides_mm[k] for k in _pattern_sides(design))
    side2, side3 = side * np.array(_SIDES).T
    # Many measurements and their four solutions in one go.
    r11, r21, r31, r12, r22, r23 = np.moveaxis(lengths[..., None, :], -1, 0)  # each (..., 1): the solutions
    t1 = tri(b1, b2, b3, r11, r21, r31, side)
    t2 = tri(b1, b2, t1, r12, r22, t12, side2)
    t3 = tri(b2, t2, t1, r23, t23, t31, side3)
    points = np.empty((*t3.shape[:-1], 3, 3), dtype=t3.dtype)
    for place, point in zip(design.tool, (t1, t2, t3), strict=True):
        points[..., place - 1, :] = point
    return points


def _pattern_sides(design: Design) -> tuple[int, int, int]:
    """Return which tool sides are t12, t23 and t31 of the pattern."""
    first, second, third = design.tool
    pairs = ((first, second), (second, third), (third, first))
    one, two, three = (_TOOL_SIDE[frozenset(pair)] for pair in pairs)
    return one, two, three


def solution_gradient(design: Design, cups_mm: FloatArray, points_mm: FloatArray) -> FloatArray:
    """How the tool nests of solutions move with the twelve lengths.

    Parameters
    ----------
    design : Design
    cups_mm : ndarray, shape (3, 3)
        As from `base_triangle`: the frame moves with the lengths that define it.
    points_mm : ndarray, shape (..., 3, 3)
        Solutions as from `solve`.

    Returns
    -------
    ndarray, shape (..., 9, 12)
        Rows: x, y, z of T1, T2, T3. Columns: b12, b23, b31, t12, t23, t31, then the legs in the order of
        `design.legs`.

    Raises
    ------
    UnderdeterminedError
        A nest lies in the plane of the three points that hold it.
    """
    cups = np.array([cups_mm[cup - 1] for cup in design.base])
    moved = _base_gradient(cups_mm)
    moved = np.array([moved[cup - 1] for cup in design.base])
    t1, t2, t3 = (points_mm[..., nest - 1, :] for nest in design.tool)
    identity = np.eye(12)
    t12, t23, t31 = (3 + k for k in _pattern_sides(design))
    try:
        g1 = _gradient(t1, [*cups], [*moved], identity[[6, 7, 8]])
        g2 = _gradient(t2, [cups[0], cups[1], t1], [moved[0], moved[1], g1], identity[[9, 10, t12]])
        g3 = _gradient(t3, [cups[1], t2, t1], [moved[1], g2, g1], identity[[11, t23, t31]])
    except np.linalg.LinAlgError as error:
        raise UnderdeterminedError(
            "A tool nest is in the plane of the three points that locate it, so its height cannot be "
            "determined."
        ) from error
    gradient = np.empty((*points_mm.shape[:-2], 3, 3, 12))
    for nest, own in zip(design.tool, (g1, g2, g3), strict=True):
        gradient[..., nest - 1, :, :] = own
    return gradient.reshape(*points_mm.shape[:-2], 9, 12)


def _gradient(
    point: FloatArray, centres: list[FloatArray], moved: list[FloatArray], lengths: FloatArray
) -> FloatArray:
    """Return the motion of a nest per each of the twelve lengths, shape (..., 3, 12): `tri_gradient`."""
    lead = point.shape[:-1]
    around = np.stack([np.broadcast_to(centre, point.shape) for centre in centres], axis=-2)
    own = np.stack([np.broadcast_to(motion, (*lead, 3, 12)) for motion in moved], axis=-3)
    return tri_gradient(point, around, own, np.broadcast_to(lengths, (*lead, 3, 12)))


def _base_gradient(cups_mm: FloatArray) -> FloatArray:
    """Return the motion of cups 1, 2, 3 per length of the twelve, shape (3, 3, 12).

    Cup 2 moves by db12 along x. Cup 3 follows from c3 . dc3 = b31 db31 and (c3 - c2) . (dc3 - dc2) = b23
    db23.
    """
    gradient = np.zeros((3, 3, 12))
    gradient[1, 0, 0] = 1.0
    (x2, _, _), (x3, y3, _) = cups_mm[1], cups_mm[2]
    from_first, from_second = np.array([x3, y3]), np.array([x3 - x2, y3])
    changes = np.zeros((2, 12))
    changes[0, 2] = np.hypot(*from_first)
    changes[1, 1] = np.hypot(*from_second)
    changes[1, 0] = from_second[0]  # cup 2 runs along x with b12
    gradient[2, :2] = np.linalg.solve(np.stack([from_first, from_second]), changes)
    return gradient


def points_covariance(
    design: Design, cups_mm: FloatArray, points_mm: FloatArray, covariance_mm2: npt.ArrayLike
) -> FloatArray:
    """Return the covariance of the nests of solutions from that of the twelve lengths: G C G^T.

    Parameters
    ----------
    design : Design
    cups_mm : ndarray, shape (3, 3)
        As for `solution_gradient`.
    points_mm : ndarray, shape (..., 3, 3)
        As for `solution_gradient`.
    covariance_mm2 : array_like, shape (12, 12)
        In the order of the columns of `solution_gradient`.

    Returns
    -------
    ndarray, shape (..., 9, 9)
        [mm2], nest by nest. Of T3 it is larger than the thesis prints in table 3.1, which takes T1 and T2 for
        uncorrelated: 3.36, 3.05, 2.89, 3.33 against 3.18, 3.05, 2.85, 3.18 (tests of the cascade).
    """
    gradient = solution_gradient(design, cups_mm, points_mm)
    # All twelve lengths at once: T3 hangs on T1 and T2, whose errors share the same sides and legs.
    propagated: FloatArray = gradient @ np.asarray(covariance_mm2) @ np.swapaxes(gradient, -1, -2)
    return propagated


def sides(points_mm: FloatArray) -> FloatArray:
    """Return the distances 1-2, 2-3 and 3-1 of three points.

    Parameters
    ----------
    points_mm : ndarray, shape (..., 3, 3)
        One point in each row.

    Returns
    -------
    ndarray, shape (..., 3)
        [mm]
    """
    apart = points_mm - np.roll(points_mm, -1, axis=-2)
    return np.asarray(np.sqrt((apart**2).sum(axis=-1)))
