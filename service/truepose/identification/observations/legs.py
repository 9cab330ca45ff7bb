"""Legs as observations: measured lengths from base nests, which are parameters themselves, to tool nests."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import LegReadings
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.lengths import excess_mm, foot_gradient, length_jacobian, moved_feet
from truepose.identification.model.parameters.anchors import LEG_OFFSET, anchor_places, first_anchor
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import BlockResult
from truepose.identification.observations.lengths import LengthBlock
from truepose.kinematics.chain import theta_gradient


@dataclass(frozen=True, slots=True, kw_only=True)
class LegBlock(LengthBlock):
    """Measured lengths from base nests, which are parameters themselves, to tool nests."""

    table: ClassVar[str] = "legs"

    anchor: IntArray  # (n,) index in the structure's anchors
    length_mm: FloatArray  # (n,)

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals [mm] and derivatives."""
        state = self.evaluated(structure, values, previous)
        arm = state.position_mm - moved_feet(state, self._feet(state))
        distance = np.linalg.norm(arm, axis=1)
        direction = arm / distance[:, None]
        offset = values[structure.index_of(LEG_OFFSET)] if LEG_OFFSET in structure.names else 0.0
        residual = (self.length_mm - distance - offset - excess_mm(state))[:, None]
        lever = np.einsum("jni,ni->nj", theta_gradient(state.chain, state.position_mm), direction)
        whitening = self.whitening(direction, lever)
        return BlockResult(residual, self.differentiated(state), state, whitening, direction, lever)

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the predicted lengths, anchors and offset included, shape (P, n, 1)."""
        structure, feet = state.structure, self._feet(state)
        arm = state.position_mm - moved_feet(state, feet)
        direction = arm / np.linalg.norm(arm, axis=1)[:, None]
        jacobian = length_jacobian(state, feet)
        rows = np.arange(len(self.anchor))
        first = first_anchor(structure)
        for component in range(3):
            own = np.einsum("ni,ni->n", foot_gradient(state, component), direction)
            jacobian[first + 3 * self.anchor + component, rows] = -own
        if LEG_OFFSET in structure.names:
            jacobian[structure.index_of(LEG_OFFSET)] = 1.0
        return np.asarray(jacobian[:, :, None])

    def _feet(self, state: State) -> FloatArray:
        """Return the anchor of each leg, shape (n, 3)."""
        return np.asarray(anchor_places(state.structure, state.values)[self.anchor])

    def ends(self) -> tuple[IntArray, ...]:
        """Return the two nests of each leg."""
        return self.targets.nest, self.anchor

    def moved_by_growth(self, result: BlockResult, origin_mm: FloatArray) -> FloatArray:
        """Return the lengths themselves, shape (n, 1): they grow from wherever."""
        return self.length_mm[:, None]


def leg_targets(legs: LegReadings) -> Targets:
    """Return where lengths were read, with what effects of ballbar and fixture depend on."""
    return Targets(legs.stops, legs.nest, legs.placement, legs.initialisation, legs.length_mm)


def leg_block(legs: LegReadings, scatter_mm: float, anchors: tuple[tuple[int, int], ...]) -> LegBlock:
    """Return the block of leg readings for a structure with these anchors.

    Raises
    ------
    ConfigurationError
        A leg is from a cup that the structure does not know.
    """
    missing = sorted(set(legs.cups) - set(anchors))
    if missing:
        raise ConfigurationError(
            f"Placement {missing[0][0]}, base point {missing[0][1]} was not among the legs "
            "that the model was made from."
        )
    return LegBlock(
        targets=leg_targets(legs),
        anchor=np.array([anchors.index(cup) for cup in legs.cups]),
        length_mm=legs.length_mm,
        uncertainty_mm=legs.standard_uncertainty_mm,
        scatter_mm=scatter_mm,
        weights=np.ones(len(legs)),
    )
