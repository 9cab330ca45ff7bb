r"""Base and tool from the data alone, without a starting guess.

With the nominal chain (R_n, o_n) in the base frame, base (R, t) and nest x_k, a reading is
p_n = R (o_n + R_n x_k) + t. With Q = R^T and u = -Q t this is linear in u and x_k for a given Q:

    Q p_n - o_n = R_n x_k - u

so that eliminating u and x_k leaves a quadratic form in the nine elements of Q, to be minimised
over rotations. The form is built once; hundreds of starts on SO(3) then cost nothing
(variable projection: G. Golub, V. Pereyra, SIAM J. Numer. Anal. 10(2), 1973, 413-432).
Gross readings are weighed down by iterating with Cauchy weights on a median scale.
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.kinematics.chain import Chain
from truepose.kinematics.frames import rotation_from_vector

_STARTS = 200
_FEW_STARTS = 24
_DESCENT_STEPS = 30
_ROBUST_ROUNDS = 25


@dataclass(frozen=True, slots=True)
class Placement:
    """Base and nests that place the nominal robot best, and what is left."""

    rotation: FloatArray  # (3, 3) of the base
    origin_mm: FloatArray  # (3,)
    nests_mm: FloatArray  # (K, 3)
    residual_mm: FloatArray  # (n, 3) observation minus prediction, world frame
    weights: FloatArray  # (n,) final robust weights

    @property
    def typical_mm(self) -> float:
        """Median length of the residuals, which gross readings do not move."""
        return float(np.median(np.linalg.norm(self.residual_mm, axis=1)))


@dataclass(frozen=True, slots=True)
class Known:
    """What is known of base and nests beforehand."""

    base: tuple[FloatArray, FloatArray] | None  # rotation (3, 3), origin (3,) [mm]
    nests_mm: FloatArray  # (K, 3); rows of unknown nests are ignored
    nest_unknown: BoolArray  # (K,)


def place(chain: Chain, nest: IntArray, measured_mm: FloatArray, known: Known) -> Placement:
    """Find what is unknown of base and nests for the nominal robot.

    Parameters
    ----------
    chain : Chain
        Nominal chain at n configurations in the base frame (base at the identity).
    nest : ndarray, shape (n,)
        1-based.
    measured_mm : ndarray, shape (n, 3)
    known : Known

    Returns
    -------
    Placement
    """
    form = _Form(chain.rotation[-1], chain.origin[-1], nest, measured_mm, known)
    weights = np.ones(len(nest))
    rotation = _best_rotation(form, weights) if known.base is None else known.base[0]
    for _ in range(_ROBUST_ROUNDS):
        lengths = np.linalg.norm(form.residual(rotation, weights), axis=1)
        scale = max(1.4826 * float(np.median(lengths)), 1e-9)
        weights = 1.0 / (1.0 + (lengths / (2.0 * scale)) ** 2)
        if known.base is None:
            rotation = form.descend(rotation[None], weights)[0]
    # a wrong first answer would keep its own followers: try all starts again with the weights off and on
    if known.base is None:
        rotation = min(
            (rotation, _best_rotation(form, weights)),
            key=lambda candidate: form.robust_cost(candidate, weights),
        )
    return form.placement(rotation, weights)


def quick_typical_mm(chain: Chain, nest: IntArray, measured_mm: FloatArray, known: Known) -> float:
    """Median residual of the least-squares placement, without robust weights: to compare hypotheses [mm]."""
    form = _Form(chain.rotation[-1], chain.origin[-1], nest, measured_mm, known)
    weights = np.ones(len(nest))
    rotation = _best_rotation(form, weights, _FEW_STARTS) if known.base is None else known.base[0]
    return form.robust_cost(rotation, weights)


def _best_rotation(form: "_Form", weights: FloatArray, starts: int = _STARTS) -> FloatArray:
    ends = form.descend(_rotation_starts(starts), weights)
    costs = form.cost(ends, weights)
    return np.asarray(ends[int(np.argmin(costs))])


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


class _Form:
    """The eliminated problem: residuals are linear in Q once weights are fixed."""

    def __init__(
        self, rotation: FloatArray, origin: FloatArray, nest: IntArray, measured: FloatArray, known: Known
    ) -> None:
        n, k = len(nest), len(known.nest_unknown)
        columns = np.zeros((n, 3, 3 * k))
        for row, number in enumerate(nest):
            columns[row, :, 3 * (number - 1) : 3 * number] = rotation[row]
        held = np.repeat(~known.nest_unknown, 3)
        nests = np.where(known.nest_unknown[:, None], 0.0, known.nests_mm)
        self._known, self._nests, self._held = known, nests, held
        self._centre = measured.mean(axis=0)
        self._measured = measured - self._centre
        self._target = origin + np.einsum("nij,j->ni", columns, nests.reshape(-1))
        free = columns[:, :, ~held]
        self._free_base = known.base is None
        shift = np.broadcast_to(np.eye(3), (n, 3, 3))
        self._columns = np.concatenate([free, -shift], axis=2) if self._free_base else free
        # Q p as a linear map of the nine elements of Q (row-major)
        self._of_q = np.zeros((n, 3, 9))
        for i in range(3):
            self._of_q[:, i, 3 * i : 3 * i + 3] = self._measured

    def _solve(self, weights: FloatArray) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        root = np.sqrt(weights)[:, None, None]
        design = (root * self._columns).reshape(-1, self._columns.shape[2])
        of_q = (root * self._of_q).reshape(-1, 9)
        target = (root[:, :, 0] * self._target).reshape(-1)
        if design.shape[1] == 0:
            return of_q, target, np.zeros((0, 9)), np.zeros(0)
        both = np.linalg.lstsq(design, np.column_stack([of_q, target]), rcond=1e-9)[0]
        return of_q - design @ both[:, :9], target - design @ both[:, 9], both[:, :9], both[:, 9]

    def descend(self, rotations: FloatArray, weights: FloatArray) -> FloatArray:
        """Gauss-Newton on SO(3) from many base rotations (S, 3, 3) at once; only with an unknown base."""
        of_q, target, _, _ = self._solve(weights)
        normal, right = of_q.T @ of_q, of_q.T @ target
        q = np.swapaxes(rotations, 1, 2).copy()
        generators = _generators()
        for _ in range(_DESCENT_STEPS):
            tangent = np.einsum("gij,sjk->sgik", generators, q).reshape(len(q), 3, 9)
            gradient = np.einsum("sgi,si->sg", tangent, q.reshape(-1, 9) @ normal - right)
            hessian = np.einsum("sgi,ij,shj->sgh", tangent, normal, tangent)
            slope = np.trace(hessian, axis1=1, axis2=2)[:, None, None]
            hessian += (1e-9 * slope + np.finfo(float).tiny) * np.eye(3)  # also where no rotation matters
            step = -np.linalg.solve(hessian, gradient[:, :, None])[:, :, 0]
            length = np.linalg.norm(step, axis=1, keepdims=True)
            q = rotation_from_vector(step * np.minimum(1.0, 0.7 / np.maximum(length, 1e-12))) @ q
        return np.swapaxes(q, 1, 2)

    def cost(self, rotations: FloatArray, weights: FloatArray) -> FloatArray:
        """Weighted sum of squares of each base rotation, shape (S,)."""
        of_q, target, _, _ = self._solve(weights)
        flat = np.swapaxes(rotations, 1, 2).reshape(-1, 9)
        return np.asarray(((flat @ of_q.T - target) ** 2).sum(axis=1))

    def robust_cost(self, rotation: FloatArray, weights: FloatArray) -> float:
        """Median length of the residuals of one base rotation [mm]."""
        return float(np.median(np.linalg.norm(self.residual(rotation, weights), axis=1)))

    def residual(self, rotation: FloatArray, weights: FloatArray) -> FloatArray:
        """Residuals in the base frame [mm], unweighted, shape (n, 3)."""
        return self._left(rotation, self._unknowns(rotation, weights))

    def _unknowns(self, rotation: FloatArray, weights: FloatArray) -> FloatArray:
        if self._known.base is not None:
            return self._nests_only(rotation, weights)
        _, _, per_q, constant = self._solve(weights)
        return np.asarray(per_q @ rotation.T.reshape(9) - constant)

    def _nests_only(self, rotation: FloatArray, weights: FloatArray) -> FloatArray:
        if self._columns.shape[2] == 0:
            return np.zeros(0)
        root = np.sqrt(weights)[:, None]
        design = (root[:, :, None] * self._columns).reshape(-1, self._columns.shape[2])
        right = (root * self._seen(rotation)).reshape(-1)
        return np.asarray(np.linalg.lstsq(design, right, rcond=1e-9)[0])

    def _seen(self, rotation: FloatArray) -> FloatArray:
        seen = self._measured @ rotation
        if self._known.base is not None:
            seen = seen + rotation.T @ (self._centre - self._known.base[1])
        return np.asarray(seen - self._target)

    def _left(self, rotation: FloatArray, unknowns: FloatArray) -> FloatArray:
        return np.asarray(self._seen(rotation) - np.einsum("nij,j->ni", self._columns, unknowns))

    def placement(self, rotation: FloatArray, weights: FloatArray) -> Placement:
        """Return the placement that belongs to a base rotation."""
        unknowns = self._unknowns(rotation, weights)
        nests = self._nests.reshape(-1).copy()
        nests[~self._held] = unknowns[: int((~self._held).sum())]
        if self._known.base is not None:
            origin = self._known.base[1]
        else:
            origin = self._centre - rotation @ unknowns[-3:]
        left = self._left(rotation, unknowns) @ rotation.T
        return Placement(rotation, origin, nests.reshape(-1, 3), left, weights)


def _generators() -> FloatArray:
    generators = np.zeros((3, 3, 3))
    for axis in range(3):
        first, second = (axis + 1) % 3, (axis + 2) % 3
        generators[axis, second, first], generators[axis, first, second] = 1.0, -1.0
    return generators
