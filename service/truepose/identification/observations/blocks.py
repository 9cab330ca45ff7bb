"""Observations: what enters the identification, block by block, each with its residuals and weights.

The scatter of the arm is drawn once per stop, so readings of one stop are correlated: with D the covariance
of the readings and S what one standard deviation of each shared thing does to each of them,

    cov = D + S S^T = L L^T        white = L^-1 (observed - predicted)

and derivatives are multiplied by L^-1 alike. A weight w of a reading divides its part of D, so that a weight
of 0 takes it out; the discrepancy d adds d^2 to the diagonal of D.

A block holds readings of one kind. It predicts them, differentiates the predictions and whitens both.
`weights` (1 or 0 per reading) carry the decision about gross readings; `discrepancy` is a standard deviation
per component that the model is known to lack, added to each reading's own. Whoever fits, judges or plans asks
a block and never which kind it is: a further kind is a further class.
"""

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import ClassVar, Self

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table, distinct_values
from truepose.domain.singular_covariance import whitening_root
from truepose.identification.model.evaluation import State, Targets, evaluate
from truepose.identification.model.structure import Structure

# A weight below this is none at all: however far off a reading is, it has no part in what is whitened.
_LEAST_WEIGHT = 1e-12
_ROUNDING = 1e-12


@dataclass(frozen=True, slots=True)
class Whitener:
    """Inverse Cholesky factors, grouped by the number of readings of a stop.

    Attributes
    ----------
    groups : tuple of (rows, factors)
        Rows (S, m) of S stops of m readings each, and their factors (S, m*d, m*d) [1/mm or 1/rad].
    isotropic : ndarray, shape (n,), or None
        Where every factor is a number; then there are no groups.
    """

    groups: tuple[tuple[IntArray, FloatArray], ...]
    isotropic: FloatArray | None

    def apply(self, array: FloatArray) -> FloatArray:
        """Whiten residuals or derivatives.

        Parameters
        ----------
        array : ndarray, shape (..., n, d)

        Returns
        -------
        ndarray, shape (..., n, d)
            In standard deviations; 0 for readings without weight.
        """
        if self.isotropic is not None:  # one long row: over d at a time it takes several times as long
            scale = np.repeat(self.isotropic, array.shape[-1])
            white: FloatArray = array.reshape(*array.shape[:-2], len(scale)) * scale
            return white.reshape(array.shape)
        if len(self.groups) == 1 and self.groups[0][0].shape[1] == 1:  # every reading, in order
            return _each_alone(self.groups[0][1], array)
        result = np.empty_like(array)
        for rows, factors in self.groups:
            block = array[..., rows, :]
            flat = block.reshape(*array.shape[:-2], *factors.shape[:2])
            white = np.einsum("sab,...sb->...sa", factors, flat)
            result[..., rows, :] = white.reshape(block.shape)
        return result


def _each_alone(factors: FloatArray, array: FloatArray) -> FloatArray:
    """Whiten (..., n, d) by a factor (d, d) of each reading, all rows of a reading at once."""
    flat = array.reshape(-1, *array.shape[-2:])
    white = np.empty(flat.shape)
    np.matmul(np.swapaxes(flat, 0, 1), np.swapaxes(factors, 1, 2), out=np.swapaxes(white, 0, 1))
    return white.reshape(array.shape)


def whitener(covariance: FloatArray, weights: FloatArray, stop: IntArray, shared: FloatArray) -> Whitener:
    """Build the whitening of n readings of d components.

    Parameters
    ----------
    covariance : ndarray, shape (n, d, d)
        Of each reading on its own [mm2 or rad2].
    weights : ndarray, shape (n,)
        1 for a full reading, 0 for one that counts for nothing.
    stop : ndarray, shape (n,)
        Readings with equal numbers belong to one stop.
    shared : ndarray, shape (n, d, k)
        What a standard deviation of each of k things that a stop's readings share does to each component.

    Returns
    -------
    Whitener
    """
    counts = (weights > _LEAST_WEIGHT)[:, None, None]
    # What does not count is whitened by its own variance and multiplied by 0 after it: no division by 0.
    share = np.where(counts, weights[:, None, None], 1.0)
    inflated = covariance / share
    _, inverse, sizes = np.unique(stop, return_inverse=True, return_counts=True)
    if not shared.any() or sizes.max(initial=1) == 1:
        return _of_single(inflated + shared @ np.swapaxes(shared, 1, 2) / share, counts)
    # Stops of as many readings are factored in one batch.
    order = np.argsort(inverse, kind="stable")
    ends = np.cumsum(sizes)
    groups = []
    for size in distinct_values(sizes):
        starts = (ends - sizes)[sizes == size]
        rows = order[starts[:, None] + np.arange(size)]
        groups.append((rows, _factors(inflated, shared, counts, rows)))
    return Whitener(tuple(groups), None)


