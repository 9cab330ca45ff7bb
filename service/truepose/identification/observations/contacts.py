"""Contacts as observations: readings against targets of unknown place, and distances between targets.

What a target of a kind reads is in `contact_targets`; with x what effects say that is read too much,

    reading = (what the target reads from the tool's place and turn) + x

Such readings weigh as lengths do (`legs`), the form of the target beside the stated uncertainty.

Certified distances between targets, such as two spheres on a bar of known length: with centres A and B,

    distance = |B - A|

They give a closed loop its scale, which it has from nothing else where the tool itself is not certified
(MasterCal: thesis of A. Nubiola, 2014, section 1.8).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import ClassVar, Self

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.campaign import ContactReadings, Stops, TargetDistances
from truepose.domain.contacts import Target
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot
from truepose.effects.ports import PortKind
from truepose.identification.model.derivatives import excess_mm, position_jacobian, rotation_jacobian
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.structure import Structure, centre_of, indices_of_target
from truepose.identification.observations.blocks import BlockResult, IndependentReadings
from truepose.identification.observations.contact_targets import KINDS, Probe, Slope, sensor_axes
from truepose.identification.observations.legs import LengthBlock
from truepose.kinematics.chain import theta_gradient
from truepose.kinematics.frames import directions


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactBlock(LengthBlock):
    """Readings against targets, whose places are parameters themselves.

    Attributes
    ----------
    target : ndarray of int, shape (n,)
        Index in the structure's targets.
    axis : ndarray of int, shape (n,)
        Of the sensor, NO_AXIS where it has none.
    reading_mm : ndarray, shape (n,)
    """

    table: ClassVar[str] = "contacts"

    target: IntArray
    axis: IntArray
    reading_mm: FloatArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives, parameters as of `Block.result`.

        Returns
        -------
        BlockResult
            Residual (n, 1) [mm]: reading minus what the target reads and what is read too much; with the
            directions (n, 3) and levers (n, J) [mm/rad] along which readings grow.
        """
        state = self.evaluated(structure, values, previous)
        predicted = np.zeros(len(self.reading_mm))
        for target, rows, own, probe in self._each(state):
            predicted[rows] = KINDS[target.kind].reading_mm(target, own, probe)
        residual = (self.reading_mm - predicted - excess_mm(state))[:, None]
        place, turn = self._slopes(state)
        lever = np.einsum("jni,ni->nj", theta_gradient(state.chain, state.position_mm), place)
        # A sensor of the tool turns with each joint besides: its axis swings, wherever its nest is.
        lever += np.einsum("jni,ni->nj", state.chain.z, turn)
        return BlockResult(
            residual, self.differentiated(state), state, self.whitening(place, lever), place, lever
        )

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the predicted readings, the targets' own included.

        Parameters
        ----------
        state : State
            At n readings.

        Returns
        -------
        ndarray, shape (P, n, 1)
            mm per internal unit of each parameter.
        """
        place, turn = self._slopes(state)
        jacobian = np.einsum("pni,ni->pn", position_jacobian(state), place)
        # Only sensors that look along an axis of the tool see it turn: for others the derivatives are saved.
        if turn.any():
            jacobian += np.einsum("pni,ni->pn", rotation_jacobian(state), turn)
        for target, rows, own, probe in self._each(state):
            slope = KINDS[target.kind].slope(target, own, probe)
            jacobian[indices_of_target(state.structure, target), rows] = slope.own
        for term in state.terms:
            if term.port.kind is PortKind.LENGTH:
                jacobian[term.parameter] += term.weight
        return np.asarray(jacobian[:, :, None])

    def ends(self) -> tuple[IntArray, ...]:
        """Return nest, target and axis of each reading."""
        return self.targets.nest, self.target, self.axis

    def moved_by_growth(self, result: BlockResult, origin_mm: FloatArray) -> FloatArray:
        """Return the readings themselves, shape (n, 1): they grow from their zero."""
        return self.reading_mm[:, None]

    def _each(self, state: State) -> Iterator[tuple[Target, IntArray, FloatArray, Probe]]:
        """Yield each target with its readings, the values of its parameters, and where the tool was."""
        probe = Probe(state.position_mm, sensor_axes(state.orientation, self.axis))
        for number, target in enumerate(state.structure.targets):
            rows = np.flatnonzero(self.target == number)
            if rows.size:
                own = state.values[indices_of_target(state.structure, target)]
                yield target, rows, own, probe.taken(rows)

    def _slopes(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Return how the readings change with the tool's place and turn, shape (n, 3) each."""
        place, turn = np.zeros((2, len(self.reading_mm), 3))
        for target, rows, own, probe in self._each(state):
            slope: Slope = KINDS[target.kind].slope(target, own, probe)
            place[rows], turn[rows] = slope.place, slope.turn
        return place, turn


