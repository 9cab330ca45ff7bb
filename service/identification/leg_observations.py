"""Legs as observations: measured lengths from base nests, which are parameters themselves, to tool nests."""

from dataclasses import dataclass, replace

import numpy as np

from service.domain.arrays import FloatArray, IntArray
from service.identification.evaluation import State, Targets, evaluate
from service.identification.leg_lengths import excess_mm, foot_gradient, length_jacobian, moved_feet
from service.identification.observations import BlockResult, targets_subset
from service.identification.structure import Structure
from service.identification.whitening import Whitener, whitener

LEG_OFFSET = "length_offset"


def anchor_name(anchor: tuple[int, int], component: int) -> str:
    """Return e.g. `anchor_1_3_x` for placement 1, base point 3, component 0."""
    return f"anchor_{anchor[0]}_{anchor[1]}_{'xyz'[component]}"


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
        arm = state.position_mm - moved_feet(state, self._feet(state))
        distance = np.linalg.norm(arm, axis=1)
        direction = arm / distance[:, None]
        offset = values[structure.index_of(LEG_OFFSET)] if LEG_OFFSET in structure.names else 0.0
        residual = (self.length_mm - distance - offset - excess_mm(state))[:, None]
        return BlockResult(residual, self.derivatives(state), state, self._whitening(direction), direction)

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the predicted lengths, anchors and offset included, shape (P, n, 1)."""
        structure, feet = state.structure, self._feet(state)
        arm = state.position_mm - moved_feet(state, feet)
        direction = arm / np.linalg.norm(arm, axis=1)[:, None]
        jacobian = length_jacobian(state, feet)
        rows = np.arange(len(self.anchor))
        first = structure.index_of(anchor_name(structure.anchors[0], 0))
        for component in range(3):
            own = np.einsum("ni,ni->n", foot_gradient(state, component), direction)
            jacobian[first + 3 * self.anchor + component, rows] = -own
        if LEG_OFFSET in structure.names:
            jacobian[structure.index_of(LEG_OFFSET)] = 1.0
        return np.asarray(jacobian[:, :, None])

    def _feet(self, state: State) -> FloatArray:
        """Return the anchor of each leg, shape (n, 3)."""
        structure = state.structure
        first = structure.index_of(anchor_name(structure.anchors[0], 0))
        anchors = state.values[first : first + 3 * len(structure.anchors)].reshape(-1, 3)
        return np.asarray(anchors[self.anchor])

    def component_variance(self) -> FloatArray:
        """Variance of each length [mm2], shape (n,)."""
        return np.asarray(self.uncertainty_mm**2 + self.discrepancy**2)

    def stated_sigma(self) -> float:
        """Root mean variance of a length with the arm's scatter [mm]."""
        return float(np.sqrt(np.mean(self.uncertainty_mm**2) + self.scatter_mm**2))

    def whitened(self, result: BlockResult) -> FloatArray:
        """Return residuals with this block's weights, shape (n,)."""
        direction = np.zeros((len(self.anchor), 3)) if result.direction is None else result.direction
        return self._whitening(direction).apply(result.residual).reshape(-1)

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each length's squared residual over its variance, scatter included, shape (n,)."""
        return np.asarray(result.residual[:, 0] ** 2 / (self.component_variance() + self.scatter_mm**2))

    def _whitening(self, direction: FloatArray) -> Whitener:
        return whitener(
            self.component_variance()[:, None, None],
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
