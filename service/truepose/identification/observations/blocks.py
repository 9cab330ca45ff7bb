"""Observations: what enters the identification, block by block, each with its residuals and weights.

A block predicts its observations, differentiates them and whitens both. `weights` (1 or 0 per
reading) carry the decision about gross readings; `discrepancy` is a standard deviation per
component that the model is known to lack, added to each reading's own.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, Table
from truepose.identification.model.derivatives import position_jacobian, rotation_jacobian
from truepose.identification.model.evaluation import State, Targets, evaluate
from truepose.identification.model.structure import Structure
from truepose.identification.observations.whitening import Whitener, whitener
from truepose.kinematics.frames import cross_matrix, vector_from_rotation


@dataclass(frozen=True, slots=True)
class BlockResult:
    """One block at one point of the parameters: raw residuals and derivatives, n readings of d components."""

    residual: FloatArray  # (n, d)
    jacobian: FloatArray  # (P, n, d)
    state: State
    whitening: Whitener
    direction: FloatArray | None = None  # (n, 3) of the legs
    lever_mm: FloatArray | None = None  # (n, J) of the legs: change of the length per angle of each joint

    @property
    def white_residual(self) -> FloatArray:
        """Whitened residuals, shape (n * d,)."""
        return self.whitening.apply(self.residual).reshape(-1)

    @property
    def white_jacobian(self) -> FloatArray:
        """Whitened derivatives, shape (P, n * d)."""
        return self.whitening.apply(self.jacobian).reshape(len(self.jacobian), self.residual.size)


class Block(Protocol):
    """A set of observations of one kind."""

    @property
    def targets(self) -> Targets:
        """Where the n readings were taken."""
        ...

    @property
    def weights(self) -> FloatArray:
        """Weight of each reading, shape (n,)."""
        ...

    @property
    def discrepancy(self) -> float:
        """Standard deviation per component that the model lacks."""
        ...

    @property
    def scatter_mm(self) -> float:
        """Standard deviation of the arm per axis, shared by the readings of a stop."""
        ...

    def component_variance(self) -> FloatArray:
        """Variance per component of each reading, discrepancy included, scatter not, shape (n,)."""
        ...

    def stated_sigma(self) -> float:
        """Typical stated standard deviation per component, scatter included; 0 where none is stated."""
        ...

    def whitened(self, result: BlockResult) -> FloatArray:
        """Return the residuals of `result` with this block's weights, shape (n * d,)."""
        ...

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each reading's squared residual in its own covariance, scatter included, shape (n,)."""
        ...

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives at `values`."""
        ...

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return the result of this block with other weights or another discrepancy, weighed as it is now."""
        ...

    def derivatives(self, state: State) -> FloatArray:
        """Return what the terms of `state` do to the predictions, shape (P, n, d), not whitened."""
        ...

    def weighted(self, weights: FloatArray, discrepancy: float) -> "Block":
        """Return the block with other weights and another discrepancy."""
        ...

    def taken(self, rows: IntArray) -> "Block":
        """Return the block with some of its readings."""
        ...


