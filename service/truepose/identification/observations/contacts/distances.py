"""Certified distances between targets: two spheres on a bar of known length.

With centres A and B, distance = |B - A|. They give a closed loop its scale, which it has from nothing else
where the tool itself is not certified (MasterCal: thesis of A. Nubiola, 2014, section 1.8).
"""

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.measurement.campaign import Stops, TargetDistances
from truepose.domain.measurement.targets import Target
from truepose.domain.robot import Robot
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.parameters.counterparts import centre_of, indices_of_target
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import BlockResult, IndependentReadings


@dataclass(frozen=True, slots=True, kw_only=True)
class DistanceBlock(IndependentReadings):
    """Certified distances; they are no stops of the arm: joints 0, configurations of their own."""

    quantity: ClassVar[str] = "length"
    table: ClassVar[str] = "target_distances"
    components: ClassVar[int] = 1
    of_arm: ClassVar[bool] = False

    pair: IntArray  # (n, 2) indices in the structure's targets
    distance_mm: FloatArray  # (n,)

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals [mm] and derivatives."""
        state = self.evaluated(structure, values, previous)
        distance = np.linalg.norm(self._joined(state), axis=1)
        residual = (self.distance_mm - distance)[:, None]
        return BlockResult(residual, self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the distances, shape (P, n, 1)."""
        joined = self._joined(state)
        direction = joined / np.linalg.norm(joined, axis=1)[:, None]
        jacobian = np.zeros((len(state.structure.names), len(joined), 1))
        for row, (first, second) in enumerate(self.pair.tolist()):
            for number, sign in ((first, -1.0), (second, 1.0)):
                start = indices_of_target(state.structure, state.structure.targets[number]).start
                jacobian[start : start + 3, row, 0] += sign * direction[row]
        return jacobian

    def _joined(self, state: State) -> FloatArray:
        """Return the vector from the first to the second centre, shape (n, 3)."""
        structure = state.structure
        ends = distinct_values(self.pair).tolist()
        centre = {k: centre_of(structure, state.values, structure.targets[k]) for k in ends}
        return np.array([centre[second] - centre[first] for first, second in self.pair.tolist()])

    def own_discrepancy(self) -> float | None:
        """Return none: a certificate is as good as it is stated to be."""
        return 0.0

    def weighted(self, weights: FloatArray, discrepancy: float) -> Self:
        """Return the block with other weights; no model of an arm is in it that could lack something."""
        return replace(self, weights=weights)


def distance_block(
    distances: TargetDistances, targets: tuple[Target, ...], robot: Robot
) -> DistanceBlock | None:
    """Return the certified distances between these targets; None where there is none.

    Parameters
    ----------
    distances : TargetDistances
    targets : tuple of Target
        Of the structure: those against which something was read.
    robot : Robot
    """
    numbers = [target.number for target in targets]
    pairs = list(zip(distances.target_a.tolist(), distances.target_b.tolist(), strict=True))
    rows = [row for row, pair in enumerate(pairs) if set(pair) <= set(numbers)]
    if not rows:
        return None
    stops = Stops(-1 - np.arange(len(rows)), np.zeros((len(rows), robot.n_joints)))
    return DistanceBlock(
        targets=Targets(stops, np.ones(len(rows), dtype=np.int64), length_mm=distances.distance_mm[rows]),
        pair=np.array([[numbers.index(number) for number in pairs[row]] for row in rows]),
        distance_mm=distances.distance_mm[rows],
        uncertainty=distances.standard_uncertainty_mm[rows],
        weights=np.ones(len(rows)),
    )
