"""Legs as observations: measured lengths from base nests, which are parameters themselves, to tool nests.

With the tool nest at p, the base nest (anchor) at b, the constant c that is added to every length and x what
effects say that a length reads too much,

    length = |p - b| + c + x

What a model of an arm lacks is angles of joints first of all: gears, backlash, couplings. The lengths of a
stop see such an angle together, each at its own lever; a discrepancy of d mm is one of d / 400 mm in every
joint, and besides a part of d in each length by itself, for what is no angle of a joint. With u the stated
uncertainty, s the arm's scatter, e the direction of a length and l_j its lever of joint j, lengths of a stop
have

    cov = diag(u^2 + (0.6 d)^2) + s^2 e . e' + sum over j (d / 400 mm)^2 l_j l_j'

and one that is alone at its stop u^2 + d^2 + s^2. Without the shared part six legs would count as six
witnesses where they are six views of one error (docs/decisions/0017).
"""

from dataclasses import dataclass, replace
from typing import ClassVar

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import LegReadings
from truepose.domain.errors import ConfigurationError
from truepose.identification.model.derivatives import excess_mm, foot_gradient, length_jacobian, moved_feet
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.structure import LEG_OFFSET, Structure, anchor_places, first_anchor
from truepose.identification.observations.blocks import BlockResult, ObservationBlock, Whitener, whitener
from truepose.kinematics.chain import theta_gradient

# Turns a discrepancy in mm, which is what other readings have, into an angle.
_ARM_MM = 400.0
# Shared angles and this part by itself, with triangles that widen certificates, took the mean true error of
# eight robots with several error sources from 0.278 to 0.226 mm (docs/decisions/0017).
_OWN_SHARE = 0.6


@dataclass(frozen=True, slots=True, kw_only=True)
class LengthBlock(ObservationBlock):
    """Lengths; the discrepancy [mm] is at an arm's length from the joints.

    Certified tool nests are parameters too, and what is read against has no known place in the world:
    nothing moves these lengths that is held.

    Attributes
    ----------
    uncertainty_mm : ndarray, shape (n,)
        Standard uncertainty of each, as stated.
    """

    quantity: ClassVar[str] = "length"
    components: ClassVar[int] = 1

    uncertainty_mm: FloatArray

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
        # Directions and levers are those of the result: weights change while the arm stays.
        direction = np.zeros((n, 3)) if result.direction is None else result.direction
        lever = np.zeros((n, joints)) if result.lever_mm is None else result.lever_mm
        return replace(result, whitening=self.whitening(direction, lever))

    def squared(self, result: BlockResult) -> FloatArray:
        """Return each length's squared residual over its variance.

        Parameters
        ----------
        result : BlockResult

        Returns
        -------
        ndarray, shape (n,)
            r^2 / (u^2 + d^2 + s^2), with symbols as above: what a length shares counts as if it were its own.
        """
        return np.asarray(result.residual[:, 0] ** 2 / (self.component_variance() + self.scatter_mm**2))

    def whitening(self, direction: FloatArray, lever_mm: FloatArray) -> Whitener:
        """Return the weights of lengths.

        Parameters
        ----------
        direction : ndarray, shape (n, 3)
            Along which they grow with the tool's place.
        lever_mm : ndarray, shape (n, J)
            By which they grow with the angle of each joint [mm/rad].
        """
        # Alone at its stop a length has nobody to share with: the whole discrepancy is its own.
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


@dataclass(frozen=True, slots=True, kw_only=True)
class LegBlock(LengthBlock):
    """Measured lengths from base nests, which are parameters themselves, to tool nests.

    Attributes
    ----------
    anchor : ndarray of int, shape (n,)
        Index in the structure's anchors.
    length_mm : ndarray, shape (n,)
    """

    table: ClassVar[str] = "legs"

    anchor: IntArray
    length_mm: FloatArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives, parameters as of `ObservationBlock.result`.

        Returns
        -------
        BlockResult
            Residual (n, 1) [mm]: measured length minus distance, offset and what is read too much; with the
            directions (n, 3) and levers (n, J) [mm/rad] along which lengths grow.
        """
        state = self.evaluated(structure, values, previous)
        arm = state.position_mm - moved_feet(state, self._feet(state))
        distance = np.linalg.norm(arm, axis=1)
        direction = arm / distance[:, None]
        # A ballbar whose nominal length is stated reads lengths; others read from an unknown zero.
        offset = values[structure.index_of(LEG_OFFSET)] if LEG_OFFSET in structure.names else 0.0
        residual = (self.length_mm - distance - offset - excess_mm(state))[:, None]
        lever = np.einsum("jni,ni->nj", theta_gradient(state.chain, state.position_mm), direction)
        # Directions and levers of the present arm: what lengths share follows from where it stands.
        whitening = self.whitening(direction, lever)
        return BlockResult(residual, self.differentiated(state), state, whitening, direction, lever)

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the predicted lengths, anchors and offset included.

        Parameters
        ----------
        state : State
            At n legs.

        Returns
        -------
        ndarray, shape (P, n, 1)
            mm per internal unit of each parameter.
        """
        structure, feet = state.structure, self._feet(state)
        arm = state.position_mm - moved_feet(state, feet)
        direction = arm / np.linalg.norm(arm, axis=1)[:, None]
        jacobian = length_jacobian(state, feet)
        rows = np.arange(len(self.anchor))
        first = first_anchor(structure)
        # A base nest counts from where its fixture stood first: it moves along with the turn of the fixture.
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
    """Return where lengths were read, with what effects of ballbar and fixture depend on.

    Parameters
    ----------
    legs : LegReadings
    """
    return Targets(legs.stops, legs.nest, legs.placement, legs.initialisation, legs.length_mm)


def leg_block(legs: LegReadings, scatter_mm: float, anchors: tuple[tuple[int, int], ...]) -> LegBlock:
    """Return the block of leg readings for a structure with these anchors.

    Parameters
    ----------
    legs : LegReadings
        n of them.
    scatter_mm : float
        Of the arm per axis, beside what the readings state.
    anchors : tuple of (placement, base point)
        Of the structure, in its order.

    Raises
    ------
    ConfigurationError
        A leg is from a cup that the structure does not know.
    """
    # Legs that judge are held against the cups of the model, never numbered anew.
    missing = sorted(set(legs.cups) - set(anchors))
    if missing:
        raise ConfigurationError(
            f"Base point {missing[0][1]} of placement {missing[0][0]} is not among the ballbar lengths from "
            "which the model was identified."
        )
    return LegBlock(
        targets=leg_targets(legs),
        anchor=np.array([anchors.index(cup) for cup in legs.cups]),
        length_mm=legs.length_mm,
        uncertainty_mm=legs.standard_uncertainty_mm,
        scatter_mm=scatter_mm,
        weights=np.ones(len(legs)),
    )
