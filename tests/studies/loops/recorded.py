"""Closed loops and tracker campaigns of simulated cells, with where the tool truly was."""

from typing import Final

import numpy as np

from tests.studies.loops.held_out import HeldOut, Truth, held_out
from tests.studies.simulated_arms import read_back
from truepose.domain.campaign import Stops
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import RecordingRequest, record
from truepose_simulators.recording import Stops as RecordedStops
from truepose_simulators.recording.closed_loop_campaign import LoopRecordingRequest, record_loop, write_loop
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import Scenario

TRACKER: Final = "tracker"  # as many points of it, to compare with


def calibrated(scenario: str, seed: int, kind: str, stops: int) -> HeldOut:
    """Record a loop, or a tracker, calibrate by it, and hold the model against the truth."""
    cell = load_scenario(scenario)
    if kind == TRACKER:
        return _tracked(cell, seed, stops)
    return _looped(cell, seed, LoopRecordingRequest(kind, stops))


def _looped(scenario: Scenario, seed: int, wishes: LoopRecordingRequest) -> HeldOut:
    recording = record_loop(scenario, seed, wishes)
    return held_out(read_back(recording, write_loop), truth_of(recording.cell, recording.points.stops))


def _tracked(scenario: Scenario, seed: int, stops: int) -> HeldOut:
    recording = record(scenario, seed, RecordingRequest(configurations=stops, validation=300, attachments=1))
    return held_out(read_back(recording), truth_of(recording.cell, recording.validation.stops))


def truth_of(cell: Cell, stops: RecordedStops) -> Truth:
    """Return where all nests truly were at some stops."""
    joints = np.radians(stops.joints_deg)
    true = cell.true_positions(cell.conditions(joints, stops.direction, stops.time_s, stops.attachment))
    n, nests, _ = true.shape
    rows = np.repeat(np.arange(n), nests)
    return Truth(
        Stops(rows, joints[rows], stops.direction.astype(np.int64)[rows]),
        np.tile(np.arange(1, nests + 1), n),
        true.reshape(-1, 3),
    )
