"""A measured campaign without any wire: the cell is asked directly, for all stops at once.

The same plant, effects, tracker noise, registration on the fixed nests and repeatability as behind the
protocols, a thousand times faster.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.accuracy import covariance_mm2, face_error_mm, noise_mm
from truepose_simulators.instruments.tracker import in_tracker_frame
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.identified import IdentifiedModel
from truepose_simulators.physics.rigid import FloatArray, move, register
from truepose_simulators.recording.plan import RecordingRequest, Stops, plan_stops
from truepose_simulators.recording.rows import Rows
from truepose_simulators.scenarios.scenario import Scenario

_REGISTRATION_READINGS = 20  # of each fixed nest, before the first stop


@dataclass(frozen=True, slots=True)
class Readings(Rows):
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
        seen = in_tracker_frame(cell.tracker_frames(time_s), true_mm)
        if cell.scenario.noise:
            seen = seen + face_error_mm(setup, seen, face=1) + noise_mm(setup, seen, self._rng)
        return cell.spoiled(seen, time_s)


_PLAN_STREAM, _NOISE_STREAM = 100, 101  # of random numbers, apart from those of the cell


@dataclass(frozen=True, slots=True)
class Points(Rows):
    """Stops with what was read there."""

    stops: Stops
    nest: NestNumbers  # (n,) as written down
    temperature_c: FloatArray  # (n,) as sensed
    readings: Readings
    true_mm: FloatArray  # (n, 3) the nest truly there, without noise and scatter


@dataclass(frozen=True, slots=True)
class References:
    """Readings of the fixed nests now and then."""

    time_s: FloatArray  # (m,)
    fixed_nest: NestNumbers  # (m,) 1-based
    readings: Readings


@dataclass(frozen=True, slots=True)
class Recording:
    """One campaign and the cell that it was recorded in."""

    cell: Cell
    calibration: Points
    validation: Points
    references: References


def record(
    scenario: Scenario, seed: int, wishes: RecordingRequest, model: IdentifiedModel | None = None
) -> Recording:
    """Record a campaign of the cell that scenario, seed and perhaps an identified model give.

    The same scenario, seed and wishes give the same campaign.

    Raises
    ------
    SimulatorError
        The cell cannot be, or its tracker sees too few configurations.
    """
    return record_in(Cell(scenario, seed, CellClock(0), model), wishes)[0]


def record_in(
    cell: Cell, wishes: RecordingRequest, start_s: float = 0.0
) -> tuple[Recording, RegisteredTracker]:
    """Record a campaign in a cell from a cell time on; the tracker stays for further readings.

    Raises
    ------
    NoStopsError
        The cell's tracker sees too few configurations.
    """
    stops = plan_stops(cell, wishes, _generator(cell, _PLAN_STREAM))
    return record_at(cell, replace(stops, time_s=stops.time_s + start_s), wishes)


def record_at(cell: Cell, stops: Stops, wishes: RecordingRequest) -> tuple[Recording, RegisteredTracker]:
    """Record a campaign at given stops, as many of which calibrate as `wishes` says; all else as above."""
    noise_rng = _generator(cell, _NOISE_STREAM)
    tracker = RegisteredTracker(cell, noise_rng)
    points = _read_points(cell, stops, tracker, noise_rng)
    n_calibration = wishes.configurations + wishes.revisits
    recording = Recording(
        cell=cell,
        calibration=points.part(slice(n_calibration)),
        validation=points.part(slice(n_calibration, None)),
        references=_read_references(cell, stops.time_s, wishes.reference_every, tracker),
    )
    return recording, tracker


def _generator(cell: Cell, stream: int) -> np.random.Generator:
    return np.random.default_rng(np.random.SeedSequence(cell.seed, spawn_key=(stream,)))


def _read_points(cell: Cell, stops: Stops, tracker: RegisteredTracker, rng: np.random.Generator) -> Points:
    conditions = stops.conditions(cell)
    n = len(stops)
    true = cell.true_positions(conditions)[np.arange(n), stops.nest - 1]
    scatter, sensor = (
        (cell.scenario.arm.scatter_mm, cell.scenario.air.sensor_noise_k)
        if cell.scenario.noise
        else (0.0, 0.0)
    )
    return Points(
        stops=stops,
        nest=cell.nests_read(stops.nest, stops.time_s),
        temperature_c=conditions.temperature_c + sensor * rng.standard_normal(n),
        readings=tracker.read(true + scatter * rng.standard_normal((n, 3)), stops.time_s),
        true_mm=true,
    )


def _read_references(cell: Cell, time_s: FloatArray, every: int, tracker: RegisteredTracker) -> References:
    times = time_s[::every] if every else time_s[:0]
    nests = cell.fixed_nests_mm()
    numbers = np.tile(np.arange(1, len(nests) + 1), len(times))
    each = np.repeat(times, len(nests))
    return References(each, numbers, tracker.read(nests[numbers - 1], each))
