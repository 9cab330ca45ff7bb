"""Campaigns of a simulated cell with something hidden in it that nothing planted by name can be."""

from truepose.exchange.campaigns.folder import read_campaign
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording.campaign import record_in
from truepose_simulators.recording.files import write_campaign
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario


def recorded(folder, *hidden, seed=11, configurations=100, validation=200):
    """The campaign of a clean cell whose arm also does what the hidden effects say."""
    cell = Cell(load_scenario("irb120-clean"), seed, CellClock(0))
    cell.planted.arm.extend(hidden)
    recording, _ = record_in(cell, RecordingRequest(configurations=configurations, validation=validation))
    write_campaign(recording, folder)
    return read_campaign(folder)
