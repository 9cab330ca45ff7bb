"""What blocks of lengths have in common: one component, and what the readings of a stop share.

What a model of an arm lacks is angles of joints first of all: gears, backlash, couplings. The lengths of a
stop see such an angle together, each at its own lever; a discrepancy of d mm is one of d / 400 mm in every
joint, and besides a part of d in each length by itself, for what is no angle of a joint.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.identification.observations.blocks import Block, BlockResult
from truepose.identification.observations.whitening import Whitener, whitener

_ARM_MM = 400.0
_OWN_SHARE = 0.6


@dataclass(frozen=True, slots=True, kw_only=True)
class LengthBlock(Block):
    """Lengths; the discrepancy [mm] is at an arm's length from the joints.

    Certified tool nests are parameters too, and what is read against has no known place in the world:
    nothing moves these lengths that is held.
    """

    quantity: ClassVar[str] = "length"
    components: ClassVar[int] = 1

    uncertainty_mm: FloatArray  # (n,)

    def covariance(self) -> FloatArray:
        """Return the variance of each length, shape (n, 1, 1) [mm2]."""
        return np.asarray(self.uncertainty_mm[:, None, None] ** 2)

    def component_variance(self) -> FloatArray:
        """Variance of each length [mm2], shape (n,)."""
        return np.asarray(self.uncertainty_mm**2 + self.discrepancy**2)

    def stated_sigma(self) -> float:
        """Root mean variance of a length with the arm's scatter [mm]."""
        return float(np.sqrt(np.mean(self.uncertainty_mm**2) + self.scatter_mm**2))

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return a result with this block's weights."""
        n, joints = self.targets.stops.joints_rad.shape
        direction = np.zeros((n, 3)) if result.direction is None else result.direction
        lever = np.zeros((n, joints)) if result.lever_mm is None else result.lever_mm
        return replace(result, whitening=self.whitening(direction, lever))

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each length's squared residual over its variance, scatter included, shape (n,)."""
        return np.asarray(result.residual[:, 0] ** 2 / (self.component_variance() + self.scatter_mm**2))

    def whitening(self, direction: FloatArray, lever_mm: FloatArray) -> Whitener:
        """Return the weights of lengths that grow along `direction` (n, 3), with angles by `lever_mm`."""
        together = self._together()
        part = np.where(together, _OWN_SHARE, 1.0) * self.discrepancy
        own = (self.uncertainty_mm**2 + part**2)[:, None, None]
        joints = together[:, None] * self.discrepancy / _ARM_MM * lever_mm
        shared = np.hstack([self.scatter_mm * direction, joints])
        return whitener(own, self.weights, self.targets.stops.config, shared[:, None, :])

    def _together(self) -> BoolArray:
        """Return which lengths were read at a stop with others, shape (n,)."""
        _, stop, lengths = np.unique(self.targets.stops.config, return_inverse=True, return_counts=True)
        return np.asarray(lengths[stop] > 1)