def contact_block(contacts: ContactReadings, scatter_mm: float, targets: tuple[Target, ...]) -> ContactBlock:
    """Return the block of contacts for a structure with these targets.

    Parameters
    ----------
    contacts : ContactReadings
        n of them.
    scatter_mm : float
        Of the arm per axis, beside what the readings state.
    targets : tuple of Target
        Of the structure, in its order.

    Returns
    -------
    ContactBlock
        Uncertainty of each reading: as stated, and the form of its target, squares added.

    Raises
    ------
    ConfigurationError
        A contact is against a target that the structure does not know.
    """
    numbers = [target.number for target in targets]
    missing = sorted(set(contacts.target.tolist()) - set(numbers))
    if missing:
        raise ConfigurationError(
            f"Target {missing[0]} is not among the contacts from which the model was identified."
        )
    index = np.array([numbers.index(number) for number in contacts.target.tolist()])
    # Where on it a target is touched differs from stop to stop: its form is noise, and none of the arm's.
    form_mm = np.array([target.form_mm for target in targets])[index]
    return ContactBlock(
        targets=Targets(contacts.stops, contacts.nest, length_mm=contacts.reading_mm),
        target=index,
        axis=contacts.axes,
        reading_mm=contacts.reading_mm,
        # Readings and form err independently.
        uncertainty_mm=np.hypot(contacts.standard_uncertainty_mm, form_mm),
        scatter_mm=scatter_mm,
        weights=np.ones(len(contacts)),
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class DistanceBlock(IndependentReadings):
    """Certified distances; they are no stops of the arm: joints 0, configurations of their own.

    Attributes
    ----------
    pair : ndarray of int, shape (n, 2)
        Indices in the structure's targets.
    distance_mm : ndarray, shape (n,)
        Between the two centres.
    """

    quantity: ClassVar[str] = "length"
    table: ClassVar[str] = "target_distances"
    components: ClassVar[int] = 1
    # A certificate is never off by what a model of the arm lacks.
    of_arm: ClassVar[bool] = False

    pair: IntArray
    distance_mm: FloatArray

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals and derivatives, parameters as of `Block.result`.

        Returns
        -------
        BlockResult
            Residual (n, 1) [mm]: certified distance minus |B - A|.
        """
        state = self.evaluated(structure, values, previous)
        distance = np.linalg.norm(self._joined(state), axis=1)
        residual = (self.distance_mm - distance)[:, None]
        return BlockResult(residual, self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the distances.

        Parameters
        ----------
        state : State

        Returns
        -------
        ndarray, shape (P, n, 1)
            mm per mm of the centres, zeros for all other parameters.
        """
        # Two centres may start at one place: no direction then, and no division by 0.
        direction, _ = directions(self._joined(state))
        jacobian = np.zeros((len(state.structure.names), len(direction), 1))
        for row, (first, second) in enumerate(self.pair.tolist()):
            for number, sign in ((first, -1.0), (second, 1.0)):
                # The centre comes first among a target's parameters, its zero after it.
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
    # A target that nothing was read against has no place among the parameters.
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
