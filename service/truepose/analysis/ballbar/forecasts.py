"""Lengths that an identified model foresees, of every pair of base cup and tool nest, with their covariance.

A cup of a placement that is measured is where the identification found it. A cup that is still to be clamped
is where the identified arm will hold the ball for it, so that later placements are foreseen as well.

The covariance adds up what is known apart: the parameters of the model, cups included; the arm, which comes
to rest a little elsewhere each time and takes all its nests along; the clamping of cups that are not measured
yet; and what the model is known to lack, which is taken as each leg's own.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import BallbarPlan, Leg, PlannedPlacement, PlannedPose, PoseForecast
from truepose.domain.measurement.campaign import Stops
from truepose.domain.results.identification import Model
from truepose.identification.model.estimates import structure_of, values_of
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.planning.ballbar.lengths.aiming import Lengths

_STEP: Final = 1e-2  # of a parameter, in its standard uncertainties: a length is straight over so little
_SMALLEST_STEP: Final = 1e-9  # for a parameter that is known exactly
_HOLDING_NEST: Final = 1  # the setting ball sits in tool nest 1
_TOOL_POINTS: Final = (1, 2, 3)


class Foreseen:
    """A model with the plan whose lengths it foresees."""

    def __init__(self, model: Model, plan: BallbarPlan, kit: BallbarKit) -> None:
        self._model = model
        self._kit = kit
        self._structure = structure_of(model)
        self._values = values_of(model)
        self._anchors = _anchor_indices(model)
        self._placements = {placement.number: placement for placement in plan.placements}

    def lengths_of(self, pose: PlannedPose) -> Lengths:
        """Return the lengths of the legs of a pose, in their order, as a function of the joints (n, J)."""
        cups = self._cups(self._values, self._placements[pose.placement])
        pairs = _pairs(len(cups))
        columns = [pairs.index(leg) for leg in pose.legs]

        def lengths(joints_rad: FloatArray) -> FloatArray:
            return self._between(self._values, joints_rad, cups)[0][:, columns]

        return lengths

    def forecasts(self, poses: Sequence[PlannedPose]) -> tuple[PoseForecast, ...]:
        """Return the lengths of every pair at each of these poses."""
        found = []
        for number, placement in self._placements.items():
            there = [pose for pose in poses if pose.placement == number]
            if there:
                found += self._at(placement, there)
        return tuple(found)

    def _at(self, placement: PlannedPlacement, poses: Sequence[PlannedPose]) -> list[PoseForecast]:
        joints = np.array([pose.joints_rad for pose in poses])
        pairs = _pairs(len(placement.cups_mm))
        length, way = self._between(self._values, joints, self._cups(self._values, placement))
        jacobian = self._jacobian(placement, joints)
        of_model = np.einsum("npi,pq,nqj->nij", jacobian, self._model.covariance, jacobian, optimize=True)
        covariance = of_model + self._of_the_arm(way) + self._of_the_cups(placement, way, pairs)
        covariance += self._model.discrepancy_mm**2 * np.eye(len(pairs))
        return [
            PoseForecast(pose.config, pairs, _tuple(lengths), tuple(_tuple(row) for row in matrix))
            for pose, lengths, matrix in zip(poses, length, covariance, strict=True)
        ]

    def _jacobian(self, placement: PlannedPlacement, joints: FloatArray) -> FloatArray:
        """Return the derivatives of the lengths, shape (n, P, pairs)."""
        uncertain = np.sqrt(np.diag(self._model.covariance))
        steps = np.maximum(_STEP * uncertain, _SMALLEST_STEP)
        columns = [self._slope(placement, joints, number, step) for number, step in enumerate(steps)]
        return np.stack(columns, axis=1)

    def _slope(self, placement: PlannedPlacement, joints: FloatArray, number: int, step: float) -> FloatArray:
        ends = []
        for side in (step, -step):
            values = self._values.copy()
            values[number] += side
            ends.append(self._between(values, joints, self._cups(values, placement))[0])
        return np.asarray((ends[0] - ends[1]) / (2.0 * step))

    def _of_the_arm(self, way: FloatArray) -> FloatArray:
        """Scatter of the arm, the same shift for all legs of a stop, shape (n, pairs, pairs)."""
        return np.asarray(self._model.repeatability_mm**2 * np.einsum("nik,njk->nij", way, way))

    def _of_the_cups(
        self, placement: PlannedPlacement, way: FloatArray, pairs: tuple[Leg, ...]
    ) -> FloatArray:
        """Clamping of cups that no leg was measured from yet; the legs of a cup share it."""
        variance = self._kit.setup_u_mm**2 + self._model.repeatability_mm**2
        base = np.array([cup for cup, _ in pairs])
        unknown = np.array([(placement.number, cup) not in self._anchors for cup in base])
        shared = (base[:, None] == base[None]) & unknown[:, None]
        return np.asarray(variance * shared * np.einsum("nik,njk->nij", way, way))

    def _between(
        self, values: FloatArray, joints: FloatArray, cups: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """Lengths (n, pairs) and directions (n, pairs, 3) from each cup to each nest."""
        nests = self._nests(values, joints, np.array(_TOOL_POINTS))
        way = (nests[:, None] - cups[None, :, None]).reshape(len(joints), -1, 3)
        length = np.linalg.norm(way, axis=2)
        return length, way / length[:, :, None]

    def _cups(self, values: FloatArray, placement: PlannedPlacement) -> FloatArray:
        """Cups (K, 3): as identified, else where the arm will hold the ball, else as planned."""
        held = {setup.base_point: setup.joints_rad for setup in placement.setups}
        cups = np.array(placement.cups_mm, dtype=np.float64)
        for index in range(len(cups)):
            point = index + 1
            anchor = self._anchors.get((placement.number, point))
            if anchor is not None:
                cups[index] = values[list(anchor)]
            elif point in held:
                joints = np.array([held[point]])
                cups[index] = self._nests(values, joints, np.array([_HOLDING_NEST]))[0, 0]
        return cups

    def _nests(self, values: FloatArray, joints: FloatArray, nests: IntArray) -> FloatArray:
        """Positions (n, len(nests), 3) of nests."""
        n = len(joints)
        stops = Stops(np.arange(n * len(nests)), np.repeat(joints, len(nests), axis=0))
        state = evaluate(self._structure, values, Targets(stops, np.tile(nests, n)))
        return np.asarray(state.position_mm.reshape(n, len(nests), 3))


def _anchor_indices(model: Model) -> dict[tuple[int, int], tuple[int, int, int]]:
    """Return which parameters are the coordinates of each cup that the legs found."""
    places = {parameter.name: index for index, parameter in enumerate(model.parameters)}
    found = {}
    for name, index in places.items():
        if name.startswith("anchor_") and name.endswith("_x"):
            _, placement, point, _ = name.split("_")
            y, z = (places[f"anchor_{placement}_{point}_{axis}"] for axis in "yz")
            found[int(placement), int(point)] = (index, y, z)
    return found


def _pairs(n_cups: int) -> tuple[Leg, ...]:
    return tuple((cup, nest) for cup in range(1, n_cups + 1) for nest in _TOOL_POINTS)


def _tuple(values: FloatArray) -> tuple[float, ...]:
    return tuple(float(value) for value in values)
