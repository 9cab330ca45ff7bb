"""Observations: what enters the identification, block by block, each with its residuals and weights.

A block predicts its observations, differentiates them and whitens both. `weights` (1 or 0 per
reading) carry the decision about gross readings; `discrepancy` is a standard deviation per
component that the model is known to lack, added to each reading's own.
"""

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from service.domain.arrays import FloatArray, IntArray
from service.identification.evaluation import (
    State,
    Targets,
    evaluate,
    position_jacobian,
    rotation_jacobian,
)
from service.identification.structure import Structure
from service.identification.whitening import Whitener, whitener
from service.kinematics.frames import vector_from_rotation


@dataclass(frozen=True, slots=True)
class BlockResult:
    """One block at one point of the parameters: raw residuals and derivatives, n readings of d components."""

    residual: FloatArray  # (n, d)
    jacobian: FloatArray  # (P, n, d)
    state: State
    whitening: Whitener

    @property
    def white_residual(self) -> FloatArray:
        """Whitened residuals, shape (n * d,)."""
        return self.whitening.apply(self.residual).reshape(-1)

    @property
    def white_jacobian(self) -> FloatArray:
        """Whitened derivatives, shape (P, n * d)."""
        return self.whitening.apply(self.jacobian).reshape(len(self.jacobian), -1)


class Block(Protocol):
    """A set of observations of one kind."""

    @property
    def weights(self) -> FloatArray:
        """Weight of each reading, shape (n,)."""
        ...

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives at `values`."""
        ...

    def weighted(self, weights: FloatArray, discrepancy: float) -> "Block":
        """Return the block with other weights and another discrepancy."""
        ...

    def subset(self, rows: IntArray) -> "Block":
        """Return the block with some of its readings."""
        ...


@dataclass(frozen=True, slots=True)
class PositionBlock:
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
        jacobian = position_jacobian(state)
        return BlockResult(self.measured_mm - state.position_mm, jacobian, state, self._whitening())

    def total_covariance(self) -> FloatArray:
        """Covariance of each reading with discrepancy, without the arm's scatter, shape (n, 3, 3)."""
        return self.covariance_mm2 + self.discrepancy**2 * np.eye(3)

    def _whitening(self) -> Whitener:
        return self.whitening or self.prepared().whitening or Whitener((), None)

    def prepared(self) -> "PositionBlock":
        """Return the block with its whitening computed once."""
        shared = np.broadcast_to(np.eye(3), self.covariance_mm2.shape)
        stop = self.targets.stops.config
        built = whitener(self.total_covariance(), self.weights, stop, shared, self.scatter_mm)
        return replace(self, whitening=built)

    def weighted(self, weights: FloatArray, discrepancy: float) -> "PositionBlock":
        """Return the block with other weights and another discrepancy [mm]."""
        return replace(self, weights=weights, discrepancy=discrepancy, whitening=None).prepared()

    def subset(self, rows: IntArray) -> "PositionBlock":
        """Return the block with some of its readings."""
        return replace(
            self,
            targets=targets_subset(self.targets, rows),
            measured_mm=self.measured_mm[rows],
            covariance_mm2=self.covariance_mm2[rows],
            weights=self.weights[rows],
            whitening=None,
        ).prepared()