class IndependentReadings:
    """What blocks have in common whose readings share nothing: each weighs by its own variance."""

    __slots__ = ()
    uncertainty: FloatArray  # (n,) stated, per component
    weights: FloatArray  # (n,)
    discrepancy: float  # per component

    def component_variance(self) -> FloatArray:
        """Variance per component, shape (n,)."""
        return np.asarray(self.uncertainty**2 + self.discrepancy**2)

    def stated_sigma(self) -> float:
        """Root mean stated variance per component; 0 where the campaign states none."""
        return float(np.sqrt(np.mean(self.uncertainty**2)))

    def whitened(self, result: BlockResult) -> FloatArray:
        """Return residuals with this block's weights, shape (n * d,)."""
        return self.whitening().apply(result.residual).reshape(-1)

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each reading's squared residual over its variance, shape (n,)."""
        return np.asarray((result.residual**2).sum(axis=1) / self.component_variance())

    def whitening(self) -> Whitener:
        """Return the weights of the readings as they stand."""
        return Whitener((), np.sqrt(self.weights / self.component_variance()))

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return a result with the weights of the readings as they stand."""
        return replace(result, whitening=self.whitening())


@dataclass(frozen=True, slots=True)
class PositionBlock(Table):
    """Measured nest positions."""

    targets: Targets
    measured_mm: FloatArray  # (n, 3)
    covariance_mm2: FloatArray  # (n, 3, 3) of the readings alone
    scatter_mm: float  # of the arm; 0 where the covariance contains it
    weights: FloatArray  # (n,)
    discrepancy: float = 0.0  # mm per axis
    whitening: Whitener | None = None

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals [mm] and derivatives."""
        state = evaluate(structure, values, self.targets, previous.state if previous else None)
        residual = self.measured_mm - state.position_mm
        return BlockResult(residual, self.derivatives(state), state, self._whitening())

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return a result with this block's weights."""
        return replace(result, whitening=self._whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the motions of the predictions, shape (P, n, 3)."""
        return position_jacobian(state)

    def component_variance(self) -> FloatArray:
        """Mean variance over the three axes, shape (n,)."""
        return np.asarray(np.trace(self.covariance_mm2, axis1=1, axis2=2) / 3.0 + self.discrepancy**2)

    def stated_sigma(self) -> float:
        """Root mean variance per axis with the arm's scatter [mm]."""
        mean = float(np.trace(self.covariance_mm2, axis1=1, axis2=2).mean()) / 3.0
        return float(np.sqrt(mean + self.scatter_mm**2))

    def whitened(self, result: BlockResult) -> FloatArray:
        """Return residuals with this block's weights, shape (3 n,)."""
        return self._whitening().apply(result.residual).reshape(-1)

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each reading's squared residual in its own covariance, scatter included, shape (n,)."""
        covariance = self.total_covariance() + self.scatter_mm**2 * np.eye(3)
        whitened = np.linalg.solve(covariance, result.residual[:, :, None])[:, :, 0]
        return np.asarray(np.einsum("ni,ni->n", result.residual, whitened))

    def total_covariance(self) -> FloatArray:
        """Return each reading's covariance with discrepancy, without the arm's scatter, shape (n, 3, 3)."""
        return self.covariance_mm2 + self.discrepancy**2 * np.eye(3)

    def _whitening(self) -> Whitener:
        return self.whitening or self.prepared().whitening or Whitener((), None)

    def prepared(self) -> "PositionBlock":
        """Return the block with its whitening computed once."""
        shared = np.broadcast_to(self.scatter_mm * np.eye(3), self.covariance_mm2.shape)
        built = whitener(self.total_covariance(), self.weights, self.targets.stops.config, shared)
        return replace(self, whitening=built)

    def weighted(self, weights: FloatArray, discrepancy: float) -> "PositionBlock":
        """Return the block with other weights and another discrepancy [mm]."""
        return replace(self, weights=weights, discrepancy=discrepancy, whitening=None).prepared()

    def taken(self, rows: IntArray) -> "PositionBlock":
        """Return the block with some of its readings."""
        return Table.taken(replace(self, whitening=None), rows).prepared()


@dataclass(frozen=True, slots=True)
class OrientationBlock(IndependentReadings, Table):
    """Measured orientations of the tool."""

    targets: Targets
    measured: FloatArray  # (n, 3, 3)
    uncertainty: FloatArray  # (n,) stated [rad]; 0 where it is only known from the residuals
    weights: FloatArray  # (n,)
    discrepancy: float  # rad per axis
    scatter_mm: float = 0.0  # the arm's scatter is one of position

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals as rotation vectors in the world [rad] and derivatives."""
        state = evaluate(structure, values, self.targets, previous.state if previous else None)
        return BlockResult(self._residual(state), self.derivatives(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the turns of the predictions as the residual sees them, shape (P, n, 3)."""
        gradient = _log_gradient(self._residual(state))
        return np.asarray(np.einsum("nij,pnj->pni", gradient, rotation_jacobian(state)))

    def _residual(self, state: State) -> FloatArray:
        return vector_from_rotation(self.measured @ np.swapaxes(state.orientation, 1, 2))

    def weighted(self, weights: FloatArray, discrepancy: float) -> "OrientationBlock":
        """Return the block with other weights and another discrepancy [rad]."""
        return replace(self, weights=weights, discrepancy=discrepancy)


def _log_gradient(vector: FloatArray) -> FloatArray:
    """Change of log(M P^T) per small turn of P, with its sign: the inverse right Jacobian of SO(3).

    Source: J. Sola, J. Deray, D. Atchuthan, arXiv 1812.01537, 2018, equation 144.
    """
    angle = np.linalg.norm(vector, axis=1)[:, None, None]
    safe = np.maximum(angle, 1e-4)
    second = np.where(
        angle > 1e-4, 1.0 / safe**2 - (1.0 + np.cos(safe)) / (2.0 * safe * np.sin(safe)), 1.0 / 12.0
    )
    skew = cross_matrix(vector)
    return np.asarray(np.eye(3) + 0.5 * skew + second * (skew @ skew))


@dataclass(frozen=True, slots=True)
class Joint:
    """All blocks at one point, stacked for the solver."""

    results: tuple[BlockResult, ...]
    residual: FloatArray  # (m,) whitened
    jacobian: FloatArray  # (P, m) whitened


def linearise_blocks(
    structure: Structure, blocks: tuple[Block, ...], values: FloatArray, previous: Joint | None
) -> Joint:
    """Stack the whitened residuals and derivatives of all blocks."""
    earlier = previous.results if previous else (None,) * len(blocks)
    return _stacked(
        tuple(block.result(structure, values, before) for block, before in zip(blocks, earlier, strict=True))
    )


def reweighed(blocks: tuple[Block, ...], point: Joint) -> Joint:
    """Return a point with its blocks as they weigh now, their predictions unchanged."""
    return _stacked(
        tuple(block.rewhitened(result) for block, result in zip(blocks, point.results, strict=True))
    )


def _stacked(results: tuple[BlockResult, ...]) -> Joint:
    if len(results) == 1:
        return Joint(results, results[0].white_residual, results[0].white_jacobian)
    return Joint(
        results,
        np.concatenate([result.white_residual for result in results]),
        np.concatenate([result.white_jacobian for result in results], axis=1),
    )