def of_independent(variance: FloatArray, weights: FloatArray) -> Whitener:
    """Whitening of n readings that share nothing and have one variance in all their components.

    What states no uncertainty weighs nothing before residuals have told how much it may.

    Parameters
    ----------
    variance : ndarray, shape (n,)
        Per component [mm2 or rad2].
    weights : ndarray, shape (n,)
    """
    weighs = (weights > _LEAST_WEIGHT) & (variance > 0.0)
    return Whitener((), np.sqrt(np.where(weighs, weights, 0.0) / np.where(weighs, variance, 1.0)))


def equal_variance(covariance: FloatArray) -> FloatArray | None:
    """Return the variance of readings that have the same in all their components.

    Parameters
    ----------
    covariance : ndarray, shape (n, d, d)
        [mm2 or rad2]

    Returns
    -------
    ndarray, shape (n,), or None
        None where one of them has axes of its own, to rounding.
    """
    diagonal = covariance[:, 0, 0]
    # Readings without axes of their own are whitened by one number each.
    apart = np.abs(covariance - diagonal[:, None, None] * np.eye(covariance.shape[1]))
    return diagonal.copy() if np.all(apart <= _ROUNDING * diagonal[:, None, None]) else None


def _of_single(total: FloatArray, counts: BoolArray) -> Whitener:
    diagonal = equal_variance(total)
    if diagonal is not None:
        return of_independent(diagonal, counts[:, 0, 0].astype(float))
    # Nothing is shared beyond a reading: the scatter is a part of its own covariance.
    rows = np.arange(len(total))[:, None]
    return Whitener(((rows, counts * whitening_root(total)),), None)


def _factors(inflated: FloatArray, shared: FloatArray, counts: BoolArray, rows: IntArray) -> FloatArray:
    stops, size = rows.shape
    d = inflated.shape[1]
    # A weight inflates what a reading has by itself; what it shares with others stays theirs as well.
    blocks = np.zeros((stops, size, d, size, d))
    for k in range(size):
        blocks[:, k, :, k, :] = inflated[rows[:, k]]
    # What does not count shares nothing with the others either.
    arms = (counts * shared)[rows].reshape(stops, size * d, -1)
    covariance = blocks.reshape(stops, size * d, size * d) + arms @ np.swapaxes(arms, 1, 2)
    kept = np.repeat(counts[rows].reshape(stops, size), d, axis=1)
    return kept[:, :, None] * whitening_root(covariance)


FALSE_ALARM = 0.01  # chance that noise alone flags any reading of a campaign
_HALF = 0.5  # weight from which on a reading counts as one


@dataclass(frozen=True, slots=True)
class BlockResult:
    """One block at one point of the parameters: raw residuals and derivatives, n readings of d components.

    Attributes
    ----------
    residual : ndarray, shape (n, d)
        Observed minus predicted [mm or rad].
    derivatives : callable
        Gives (P, n, d), worked out once somebody asks for them.
    state : State
    whitening : Whitener
    direction : ndarray, shape (n, 3), optional
        Of lengths: unit vector along which they grow with the tool's place.
    lever_mm : ndarray, shape (n, J), optional
        Of lengths: change per angle of each joint [mm/rad].
    """

    residual: FloatArray
    derivatives: Callable[[], FloatArray]
    state: State
    whitening: Whitener
    direction: FloatArray | None = None
    lever_mm: FloatArray | None = None

    @property
    def jacobian(self) -> FloatArray:
        """Derivatives of the prediction, shape (P, n, d)."""
        return self.derivatives()

    @property
    def white_residual(self) -> FloatArray:
        """Whitened residuals, shape (n * d,)."""
        return self.whitening.apply(self.residual).reshape(-1)

    @property
    def white_jacobian(self) -> FloatArray:
        """Whitened derivatives, shape (P, n * d)."""
        # By the size of the residual: -1 is no shape where there are no parameters.
        return self.whitening.apply(self.jacobian).reshape(len(self.jacobian), self.residual.size)


