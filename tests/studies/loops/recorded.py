"""Closed loops and tracker campaigns of simulated cells, with where the tool truly was."""

import tempfile
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.loops.held_out import HeldOut, Truth, held_out
from truepose.domain.campaign import Stops
from truepose.exchange.campaigns.folder import read_campaign
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import RecordingRequest, record, write_campaign
from truepose_simulators.recording import Stops as RecordedStops
from truepose_simulators.recording.closed_loop_campaign import LoopRecordingRequest, record_loop, write_loop
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import Scenario

TRACKER: Final = "tracker"  # as many points of it, to compare with


def calibrated(scenario: str, seed: int, kind: str, stops: int) -> HeldOut:
    """Record a loop, or a tracker, calibrate by it, and hold the model against the truth."""
    with tempfile.TemporaryDirectory() as name:
        if kind == TRACKER:
            truth = _tracked(load_scenario(scenario), seed, stops, Path(name))
        else:
            truth = _looped(load_scenario(scenario), seed, LoopRecordingRequest(kind, stops), Path(name))
        campaign = read_campaign(Path(name))
    return held_out(campaign, truth)


def _looped(scenario: Scenario, seed: int, wishes: LoopRecordingRequest, folder: Path) -> Truth:
    recording = record_loop(scenario, seed, wishes)
    write_loop(recording, folder)
    return truth_of(recording.cell, recording.points.stops)


def _tracked(scenario: Scenario, seed: int, stops: int, folder: Path) -> Truth:
    recording = record(scenario, seed, RecordingRequest(configurations=stops, validation=300, attachments=1))
    write_campaign(recording, folder)
    return truth_of(recording.cell, recording.validation.stops)


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
