"""Lengths foreseen from a handful of poses, where a fit would claim more than it knows.

A fit of thirty unknowns to thirty lengths leaves nothing over that could show what its model lacks. The
accounts of the readings know of arms that no model follows, and weigh them by what was read.
"""

from collections.abc import Collection, Sequence

import numpy as np

from truepose.analysis.ballbar.assembly import Counting, LegKept
from truepose.domain.arrays import FloatArray
from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.measurement.ballbar import PlannedPose, PoseForecast
from truepose.judgement.ball_pairs.accounts import Accounts, begin
from truepose.judgement.ball_pairs.early import refuted_stops
from truepose.planning.ballbar.lengths.aiming import Lengths
from truepose.planning.ballbar.lengths.beforehand import Beforehand


class EarlyForeseen:
    """What all readings of a session say, whichever pairs they are of."""

    def __init__(self, beforehand: Beforehand, kit: BallbarKit, counting: Counting) -> None:
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

    def rms_mm(self, counting: Counting) -> float:
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

    def _read(self, accounts: Accounts, counting: Counting) -> Accounts:
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


def _stops(legs: Collection[LegKept], placement: int) -> list[list[LegKept]]:
    """Return the legs of one placement by stop, in the order in which they are listed."""
    found: dict[int, list[LegKept]] = {}
    for kept in legs:
        if kept.placement == placement:
            found.setdefault(kept.stop, []).append(kept)
    return list(found.values())
