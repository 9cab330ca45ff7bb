"""A tracker that knows its place in the world from the fixed nests."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.tracker.accuracy import covariance_mm2, face_error_mm, noise_mm
from truepose_simulators.instruments.tracker.device import seen_from
from truepose_simulators.physics.registration import register
from truepose_simulators.physics.rigid import FloatArray, move

_REGISTRATION_READINGS = 20  # of each fixed nest, before the first stop


@dataclass(frozen=True, slots=True)
class Readings:
    """n readings in the world, as the registered tracker gives them."""

    position_mm: FloatArray  # (n, 3)
    u_mm: FloatArray  # (n,) standard uncertainty per axis that the accuracy model states, RMS of the three


class RegisteredTracker:
    """A tracker that knows its place in the world as well as twenty readings of each fixed nest tell."""

    def __init__(self, cell: Cell, rng: np.random.Generator) -> None:
        self._cell = cell
        self._rng = rng
        nests = cell.fixed_nests_mm()
        start_s = np.zeros(_REGISTRATION_READINGS * len(nests))
        raw = self._raw_mm(np.tile(nests, (_REGISTRATION_READINGS, 1)), start_s)
        means = raw.reshape(_REGISTRATION_READINGS, len(nests), 3).mean(axis=0)
        self._placement = register(means, np.array(cell.scenario.table.fixed_nests_mm))

    def read(self, true_mm: FloatArray, time_s: FloatArray) -> Readings:
        """Read points of the world, shape (n, 3), in the world."""
        raw = self._raw_mm(true_mm, time_s)
        covariance = covariance_mm2(self._cell.scenario.tracker, raw)
        u_mm = np.sqrt(np.trace(covariance, axis1=1, axis2=2) / 3.0)
        return Readings(move(self._placement, raw), u_mm)

    def _raw_mm(self, true_mm: FloatArray, time_s: FloatArray) -> FloatArray:
        """Read points of the world in the tracker's own frame, shape (n, 3)."""
        cell, setup = self._cell, self._cell.scenario.tracker
        seen = seen_from(cell.tracker_frames(time_s), true_mm)
        if cell.scenario.noise:
            seen = seen + face_error_mm(setup, seen, face=1) + noise_mm(setup, seen, self._rng)
        return cell.spoiled(seen, time_s)