@dataclass(frozen=True, slots=True)
class OrientationBlock:
    """Measured orientations of the tool."""

    targets: Targets
    measured: FloatArray  # (n, 3, 3)
    uncertainty_rad: FloatArray  # (n,) stated; 0 where it is only known from the residuals
    weights: FloatArray  # (n,)
    discrepancy: float  # rad per axis

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals as rotation vectors in the world [rad] and derivatives."""
        state = evaluate(structure, values, self.targets, previous.state if previous else None)
        residual = vector_from_rotation(self.measured @ np.swapaxes(state.orientation, 1, 2))
        variance = self.uncertainty_rad**2 + self.discrepancy**2
        factor = np.sqrt(np.maximum(self.weights, 1e-12) / variance)
        return BlockResult(residual, rotation_jacobian(state), state, Whitener((), factor))

    def weighted(self, weights: FloatArray, discrepancy: float) -> "OrientationBlock":
        """Return the block with other weights and another discrepancy [rad]."""
        return replace(self, weights=weights, discrepancy=discrepancy)

    def subset(self, rows: IntArray) -> "OrientationBlock":
        """Return the block with some of its readings."""
        return replace(
            self,
            targets=targets_subset(self.targets, rows),
            measured=self.measured[rows],
            uncertainty_rad=self.uncertainty_rad[rows],
            weights=self.weights[rows],
        )


@dataclass(frozen=True, slots=True)
class LegBlock:
    """Measured lengths from base nests, which are parameters themselves, to tool nests."""

    targets: Targets
    anchor: IntArray  # (n,) index in the structure's anchors
    length_mm: FloatArray  # (n,)
    uncertainty_mm: FloatArray  # (n,)
    scatter_mm: float
    weights: FloatArray  # (n,)
    discrepancy: float = 0.0  # mm

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals [mm] and derivatives."""
        state = evaluate(structure, values, self.targets, previous.state if previous else None)
        first = structure.index_of(anchor_name(structure.anchors[0], 0))
        anchors = values[first : first + 3 * len(structure.anchors)].reshape(-1, 3)
        arm = state.position_mm - anchors[self.anchor]
        distance = np.linalg.norm(arm, axis=1)
        direction = arm / distance[:, None]
        jacobian = np.einsum("pni,ni->pn", position_jacobian(state), direction)
        rows = np.arange(len(self.anchor))
        for component in range(3):
            jacobian[first + 3 * self.anchor + component, rows] = -direction[:, component]
        offset = structure.index_of(LEG_OFFSET) if LEG_OFFSET in structure.names else None
        if offset is not None:
            jacobian[offset] = 1.0
        predicted = distance + (values[offset] if offset is not None else 0.0)
        residual = (self.length_mm - predicted)[:, None]
        return BlockResult(residual, jacobian[:, :, None], state, self._whitening(direction))

    def _whitening(self, direction: FloatArray) -> Whitener:
        variance = self.uncertainty_mm**2 + self.discrepancy**2
        return whitener(
            variance[:, None, None],
            self.weights,
            self.targets.stops.config,
            direction[:, None, :],
            self.scatter_mm,
        )

    def weighted(self, weights: FloatArray, discrepancy: float) -> "LegBlock":
        """Return the block with other weights and another discrepancy [mm]."""
        return replace(self, weights=weights, discrepancy=discrepancy)

    def subset(self, rows: IntArray) -> "LegBlock":
        """Return the block with some of its readings."""
        return replace(
            self,
            targets=targets_subset(self.targets, rows),
            anchor=self.anchor[rows],
            length_mm=self.length_mm[rows],
            uncertainty_mm=self.uncertainty_mm[rows],
            weights=self.weights[rows],
        )


LEG_OFFSET = "length_offset"


def anchor_name(anchor: tuple[int, int], component: int) -> str:
    """Return e.g. `anchor_1_3_x` for placement 1, base point 3, component 0."""
    return f"anchor_{anchor[0]}_{anchor[1]}_{'xyz'[component]}"


def targets_subset(targets: Targets, rows: IntArray) -> Targets:
    """Return some rows of the targets."""
    stops = targets.stops
    taken = {
        name: None if value is None else value[rows]
        for name in type(stops).__dataclass_fields__
        for value in (getattr(stops, name),)
    }
    return Targets(replace(stops, **taken), targets.nest[rows])


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
    results = tuple(
        block.result(structure, values, before) for block, before in zip(blocks, earlier, strict=True)
    )
    if len(results) == 1:
        return Joint(results, results[0].white_residual, results[0].white_jacobian)
    return Joint(
        results,
        np.concatenate([result.white_residual for result in results]),
        np.concatenate([result.white_jacobian for result in results], axis=1),
    )
