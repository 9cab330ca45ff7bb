"""Contacts as observations: probes, gauges, wires and sensors read against targets of unknown place."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import ContactReadings
from truepose.domain.measurement.targets import Target
from truepose.effects.ports import PortKind
from truepose.identification.model.derivatives import position_jacobian, rotation_jacobian
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.lengths import excess_mm
from truepose.identification.model.parameters.counterparts import indices_of_target
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import BlockResult
from truepose.identification.observations.contacts.against import Probe, Slope, sensor_axes
from truepose.identification.observations.contacts.kinds import KINDS
from truepose.identification.observations.lengths import LengthBlock
from truepose.kinematics.chain import theta_gradient


@dataclass(frozen=True, slots=True, kw_only=True)
class ContactBlock(LengthBlock):
    """Readings against targets, whose places are parameters themselves."""

    table: ClassVar[str] = "contacts"

    target: IntArray  # (n,) index in the structure's targets
    axis: IntArray  # (n,) of the sensor, NO_AXIS where it has none
    reading_mm: FloatArray  # (n,)

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals [mm] and derivatives."""
        state = self.evaluated(structure, values, previous)
        predicted = np.zeros(len(self.reading_mm))
        for target, rows, own, probe in self._each(state):
            predicted[rows] = KINDS[target.kind].reading_mm(target, own, probe)
        residual = (self.reading_mm - predicted - excess_mm(state))[:, None]
        place, turn = self._slopes(state)
        lever = np.einsum("jni,ni->nj", theta_gradient(state.chain, state.position_mm), place)
        lever += np.einsum("jni,ni->nj", state.chain.z, turn)
        return BlockResult(
            residual, self.differentiated(state), state, self.whitening(place, lever), place, lever
        )

    def derivatives(self, state: State) -> FloatArray:
        """Return the changes of the predicted readings, the targets' own included, shape (P, n, 1)."""
        place, turn = self._slopes(state)
        jacobian = np.einsum("pni,ni->pn", position_jacobian(state), place)
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

    Raises
    ------
    ConfigurationError
        A contact is against a target that the structure does not know.
    """
    numbers = [target.number for target in targets]
    missing = sorted(set(contacts.target.tolist()) - set(numbers))
    if missing:
        raise ConfigurationError(
            f"Target {missing[0]} was not among the contacts that the model was made from."
        )
    index = np.array([numbers.index(number) for number in contacts.target.tolist()])
    form_mm = np.array([target.form_mm for target in targets])[index]
    return ContactBlock(
        targets=Targets(contacts.stops, contacts.nest, length_mm=contacts.reading_mm),
        target=index,
        axis=contacts.axes,
        reading_mm=contacts.reading_mm,
        uncertainty_mm=np.hypot(contacts.standard_uncertainty_mm, form_mm),
        scatter_mm=scatter_mm,
        weights=np.ones(len(contacts)),
    )
