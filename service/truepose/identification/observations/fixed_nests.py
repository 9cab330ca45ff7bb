"""Readings of fixed nests as observations: they stand still, so that what moves them is the instrument.

A certified place c, off by its own error e, is registered in the world with the error f of a small rigid
motion about the world's origin, and then seen as the instrument sees everything:

    prediction = seen(c + e + shift(f) + turn(f) x (c + e))

The registration is that of the start; of the readings of the arm the base takes it.
"""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.domain.measurement.campaign import Campaign, Stops
from truepose.effects.instruments.fixed_nests import NAME, place_name, reference_specs
from truepose.effects.shapes.rigid_motion import COMPONENTS
from truepose.identification.model.derivatives import seen_jacobian
from truepose.identification.model.evaluation import State, Targets
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.observations.blocks import BlockResult, IndependentReadings
from truepose.identification.observations.looks import Looks
from truepose.kinematics.frames import cross, turned_axes

_FRAME = tuple(f"frame_{component}" for component in COMPONENTS)


@dataclass(frozen=True, slots=True, kw_only=True)
class ReferenceBlock(IndependentReadings):
    """Readings of fixed nests, each a stop of its own that it shares with no configuration of the arm.

    A model that they contradict does not judge them: they judge one another (`looks`). What the world is off
    by is among their own parameters and carries nothing into the others.
    """

    quantity: ClassVar[str] = "position"
    table: ClassVar[str] = "reference"
    components: ClassVar[int] = 3
    of_arm: ClassVar[bool] = False

    fixed_nest: IntArray  # (n,) 1-based
    certified_mm: FloatArray  # (n, 3) place of the nest of each reading
    measured_mm: FloatArray  # (n, 3)

    def result(self, structure: Structure, values: FloatArray, previous: BlockResult | None) -> BlockResult:
        """Return residuals [mm] and derivatives."""
        state = self.evaluated(structure, values, previous)
        residual = self.measured_mm - state.seen(self._registered(state)[0])
        return BlockResult(residual, self.differentiated(state), state, self.whitening())

    def derivatives(self, state: State) -> FloatArray:
        """Return the motions of the predictions, shape (P, n, 3)."""
        names = state.structure.names
        points, turn, axes, arms = self._registered(state)
        jacobian = np.zeros((len(names), len(points), 3))
        for component, name in enumerate(_FRAME):
            if name in names:
                own = np.eye(3)[component] if component < 3 else cross(axes[component - 3], arms)
                jacobian[names.index(name)] = own
        for nest in distinct_values(self.fixed_nest).tolist():
            here = self.fixed_nest == nest
            for component in range(3):
                name = place_name(nest, component)
                if name in names:
                    jacobian[names.index(name), here] = turn[:, component]
        return seen_jacobian(state, points, jacobian)

    def _registered(self, state: State) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
        """Return the places in the world (n, 3), the registration's turn (3, 3), its axes, and its arms."""
        value = dict(zip(state.structure.names, state.values.tolist(), strict=True))
        frame = np.array([value.get(name, 0.0) for name in _FRAME])
        turn, axes = turned_axes(frame[None, 3:])
        errors = {
            nest: [value.get(place_name(nest, component), 0.0) for component in range(3)]
            for nest in distinct_values(self.fixed_nest).tolist()
        }
        places = self.certified_mm + np.array([errors[nest] for nest in self.fixed_nest.tolist()])
        arms = places @ turn[0].T
        return arms + frame[:3], turn[0], axes[:, 0], arms

    def ends(self) -> tuple[IntArray, ...]:
        """Return the fixed nests."""
        return (self.fixed_nest,)

    def own_discrepancy(self) -> float | None:
        """Return by how much looks scatter beyond what is stated, per axis [mm]."""
        return self._looks().discrepancy_mm(self.stated_sigma() ** 2)

    def bad_among(self, off: BoolArray) -> BoolArray:
        """Return which readings that are off the model are bad ones; the others speak against it."""
        return self._looks().bad_among(off)

    def contradiction(self, result: BlockResult) -> float:
        """Return the chance that readings without a bad one lie so far off the model by scatter alone."""
        squared = float((self.weights * self.squared(result)).sum())
        return self._looks().chance_of(squared, 3.0 * float(self.weights.sum()))

    def _looks(self) -> Looks:
        return Looks(self.targets.stops.time_s, self.fixed_nest, self.measured_mm, self.component_variance())


def reference_block(campaign: Campaign) -> ReferenceBlock | None:
    """Return the readings of certified fixed nests; None where the campaign has none."""
    readings = campaign.reference
    if readings is None:
        return None
    certified = np.flatnonzero(
        (readings.fixed_nest >= 1) & (readings.fixed_nest <= len(campaign.fixed_nests))
    )
    if certified.size == 0:
        return None
    nest = readings.fixed_nest[certified]
    places = np.array([fixed.centre_mm for fixed in campaign.fixed_nests])
    stops = Stops(
        config=-1 - certified,
        joints_rad=np.zeros((len(certified), campaign.robot.n_joints)),
        time_s=readings.time_s[certified],
    )
    return ReferenceBlock(
        targets=Targets(stops, np.ones(len(certified), dtype=np.int64), fixed_mm=places[nest - 1]),
        fixed_nest=nest,
        certified_mm=places[nest - 1],
        measured_mm=readings.position_mm[certified],
        uncertainty=readings.standard_uncertainty_mm[certified],
        weights=np.ones(len(certified)),
    )


def with_reference_parameters(
    structure: Structure, start: FloatArray, block: ReferenceBlock, campaign: Campaign
) -> tuple[Structure, FloatArray]:
    """Return structure and start values with the parameters that the readings of fixed nests need."""
    read = distinct_values(block.fixed_nest).tolist()
    specs = reference_specs({k: campaign.fixed_nests[k - 1].standard_uncertainty_mm for k in read})
    return structure.extended(NAME, specs), np.concatenate([start, np.zeros(len(specs))])
