"""A simulated robot at the stops of a ballbar plan, with lengths by another route than the service's."""

import numpy as np

from tests.studies.simulated_arms import true_nests_mm
from truepose.domain.cell import BallbarKit
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.scenarios.file import load_scenario

KIT = BallbarKit()
RANGE_MM = KIT.range_mm
NOMINAL_MM = KIT.base_bars.nominal_mm
_SCATTER_MM = 0.0035  # of the arm at each stop, per axis
_CLAMP_MM = 0.01
_SNAP_MM = 0.0006
_ZERO_BOUND_MM = 0.003


class TrueRobot:
    """One robot with its cups clamped; every length is what it truly is."""

    def __init__(self, scenario, seed, plan):
        self._cell = Cell(load_scenario(scenario).quiet(), seed, CellClock(0))
        self._rng = np.random.default_rng([seed, 7])
        self._cups = {}
        self._at = {}
        for placement in plan.placements:
            held = self._nests([setup.joints_rad for setup in placement.setups])[:, 0]
            held += np.hypot(_CLAMP_MM, _SCATTER_MM) * self._rng.standard_normal(held.shape)
            for setup, place in zip(placement.setups, held, strict=True):
                self._cups[placement.number, setup.base_point] = place

    def stop(self, pose):
        """True lengths of every pair at one coming to rest of the arm at a pose."""
        key = pose.config, pose.joints_rad
        if key not in self._at:
            nests = self._nests([pose.joints_rad])[0] + _SCATTER_MM * self._rng.standard_normal(3)
            self._at[key] = {
                (cup, nest): float(np.linalg.norm(nests[nest - 1] - place))
                for (placement, cup), place in self._cups.items()
                if placement == pose.placement
                for nest in (1, 2, 3)
            }
        return self._at[key]

    def sides(self, placement):
        """True distances between the cups of a placement."""
        cups = {point: place for (number, point), place in self._cups.items() if number == placement}
        return {(a, b): float(np.linalg.norm(cups[a] - cups[b])) for a in cups for b in cups if a < b}

    def _nests(self, joints_rad):
        return true_nests_mm(self._cell, np.array(joints_rad))


class Gauge:
    """A ballbar whose zero walks with every snap of a magnet."""

    def __init__(self, rng):
        self._rng = rng
        self._zero_mm = 0.0

    def read(self, true_mm):
        """Connect the ballbar and read it."""
        walked = self._zero_mm + _SNAP_MM * self._rng.standard_normal(2).sum()
        self._zero_mm = float(np.clip(walked, -_ZERO_BOUND_MM, _ZERO_BOUND_MM))
        return true_mm + self._zero_mm + KIT.reading_u_mm * self._rng.standard_normal()


def in_range(length_mm):
    """Whether the ballbar reads at all between two balls."""
    return abs(length_mm - NOMINAL_MM) <= RANGE_MM
