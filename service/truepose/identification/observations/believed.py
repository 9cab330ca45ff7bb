"""What is believed of parameters together, as readings of sums of them: one a row, each of variance 1."""

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.measurement.campaign import Stops
from truepose.identification.distributions import chi2_exceeded
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import Block, BlockResult
from truepose.identification.observations.whitening import Whitener

QUANTITY = "belief"


@dataclass(frozen=True, slots=True, kw_only=True)
class BeliefBlock(Block):
    """Sums of parameters and what they are believed to be; none is ever gross, and each counts in full."""

    quantity: ClassVar[str] = QUANTITY
    table: ClassVar[str] = "belief"
    components: ClassVar[int] = 1
    of_arm: ClassVar[bool] = False

    names: tuple[str, ...]  # of the Q parameters
    rows: FloatArray  # (S, Q) sums of them, per unit
    read: FloatArray  # (S,)

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives; parameters that a structure lacks stand at 0."""
        state = self.evaluated(structure, values, previous)
        value = dict(zip(structure.names, values.tolist(), strict=True))
        believed = self.rows @ np.array([value.get(name, 0.0) for name in self.names])
        residual = (self.read - believed)[:, None]
        return BlockResult(residual, self.differentiated(state), state, _each_alone(len(self.read)))

    def derivatives(self, state: State) -> FloatArray:
        """Return the sums, shape (P, S, 1)."""
        names = state.structure.names
        jacobian = np.zeros((len(names), len(self.read), 1))
        for column, name in enumerate(self.names):
            if name in names:
                jacobian[names.index(name), :, 0] = self.rows[:, column]
        return jacobian

    def covariance(self) -> FloatArray:
        """Return variances of 1, shape (S, 1, 1)."""
        return np.ones((len(self.read), 1, 1))

    def component_variance(self) -> FloatArray:
        """Return variances of 1, shape (S,)."""
        return np.ones(len(self.read))

    def stated_sigma(self) -> float:
        """Return 0: no instrument states it."""
        return 0.0

    def squared(self, result: BlockResult) -> FloatArray:
        """Return squared residuals, shape (S,)."""
        return np.asarray(result.residual[:, 0] ** 2)

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return the result as it is."""
        return result

    def weighted(self, weights: FloatArray, discrepancy: float) -> Self:
        """Return the block as it is: no misfit of readings makes a belief less known."""
        return self

    def own_discrepancy(self) -> float | None:
        """Return 0."""
        return 0.0

    def bad_among(self, off: BoolArray) -> BoolArray:
        """Return none."""
        return np.zeros_like(off)

    def contradiction(self, result: BlockResult) -> float:
        """Return the chance that a robot of the type lies so far off what is believed of it."""
        return chi2_exceeded(float(self.squared(result).sum()), float(len(self.read)))


def belief_block(names: tuple[str, ...], rows: FloatArray, read: FloatArray, n_joints: int) -> BeliefBlock:
    """Return the block of sums (S, Q) of named parameters and what they are believed to be, (S,)."""
    n = len(read)
    # Numbers that no configuration of an arm has: nothing is shared with one.
    stops = Stops(config=-(10**9) - np.arange(n), joints_rad=np.zeros((n, n_joints)))
    targets = Targets(stops, np.ones(n, dtype=np.int64))
    return BeliefBlock(targets=targets, weights=np.ones(n), names=names, rows=rows, read=read)


def _each_alone(n: int) -> Whitener:
    return Whitener((), np.ones(n))
