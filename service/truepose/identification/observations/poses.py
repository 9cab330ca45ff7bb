"""Positions of tool nests and orientations of the tool as observations.

With R, o the flange frame of the model and x a nest in it, what is left of a reading is

    position p          p - (o + R x)       [mm]
    orientation M       log(M R^T)          [rad], a rotation vector

per small turn of R the latter changes by the inverse right Jacobian of SO(3).
"""

from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, Table, distinct_values
from truepose.domain.campaign import PointReadings
from truepose.identification.model.derivatives import position_jacobian, rotation_jacobian
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import (
    BlockResult,
    IndependentReadings,
    ObservationBlock,
    Whitener,
    equal_variance,
    of_independent,
    whitener,
)
from truepose.kinematics.frames import cross_matrix, rotation_from_quaternion, vector_from_rotation


@dataclass(frozen=True, slots=True, kw_only=True)
class PositionBlock(ObservationBlock):
    """Measured nest positions.

    Attributes
    ----------
    measured_mm : ndarray, shape (n, 3)
        World frame.
    covariance_mm2 : ndarray, shape (n, 3, 3)
        Of the readings alone.
    lone_mm2 : ndarray, shape (n,), or None
        Variance per axis with the arm's scatter, where no reading has a fellow at its stop or an axis of its
        own.
    ready : Whitener or None
        The whitening, computed once.
    """

    quantity: ClassVar[str] = "position"
    table: ClassVar[str] = "calibration"
    components: ClassVar[int] = 3

    measured_mm: FloatArray
    covariance_mm2: FloatArray
    lone_mm2: FloatArray | None = None
    ready: Whitener | None = None

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives, parameters as of `ObservationBlock.result`.

        Returns
        -------
        BlockResult
            Residual (n, 3) [mm]: measured minus predicted position, world frame.
        """
        state = self.evaluated(structure, values, previous)
        residual = self.measured_mm - state.position_mm
        return BlockResult(residual, self.differentiated(state), state, self._whitening())

    def rewhitened(self, result: BlockResult) -> BlockResult:
        """Return a result with this block's weights."""
        return replace(result, whitening=self._whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the motions of the predictions.

        Parameters
        ----------
        state : State
            At n readings.

        Returns
        -------
        ndarray, shape (P, n, 3)
            mm per internal unit of each parameter.
        """
        return position_jacobian(state)

    def covariance(self) -> FloatArray:
        """Return the covariance of each reading, shape (n, 3, 3) [mm2]."""
        return self.covariance_mm2

    def component_variance(self) -> FloatArray:
        """Mean variance over the three axes, shape (n,)."""
        return np.asarray(np.trace(self.covariance_mm2, axis1=1, axis2=2) / 3.0 + self.discrepancy**2)

    def stated_sigma(self) -> float:
        """Root mean variance per axis with the arm's scatter [mm]."""
        mean = float(np.trace(self.covariance_mm2, axis1=1, axis2=2).mean()) / 3.0
        return float(np.sqrt(mean + self.scatter_mm**2))

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each reading's squared residual in its own covariance.

        Parameters
        ----------
        result : BlockResult

        Returns
        -------
        ndarray, shape (n,)
            r^T (D + d^2 1 + s^2 1)^-1 r [1], with the stated covariance D, discrepancy d and scatter s.
        """
        # As in the whitening: lone readings of one variance need no 3 by 3 equations.
        if self.lone_mm2 is not None:
            return np.asarray((result.residual**2).sum(axis=1) / (self.lone_mm2 + self.discrepancy**2))
        covariance = self._lacking() + self.scatter_mm**2 * np.eye(3)
        whitened = np.linalg.solve(covariance, result.residual[:, :, None])[:, :, 0]
        return np.asarray(np.einsum("ni,ni->n", result.residual, whitened))

    @property
    def place_mm(self) -> FloatArray | None:
        """Where the instrument saw each nest, shape (n, 3)."""
        return self.measured_mm

    def moved_by_nest(self, result: BlockResult, nest: int) -> FloatArray:
        """Return how readings of a held nest move with it.

        Parameters
        ----------
        result : BlockResult
        nest : int
            1-based.

        Returns
        -------
        ndarray, shape (3, n, 3)
            Axes of the flange frame in the world [mm per mm]; zeros for readings of other nests.
        """
        # Certificates state coordinates in the flange frame; its axes carry them into the world.
        here = (self.targets.nest == nest)[:, None]
        last = result.state.chain.end_rotation
        return np.stack([np.where(here, last[:, :, k], 0.0) for k in range(3)])

    def moved_by_world(self, result: BlockResult) -> FloatArray:
        """Return how predictions move with the held world.

        Parameters
        ----------
        result : BlockResult

        Returns
        -------
        ndarray, shape (6, n, 3)
            Three shifts [mm per mm], and three turns about the origin [mm/rad].
        """
        # About the world's origin, as the covariance of a registration is stated.
        points = result.state.position_mm
        turns = np.stack([np.cross(axis, points) for axis in np.eye(3)])
        return np.concatenate([np.broadcast_to(np.eye(3)[:, None, :], (3, len(points), 3)), turns])

    def moved_by_growth(self, result: BlockResult, origin_mm: FloatArray) -> FloatArray:
        """Return how far each nest is from the place that stays.

        Parameters
        ----------
        result : BlockResult
        origin_mm : ndarray, shape (3,)
            The place, in the world.

        Returns
        -------
        ndarray, shape (n, 3)
            [mm] per unit of growth.
        """
        return np.asarray(result.state.position_mm - origin_mm)

    def prepared(self) -> Self:
        """Return the block with its whitening computed once."""
        if self.lone_mm2 is not None:
            return replace(self, ready=of_independent(self.lone_mm2 + self.discrepancy**2, self.weights))
        shared = np.broadcast_to(self.scatter_mm * np.eye(3), self.covariance_mm2.shape)
        built = whitener(self._lacking(), self.weights, self.targets.stops.config, shared)
        return replace(self, ready=built)

    def weighted(self, weights: FloatArray, discrepancy: float) -> Self:
        """Return the block with other weights and another discrepancy [mm]."""
        # Once for all steps of a solving: nothing in it depends on the parameters.
        return replace(self, weights=weights, discrepancy=discrepancy, ready=None).prepared()

    def taken(self, rows: IntArray) -> Self:
        """Return the block with some of its readings."""
        return Table.taken(replace(self, ready=None), rows).prepared()

    def _lacking(self) -> FloatArray:
        """Return each reading's covariance with discrepancy, without the arm's scatter, shape (n, 3, 3)."""
        return self.covariance_mm2 + self.discrepancy**2 * np.eye(3)

    def _whitening(self) -> Whitener:
        return self.ready or self.prepared().ready or Whitener((), None)


def position_block(points: PointReadings, scatter_mm: float) -> PositionBlock:
    """Return the block of position readings.

    Parameters
    ----------
    points : PointReadings
        n of them.
    scatter_mm : float
        Of the arm per axis, beside what the readings state.

    Returns
    -------
    PositionBlock
        With the covariance that each reading states, else the same uncertainty along all axes.
    """
    # What a file states in full goes before one number for all axes.
    covariance = points.covariance_mm2
    if covariance is None:
        covariance = points.standard_uncertainty_mm[:, None, None] ** 2 * np.eye(3)
    return PositionBlock(
        targets=Targets(points.stops, points.nest),
        measured_mm=points.position_mm,
        covariance_mm2=covariance,
        scatter_mm=scatter_mm,
        weights=np.ones(len(points)),
        lone_mm2=_lone_mm2(points.stops.config, covariance, scatter_mm),
    ).prepared()


def _lone_mm2(stop: IntArray, covariance_mm2: FloatArray, scatter_mm: float) -> FloatArray | None:
    variance = equal_variance(covariance_mm2)
    # One position a stop, as a tracker reads it: one number whitens each.
    shared = scatter_mm > 0.0 and len(distinct_values(stop)) < len(stop)
    return None if variance is None or shared else variance + scatter_mm**2


_UNSTATED_RAD = 1e-3  # first guess of an orientation's uncertainty; the residuals replace it


@dataclass(frozen=True, slots=True, kw_only=True)
class OrientationBlock(IndependentReadings):
    """Measured orientations of the tool; an uncertainty of 0 is only known from the residuals.

    Attributes
    ----------
    measured : ndarray, shape (n, 3, 3)
        Of the tool in the world.
    """

    quantity: ClassVar[str] = "orientation"
    table: ClassVar[str] = "calibration"
    components: ClassVar[int] = 3

    measured: FloatArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives, parameters as of `ObservationBlock.result`.

        Returns
        -------
        BlockResult
            Residual (n, 3) [rad]: log(M R^T), as a rotation vector in the world.
        """
        state = self.evaluated(structure, values, previous)
        return BlockResult(self._residual(state), self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the turns of the predictions as the residual sees them.

        Parameters
        ----------
        state : State
            At n readings.

        Returns
        -------
        ndarray, shape (P, n, 3)
            rad per internal unit of each parameter.

        References
        ----------
        J. Sola, J. Deray, D. Atchuthan, arXiv 1812.01537, 2018, equation 144.
        """
        # Of large residuals the turn of a prediction is not the change of its rotation vector.
        gradient = _log_gradient(self._residual(state))
        return np.asarray(np.einsum("nij,pnj->pni", gradient, rotation_jacobian(state)))

    def moved_by_world(self, result: BlockResult) -> FloatArray:
        """Return no shift, and three turns, shape (6, n, 3)."""
        # A shift of the world turns nothing.
        turns = np.broadcast_to(np.eye(3)[:, None, :], (3, *result.residual.shape))
        return np.concatenate([np.zeros_like(turns), turns])

    def _residual(self, state: State) -> FloatArray:
        return vector_from_rotation(self.measured @ np.swapaxes(state.orientation, 1, 2))


def _log_gradient(vector: FloatArray) -> FloatArray:
    """Change of log(M P^T) per small turn of P, with its sign: the inverse right Jacobian of SO(3).

    Source: J. Sola, J. Deray, D. Atchuthan, arXiv 1812.01537, 2018, equation 144.
    """
    angle = np.linalg.norm(vector, axis=1)[:, None, None]
    # Below it both terms are large and nearly equal; their limit is 1/12, right to 1e-11.
    safe = np.maximum(angle, 1e-4)
    second = np.where(
        angle > 1e-4, 1.0 / safe**2 - (1.0 + np.cos(safe)) / (2.0 * safe * np.sin(safe)), 1.0 / 12.0
    )
    skew = cross_matrix(vector)
    return np.asarray(np.eye(3) + 0.5 * skew + second * (skew @ skew))


def orientation_block(points: PointReadings) -> OrientationBlock | None:
    """Return the block of orientations.

    Parameters
    ----------
    points : PointReadings
        With quaternions (n, 4), w first.

    Returns
    -------
    OrientationBlock or None
        Uncertainty as stated [rad], the median of the others' where a reading states none; where no reading
        does it is 0 and a discrepancy of 1 mrad the first guess. None where no orientation was measured.
    """
    if points.quaternion is None:
        return None
    stated = points.rotation_uncertainty_rad
    # Residuals tell the scale only where no reading states one: a discrepancy would be added to the others
    # too.
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