@dataclass(frozen=True, slots=True, kw_only=True)
class ObservationBlock(Table, ABC):
    """Readings of one kind: n of d components each.

    `table` is where the readings stand in the campaign. What the arm has no part in (`of_arm`), no model of
    it can lack anything of.
    """

    quantity: ClassVar[str]  # "position", "orientation" or "length"
    table: ClassVar[str]
    components: ClassVar[int]  # d
    of_arm: ClassVar[bool] = True

    targets: Targets  # where the readings were taken
    weights: FloatArray  # (n,)
    discrepancy: float = 0.0  # standard deviation per component that the model lacks [mm or rad]
    scatter_mm: float = 0.0  # standard deviation of the arm per axis, shared by the readings of a stop

    @abstractmethod
    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives at `values`.

        Parameters
        ----------
        structure : Structure
        values : ndarray, shape (P,)
            Internal units.
        previous : BlockResult or None
            At nearby values, whose torques are the first guess.
        """

    @abstractmethod
    def derivatives(self, state: State) -> FloatArray:
        """Return what terms of `state` do to predictions [mm or rad per unit], (P, n, d), not whitened."""

    def differentiated(self, state: State) -> Callable[[], FloatArray]:
        """Return what gives the derivatives at `state`: many a point is looked at for its residuals alone."""
        return cache(partial(self.derivatives, state))

    @abstractmethod
    def covariance(self) -> FloatArray:
        """Return the covariance of each reading as stated, the arm's scatter not included, (n, d, d)."""

    @abstractmethod
    def component_variance(self) -> FloatArray:
        """Variance per component of each reading, discrepancy included, scatter not, shape (n,)."""

    @abstractmethod
    def stated_sigma(self) -> float:
        """Typical stated standard deviation per component, scatter included; 0 where none is stated."""

    @abstractmethod
    def squared(self, result: BlockResult) -> FloatArray:
        """Return each reading's squared residual in its own covariance, scatter included, shape (n,)."""

    @abstractmethod
    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return the result of this block with other weights or another discrepancy, weighed as it is now."""

    def whitened(self, result: BlockResult) -> FloatArray:
        """Return the residuals of `result` with this block's weights, shape (n * d,)."""
        return self.rewhitened(result).white_residual

    def weighted(self, weights: FloatArray, discrepancy: float) -> Self:
        """Return the block with other weights (n,) and another discrepancy [mm or rad]."""
        return replace(self, weights=weights, discrepancy=discrepancy)

    def evaluated(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> State:
        """Return the model at the targets, the torques of an earlier result as the first guess."""
        return evaluate(structure, values, self.targets, previous.state if previous else None)

    @property
    def counts(self) -> BoolArray:
        """Which readings have more than half of their weight, shape (n,)."""
        return np.asarray(self.weights > _HALF)

    @property
    def place_mm(self) -> FloatArray | None:
        """Where each reading saw its tool nest, shape (n, 3); None of readings that are no places."""
        return None

    def ends(self) -> tuple[IntArray, ...]:
        """Return what tells the readings of one stop apart, columns of shape (n,)."""
        return (self.targets.nest,)

    def own_discrepancy(self) -> float | None:
        """Return what the readings scatter beyond what is stated, as they say themselves.

        None where only the residuals of a model tell.
        """
        return None

    def bad_among(self, off: BoolArray) -> BoolArray:
        """Return which of the readings that are off a model are bad ones, shape (n,)."""
        # A reading of the arm that is off is bad: nothing beside it says otherwise.
        return off

    def contradiction(self, result: BlockResult) -> float:
        """Return the chance that readings lie so far off a model that does not judge them; else 1."""
        # The model judges readings of the arm; only witnesses of their own may contradict it.
        return 1.0

    def held(self) -> frozenset[str]:
        """Return the parameters whose stated widths are a part of what the block says."""
        return frozenset()

    def moved_by_nest(self, result: BlockResult, nest: int) -> FloatArray:
        """Return the motion of each prediction per mm of a held tool nest, flange frame, shape (3, n, d)."""
        return np.zeros((3, *result.residual.shape))

    def moved_by_world(self, result: BlockResult) -> FloatArray:
        """Return the motion of each prediction per mm and rad, three each, of the held world, (6, n, d)."""
        return np.zeros((6, *result.residual.shape))

    def moved_by_growth(self, result: BlockResult, origin_mm: FloatArray) -> FloatArray:
        """Return the motion [mm] of each prediction where lengths from a place grow by their size, (n, d)."""
        return np.zeros_like(result.residual)


@dataclass(frozen=True, slots=True, kw_only=True)
class IndependentReadings(ObservationBlock):
    """What blocks have in common whose readings share nothing: each weighs by its own variance."""

    uncertainty: FloatArray  # (n,) stated, per component [mm or rad]

    def covariance(self) -> FloatArray:
        """Return the covariance of each reading, shape (n, d, d)."""
        return self.uncertainty[:, None, None] ** 2 * np.eye(self.components)

    def component_variance(self) -> FloatArray:
        """Variance per component, shape (n,)."""
        return np.asarray(self.uncertainty**2 + self.discrepancy**2)

    def stated_sigma(self) -> float:
        """Root mean stated variance per component; 0 where the campaign states none."""
        return float(np.sqrt(np.mean(self.uncertainty**2)))

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each reading's squared residual over its variance, shape (n,)."""
        return np.asarray((result.residual**2).sum(axis=1) / self.component_variance())

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return a result with the weights of the readings as they stand."""
        return replace(result, whitening=self.whitening())

    def whitening(self) -> Whitener:
        """Return the weights of the readings as they stand."""
        return Whitener((), np.sqrt(self.weights / self.component_variance()))


@dataclass(frozen=True, slots=True)
class StackedBlocks:
    """All blocks at one point, stacked for the solver.

    Attributes
    ----------
    results : tuple of BlockResult
    residual : ndarray, shape (m,)
        Whitened, block after block.
    derivatives : callable
        Gives (P, m), whitened.
    """

    results: tuple[BlockResult, ...]
    residual: FloatArray
    derivatives: Callable[[], FloatArray]

    @property
    def jacobian(self) -> FloatArray:
        """Whitened derivatives of the predictions, shape (P, m)."""
        return self.derivatives()

    def with_derivatives_of(self, near: "StackedBlocks") -> "StackedBlocks":
        """Return this point with the derivatives of another one, too near for them to differ."""
        results = tuple(
            replace(here, derivatives=there.derivatives)
            for here, there in zip(self.results, near.results, strict=True)
        )
        return StackedBlocks(results, self.residual, near.derivatives)


def linearise_blocks(
    structure: Structure,
    blocks: tuple[ObservationBlock, ...],
    values: FloatArray,
    previous: StackedBlocks | None,
) -> StackedBlocks:
    """Stack the whitened residuals and derivatives of all blocks.

    Parameters
    ----------
    structure : Structure
    blocks : tuple of Block
    values : ndarray, shape (P,)
        Internal units.
    previous : StackedBlocks or None
        The same blocks at nearby values.
    """
    earlier = previous.results if previous else (None,) * len(blocks)
    return _stacked(
        tuple(block.result(structure, values, before) for block, before in zip(blocks, earlier, strict=True))
    )


def reweigh(blocks: tuple[ObservationBlock, ...], point: StackedBlocks) -> StackedBlocks:
    """Return a point with its blocks as they weigh now, their predictions unchanged."""
    # Weights change no prediction; a fit linearises half as often for it.
    return _stacked(
        tuple(block.rewhitened(result) for block, result in zip(blocks, point.results, strict=True))
    )


def _stacked(results: tuple[BlockResult, ...]) -> StackedBlocks:
    # Derivatives are stacked only when asked for: a step that is refused needs none.
    residual = np.concatenate([result.white_residual for result in results])
    return StackedBlocks(results, residual, cache(partial(_stacked_derivatives, results)))


def _stacked_derivatives(results: tuple[BlockResult, ...]) -> FloatArray:
    # Most campaigns have one block, whose derivatives need not be copied.
    each = [result.white_jacobian for result in results]
    return each[0] if len(each) == 1 else np.concatenate(each, axis=1)
