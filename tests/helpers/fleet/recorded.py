"""Campaigns of a simulated robot in which nothing ages."""

from tests.studies.fleet.simulated import campaign_of, draw_fleet
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import RecordingRequest


def recorded_campaign(configurations):
    """Record so many calibration configurations of the first robot of a fleet."""
    robot = draw_fleet(1, robots=2, ageing=0).robots[0]
    cell = Cell(robot.scenario(0.0, 0.0), 1, CellClock(0))
    return campaign_of(cell, RecordingRequest(configurations=configurations, validation=0, attachments=1))
