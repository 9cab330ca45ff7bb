"""A probe of six degrees of freedom on the flange, as the tracker and the camera on it see it.

The tracker follows it by itself: what hides it breaks the measurement, and what shows it again ends that.
"""

import math
from dataclasses import dataclass

import numpy as np

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import BeamBrokenError, ScenarioError
from truepose_simulators.faults.kinds import TrackerBlinded
from truepose_simulators.instruments.tracker.accuracy import ProbeSetup, face_error_mm, noise_mm
from truepose_simulators.instruments.tracker.device import seen_from
from truepose_simulators.physics.registration import register
from truepose_simulators.physics.rigid import FloatArray, rotation

_OF_THE_PROBE = 0x6D  # its own chances: those of the other instruments stay as they are


@dataclass(frozen=True, slots=True)
class PoseMeasured:
    """One stationary measurement of the probe, tracker frame."""

    position_mm: FloatArray  # (3,)
    rotation: FloatArray  # (3, 3)
    covariance_mm2: FloatArray  # (3, 3) of the position, by the accuracy model
    rotation_rad: float  # standard deviation about each axis
    turned_away: bool  # farther than its lamps can be seen
    too_far: bool


class Probe:
    """The probe of a cell; knows no protocol."""

    def __init__(self, cell: Cell, setup: ProbeSetup) -> None:
        """Sit on the flange; raises ScenarioError for a tool whose nests make no frame."""
        self._frame_mm = np.array(cell.scenario.tool.nests_mm)
        if len(self._frame_mm) < 3:
            raise ScenarioError(f"[probe]: a tool with {len(self._frame_mm)} nests has no frame: give three")
        self._cell = cell
        self._setup = setup
        self._facing = np.array(setup.facing) / np.linalg.norm(setup.facing)
        self._rng = np.random.default_rng([cell.seed, _OF_THE_PROBE])

    def pose(self) -> FloatArray:
        """Return the probe's frame in the tracker's now, shape (4, 4); raises BeamBrokenError."""
        now_s = self._cell.clock.now_s
        if self._cell.faults.holds(TrackerBlinded, now_s):
            raise BeamBrokenError("the probe no longer returns the beam")
        return register(self._frame_mm, seen_from(self._cell.tracker.frame, self._cell.nests_at_mm(now_s)))

    def measure(self) -> PoseMeasured:
        """Measure the probe as it is now; raises BeamBrokenError."""
        pose = self.pose()
        position_mm, turned = pose[:3, 3], pose[:3, :3]
        tracker = self._cell.tracker
        covariance = tracker.covariance_mm2(position_mm)
        off_rad = self._off_rad(position_mm, turned @ self._facing)
        if self._cell.noise is not None:
            position_mm = position_mm + face_error_mm(tracker.setup, position_mm, tracker.face)
            position_mm = position_mm + noise_mm(tracker.setup, position_mm, self._rng)
            turned = rotation(self._setup.rotation_rad * self._rng.standard_normal(3)) @ turned
        return PoseMeasured(
            position_mm,
            turned,
            covariance,
            self._setup.rotation_rad,
            off_rad > math.radians(self._setup.acceptance_deg),
            float(np.linalg.norm(position_mm)) > self._setup.reach_mm,
        )

    @staticmethod
    def _off_rad(position_mm: FloatArray, facing: FloatArray) -> float:
        towards = -position_mm / np.linalg.norm(position_mm)
        return math.acos(float(np.clip(facing @ towards, -1.0, 1.0)))
