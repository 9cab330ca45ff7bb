r"""Base and tool from the data alone, without a starting guess.

With the nominal chain (R_n, o_n) in the base frame, base (R, t) and nest x_k, a reading is
p_n = R (o_n + R_n x_k) + t. With Q = R^T and u = -Q t this is linear in u and x_k for a given Q:

    Q p_n - o_n = R_n x_k - u

so that eliminating u and x_k leaves a quadratic form in the nine elements of Q, to be minimised
over rotations. The form is built once for given weights; starts all over SO(3) then cost nothing
(variable projection: G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10(2), 1973, 413-432). It is of the fourth
degree in a quaternion, so that its valleys are wide: of evenly spread starts the lowest lie in the deepest.
Gross readings are weighed down by iterating with Cauchy weights on a median scale.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.kinematics.chain import Chain
from truepose.kinematics.frames import rotation_from_vector

_STARTS = 200
_FEW_STARTS = 24
_LOWEST = 24  # starts from which a descent is worth its time
_DESCENT_STEPS = 30
_ARRIVED_RAD = 1e-9  # a step this short: at ten metres, a hundredth of a micrometre
_ROBUST_ROUNDS = 25
_SETTLED = 1e-3  # change of a weight that no longer moves anything
_DEPENDENT = 1e-12  # of the largest eigenvalue: a sum of squares below it is rounding


@dataclass(frozen=True, slots=True)
class Placement:
    """Base and nests that place the nominal robot best, and what is left.

    Attributes
    ----------
    rotation : ndarray, shape (3, 3)
        Of the base in the world.
    origin_mm : ndarray, shape (3,)
        Of the base in the world.
    nests_mm : ndarray, shape (K, 3)
        Flange frame.
    residual_mm : ndarray, shape (n, 3)
        Observation minus prediction, world frame.
    weights : ndarray, shape (n,)
        Final robust weights, 0 to 1.
    """

    rotation: FloatArray
    origin_mm: FloatArray
    nests_mm: FloatArray
    residual_mm: FloatArray
    weights: FloatArray

    @property
    def typical_mm(self) -> float:
        """Median length of the residuals, which gross readings do not move."""
        return float(np.median(np.linalg.norm(self.residual_mm, axis=1)))


@dataclass(frozen=True, slots=True)
class PriorPlacement:
    """What is known of base and nests beforehand.

    Attributes
    ----------
    base : tuple of ndarray, shapes (3, 3) and (3,), or None
        Rotation, and origin [mm] in the world; None: to be found.
    nests_mm : ndarray, shape (K, 3)
        Flange frame; rows of unknown nests are ignored.
    nest_unknown : ndarray of bool, shape (K,)
    """

    base: tuple[FloatArray, FloatArray] | None
    nests_mm: FloatArray
    nest_unknown: BoolArray


def place(chain: Chain, nest: IntArray, measured_mm: FloatArray, known: PriorPlacement) -> Placement:
    """Find what is unknown of base and nests for the nominal robot.

    Parameters
    ----------
    chain : Chain
        Nominal chain at n configurations in the base frame (base at the identity).
    nest : ndarray of int, shape (n,)
        1-based.
    measured_mm : ndarray, shape (n, 3)
        World frame.
    known : PriorPlacement
        A base that is known is held.

    Returns
    -------
    Placement
        What no reading tells, such as a nest that was never measured, is 0.
    """
    form = _Form(chain.rotation[-1], chain.origin[-1], nest, measured_mm, known)
    weights = np.ones(len(nest))
    rotation = known.base[0] if known.base is not None else _best_rotation(form.reduced(weights))
    rotation, weights = _robust_rounds(form, rotation, weights, searched=known.base is None)
    reduced = form.reduced(weights)
    if known.base is None:
        # a wrong first answer would keep its own followers: try all starts again with the weights on
        # Judged by medians of all readings, not by the sums of those that each has kept.
        candidates = (_descended(rotation[None], reduced)[0], _best_rotation(reduced))
        rotation = min(candidates, key=lambda candidate: _typical_mm(form, candidate, reduced))
    return form.placement(rotation, reduced, weights)


def _robust_rounds(
    form: "_Form", rotation: FloatArray, weights: FloatArray, *, searched: bool
) -> tuple[FloatArray, FloatArray]:
    """Weigh far readings down and take a step, by turns, until the weights stay."""
    for _ in range(_ROBUST_ROUNDS):
        lengths = np.linalg.norm(form.residual(rotation, form.reduced(weights)), axis=0)
        # Readings without any error would leave a scale of 0 to divide by.
        scale = max(1.4826 * float(np.median(lengths)), 1e-9)
        before, weights = weights, 1.0 / (1.0 + (lengths / (2.0 * scale)) ** 2)
        if searched:
            rotation = _descended(rotation[None], form.reduced(weights), steps=1)[0]
        if float(np.abs(weights - before).max(initial=0.0)) < _SETTLED:
            break
    return rotation, weights


def quick_typical_mm(chain: Chain, nest: IntArray, measured_mm: FloatArray, known: PriorPlacement) -> float:
    """Return the median residual of the least-squares placement, without robust weights.

    So hypotheses are compared, of which there are hundreds.

    Parameters
    ----------
    chain : Chain
        Nominal chain at n configurations in the base frame (base at the identity).
    nest : ndarray of int, shape (n,)
        1-based.
    measured_mm : ndarray, shape (n, 3)
        World frame.
    known : PriorPlacement

    Returns
    -------
    float
        Median length of the residuals [mm].
    """
    form = _Form(chain.rotation[-1], chain.origin[-1], nest, measured_mm, known)
    reduced = form.reduced(np.ones(len(nest)))
    rotation = known.base[0] if known.base is not None else _best_rotation(reduced, _FEW_STARTS)
    return _typical_mm(form, rotation, reduced)


def _typical_mm(form: "_Form", rotation: FloatArray, reduced: "_Reduced") -> float:
    return float(np.median(np.linalg.norm(form.residual(rotation, reduced), axis=0)))


def _best_rotation(reduced: "_Reduced", starts: int = _STARTS) -> FloatArray:
    spread = _rotation_starts(starts)
    # All costs come at once from the form; descents, a batch too, are for the lowest.
    lowest = np.argsort(reduced.cost(spread), kind="stable")[:_LOWEST]
    ends = _descended(spread[lowest], reduced)
    return np.asarray(ends[int(np.argmin(reduced.cost(ends)))])


@cache
def _rotation_starts(count: int) -> FloatArray:
    """Rotations spread evenly over SO(3), shape (S, 3, 3).

    Super-Fibonacci spiral (M. Alexa, Proc. CVPR 2022, 8291-8300).
    """
    phi, psi = np.sqrt(2.0), 1.533751168755204288118041
    s = np.arange(count) + 0.5
    small, large = np.sqrt(s / count), np.sqrt(1.0 - s / count)
    alpha, beta = 2 * np.pi * s / phi, 2 * np.pi * s / psi
    quaternion = np.stack(
        [large * np.cos(beta), small * np.sin(alpha), small * np.cos(alpha), large * np.sin(beta)], -1
    )
    w, vector = quaternion[:, :1], quaternion[:, 1:]
    angle = 2.0 * np.arctan2(np.linalg.norm(vector, axis=1, keepdims=True), w)
    axis = vector / np.linalg.norm(vector, axis=1, keepdims=True)
    return rotation_from_vector(axis * angle)


def _generators() -> FloatArray:
    generators = np.zeros((3, 3, 3))
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        generators[axis, second, first], generators[axis, first, second] = 1.0, -1.0
    return generators


_GENERATORS = _generators()


@dataclass(frozen=True, slots=True)
class _Reduced:
    """The weighted sum of squares once nests and base shift are eliminated: q.N q - 2 q.b and a constant."""

    normal: FloatArray  # (9, 9) in the elements of Q, row-major
    right: FloatArray  # (9,)
    per_q: FloatArray  # (c, 9): the eliminated unknowns are per_q q - at_zero
    at_zero: FloatArray  # (c,)

    def cost(self, rotations: FloatArray) -> FloatArray:
        """Sum of squares of each base rotation, less the constant, shape (S,)."""
        q = np.swapaxes(rotations, 1, 2).reshape(-1, 9)
        return np.asarray(((q @ self.normal - 2.0 * self.right) * q).sum(axis=1))

    def unknowns(self, rotation: FloatArray) -> FloatArray:
        """Return free nests and base shift that belong to a base rotation, shape (c,)."""
        return np.asarray(self.per_q @ rotation.T.reshape(9) - self.at_zero)


def _descended(rotations: FloatArray, reduced: _Reduced, steps: int = _DESCENT_STEPS) -> FloatArray:
    """Gauss-Newton on SO(3) from many base rotations (S, 3, 3) at once."""
    q = np.swapaxes(rotations, 1, 2).copy()
    under_way = np.arange(len(q))
    for _ in range(steps):
        step = _step(q[under_way], reduced)
        # Steps are turns from the left, so that Q stays a rotation whatever their length.
        q[under_way] = rotation_from_vector(step) @ q[under_way]
        # Those that have arrived take no further step: the batch grows smaller.
        under_way = under_way[np.abs(step).max(axis=1) > _ARRIVED_RAD]
        if not len(under_way):
            break
    return np.swapaxes(q, 1, 2)


def _step(q: FloatArray, reduced: _Reduced) -> FloatArray:
    """Rotation vectors that lead down from Q, shape (S, 3); none is longer than 0.7 rad."""
    flat = q.reshape(-1, 9)
    tangent = (_GENERATORS @ q[:, None]).reshape(len(q), 3, 9)
    gradient = tangent @ (flat @ reduced.normal - reduced.right)[:, :, None]
    hessian = tangent @ reduced.normal @ np.swapaxes(tangent, 1, 2)
    slope = np.trace(hessian, axis1=1, axis2=2)[:, None, None]
    # Motions of one joint alone leave a turn about its axis open: the step must be finite all the same.
    hessian += (1e-9 * slope + np.finfo(float).tiny) * np.eye(3)  # also where no rotation matters
    step = -np.linalg.solve(hessian, gradient)[:, :, 0]
    length = np.sqrt((step**2).sum(axis=1, keepdims=True))
    return np.asarray(step * np.minimum(1.0, 0.7 / np.maximum(length, 1e-12)))


class _Form:
    """The readings as rows that are linear in free nests, base shift and Q: residual = (y, q, 1) . rows."""

    def __init__(
        self,
        rotation: FloatArray,
        origin: FloatArray,
        nest: IntArray,
        measured: FloatArray,
        known: PriorPlacement,
    ) -> None:
        self._known, self._held = known, np.repeat(~known.nest_unknown, 3)
        self._nests = np.where(known.nest_unknown[:, None], 0.0, known.nests_mm)
        # Counted from the middle of the readings: an origin of the world that is far away costs no digits.
        self._about = measured.mean(axis=0) if known.base is None else known.base[1]
        target = origin + np.einsum("nij,nj->ni", rotation, self._nests[nest - 1])
        rows = [-np.where(nest == k + 1, rotation.T, 0.0) for k in np.flatnonzero(known.nest_unknown)]
        if known.base is None:
            rows.append(np.broadcast_to(np.eye(3)[:, :, None], (3, 3, len(nest))))
        self._eliminated = 3 * len(rows)
        of_q = np.zeros((3, 3, 3, len(nest)))  # Q p per row and column of Q
        for i in range(3):
            of_q[i, :, i] = (measured - self._about).T
        self._rows = np.concatenate([*rows, of_q.reshape(9, 3, -1), -target.T[None]])  # (c + 10, 3, n)

    def reduced(self, weights: FloatArray) -> _Reduced:
        """Return what is left of the sum of squares for given weights (n,)."""
        rows, c = self._rows.reshape(len(self._rows), -1), self._eliminated
        sums = (self._rows * weights).reshape(rows.shape) @ rows.T
        # What readings tell only together is shared out with the least length; what none tells is 0.
        solved = -np.linalg.pinv(sums[:c, :c], rcond=_DEPENDENT, hermitian=True) @ sums[:c, c:]
        left = sums[c:, c:] + sums[c:, :c] @ solved
        return _Reduced(left[:9, :9], -left[:9, 9], solved[:, :9], -solved[:, 9])

    def residual(self, rotation: FloatArray, reduced: _Reduced) -> FloatArray:
        """Residuals in the base frame [mm], unweighted, shape (3, n)."""
        every = np.concatenate([reduced.unknowns(rotation), rotation.T.reshape(9), [1.0]])
        return np.asarray(np.tensordot(every, self._rows, 1))

    def placement(self, rotation: FloatArray, reduced: _Reduced, weights: FloatArray) -> Placement:
        """Return the placement that belongs to a base rotation."""
        unknowns = reduced.unknowns(rotation)
        nests = self._nests.reshape(-1).copy()
        nests[~self._held] = unknowns[: int((~self._held).sum())]
        origin = self._about if self._known.base is not None else self._about - rotation @ unknowns[-3:]
        # From the base frame, in which the form counts, to the world.
        left = self.residual(rotation, reduced).T @ rotation.T
        return Placement(rotation, origin, nests.reshape(-1, 3), left, weights)
