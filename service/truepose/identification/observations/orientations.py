"""Orientations of the tool as observations."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import PointReadings
from truepose.identification.model.derivatives import rotation_jacobian
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import BlockResult, IndependentReadings
from truepose.kinematics.frames import cross_matrix, rotation_from_quaternion, vector_from_rotation

_UNSTATED_RAD = 1e-3  # first guess of an orientation's uncertainty; the residuals replace it


@dataclass(frozen=True, slots=True, kw_only=True)
class OrientationBlock(IndependentReadings):
    """Measured orientations of the tool; an uncertainty of 0 is only known from the residuals."""

    quantity: ClassVar[str] = "orientation"
    table: ClassVar[str] = "calibration"
    components: ClassVar[int] = 3

    measured: FloatArray  # (n, 3, 3)

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals as rotation vectors in the world [rad] and derivatives."""
        state = self.evaluated(structure, values, previous)
        return BlockResult(self._residual(state), self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the turns of the predictions as the residual sees them, shape (P, n, 3)."""
        gradient = _log_gradient(self._residual(state))
        return np.asarray(np.einsum("nij,pnj->pni", gradient, rotation_jacobian(state)))

    def moved_by_world(self, result: BlockResult) -> FloatArray:
        """Return no shift, and three turns, shape (6, n, 3)."""
        turns = np.broadcast_to(np.eye(3)[:, None, :], (3, *result.residual.shape))
        return np.concatenate([np.zeros_like(turns), turns])

    def _residual(self, state: State) -> FloatArray:
        return vector_from_rotation(self.measured @ np.swapaxes(state.orientation, 1, 2))


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


def orientation_block(points: PointReadings) -> OrientationBlock | None:
    """Return the block of orientations; None where none was measured."""
    if points.quaternion is None:
        return None
    stated = points.rotation_uncertainty_rad
    known = np.zeros(0) if stated is None else stated[np.isfinite(stated)]
    if stated is None or known.size == 0:
        uncertainty, extra = np.zeros(len(points)), _UNSTATED_RAD
    else:  # one instrument measured them all: where it says nothing, it is as good as elsewhere
        uncertainty, extra = np.where(np.isfinite(stated), stated, np.median(known)), 0.0
    return OrientationBlock(
        targets=Targets(points.stops, points.nest),
        measured=rotation_from_quaternion(points.quaternion),
        uncertainty=uncertainty,
        weights=np.ones(len(points)),
        discrepancy=extra,
    )
