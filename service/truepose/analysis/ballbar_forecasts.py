"""Ballbar lengths that are predicted, of every pair of base cup and tool nest, with their covariance.

A cup of a placement that is measured is where the identification found it. A cup that is still to be clamped
is where the identified arm will hold the ball for it, so that later placements are foreseen as well.

The covariance adds up what is known apart: the parameters of the model, cups included; the arm, which comes
to rest a little elsewhere each time and takes all its nests along; the clamping of cups that are not measured
yet; and what the model is known to lack, which is taken as each leg's own.

A fit of thirty unknowns to thirty lengths leaves nothing over that could show what its model lacks. The
accounts of the readings know of arms that no model follows, and weigh them by what was read.
"""

from collections.abc import Collection, Sequence
from typing import Final

import numpy as np

from truepose.analysis.campaigns.ballbar import ValidLength, ValidReadings
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import BallbarPlan, Leg, PlannedPlacement, PlannedPose, PoseForecast
from truepose.domain.campaign import Stops
from truepose.domain.cell import BallbarKit
from truepose.domain.identification import Model
from truepose.identification.model.estimates import structure_of, values_of
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.planning.ballbar.length_forecast import SessionForecast
from truepose.planning.ballbar.length_targets import Lengths
from truepose.validation.early_connection_check import Accounts, begin, refuted_stops

_STEP: Final = 1e-2  # of a parameter, in its standard uncertainties: a length is straight over so little
_SMALLEST_STEP: Final = 1e-9  # for a parameter that is known exactly
_HOLDING_NEST: Final = 1  # the setting ball sits in tool nest 1
_TOOL_POINTS: Final = (1, 2, 3)


class LengthForecast:
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
        # A step that is small against what is known of a parameter, and large against rounding.
        uncertain = np.sqrt(np.diag(self._model.covariance))
        steps = np.maximum(_STEP * uncertain, _SMALLEST_STEP)
        columns = [self._slope(placement, joints, number, step) for number, step in enumerate(steps)]
        return np.stack(columns, axis=1)

    def _slope(self, placement: PlannedPlacement, joints: FloatArray, number: int, step: float) -> FloatArray:
        # Central difference (L(p + h) - L(p - h)) / 2h: the first error is of the order h^2, where one side
        # would leave a bias of the order h.
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
        # Variance of a cup along two legs i and j of it: u^2 d_i . d_j. A cup from which legs were measured
        # is a parameter, and its uncertainty is in the covariance of the model.
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
            # From the best known to the least: identified, then where the arm held the ball, then the plan.
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


class EarlyForecast:
    """What all readings of a session say, whichever pairs they are of."""

    def __init__(self, beforehand: SessionForecast, kit: BallbarKit, counting: ValidReadings) -> None:
        self._beforehand = beforehand
        self._stops: list[int | None] = []  # number in the campaign; None: sides
        self._accounts = self._read(begin(beforehand.kinds(), kit), counting)
        weight = np.exp(self._accounts.log_odds)
        self._mean = weight @ self._accounts.mean[:, : beforehand.unknowns]

    @property
    def fitted(self) -> int:
        """Number of what a fit would find: arm and cups."""
        return self._beforehand.fitted

    def refuted(self) -> frozenset[int]:
        """Return the stops of which something else is likelier than what was asked."""
        stops = (self._stops[index] for index in refuted_stops(self._accounts))
        return frozenset(stop for stop in stops if stop is not None)

    def rms_mm(self, counting: ValidReadings) -> float:
        """Return what is left of the legs."""
        squares = []
        for kept in counting.legs:
            stop = self._beforehand.poses(kept.placement, np.array([kept.arrival.commanded_rad]))[0]
            row = stop.pairs.index(kept.leg)
            foreseen = stop.nominal_mm[row] + stop.slope[row] @ self._mean
            squares.append((kept.length.length_mm - foreseen) ** 2)
        return float(np.sqrt(np.mean(squares)))

    def lengths_of(self, pose: PlannedPose) -> Lengths:
        """Return the lengths of the legs of a pose, in their order, as a function of the joints (n, J)."""

        def lengths(joints_rad: FloatArray) -> FloatArray:
            stops = self._beforehand.poses(pose.placement, joints_rad)
            rows = [stops[0].pairs.index(leg) for leg in pose.legs]
            return np.array([stop.nominal_mm[rows] + stop.slope[rows] @ self._mean for stop in stops])

        return lengths

    def forecasts(self, poses: Sequence[PlannedPose]) -> tuple[PoseForecast, ...]:
        """Return the lengths of every pair at each of these poses."""
        return tuple(self._forecast(pose) for pose in poses)

    def _forecast(self, pose: PlannedPose) -> PoseForecast:
        stop = self._beforehand.poses(pose.placement, np.array([pose.joints_rad]))[0]
        length, covariance = self._accounts.at(stop).forecast()
        rows = tuple(tuple(float(value) for value in row) for row in covariance)
        return PoseForecast(pose.config, stop.pairs, tuple(float(value) for value in length), rows)

    def _read(self, accounts: Accounts, counting: ValidReadings) -> Accounts:
        for placement in sorted({kept.placement for kept in counting.legs}):
            accounts = accounts.at(self._beforehand.sides(placement))
            self._stops.append(None)
            for side in counting.sides:
                if side.placement == placement:
                    accounts = accounts.read(side.points, side.length.length_mm)
            for stop in _stops(counting.legs, placement):
                joints = np.array([stop[0].arrival.commanded_rad])
                accounts = accounts.at(self._beforehand.poses(placement, joints)[0])
                self._stops.append(stop[0].stop)
                for kept in stop:
                    accounts = accounts.read(kept.leg, kept.length.length_mm)
        return accounts


def _stops(legs: Collection[ValidLength], placement: int) -> list[list[ValidLength]]:
    """Return the legs of one placement by stop, in the order in which they are listed."""
    found: dict[int, list[ValidLength]] = {}
    for kept in legs:
        if kept.placement == placement:
            found.setdefault(kept.stop, []).append(kept)
    return list(found.values())
