"""A base that drifted or was pushed while it was measured: what the model says of a day and a month later."""

import csv

import numpy as np
import pytest

from tests.helpers.commands import typed
from truepose_simulators.recording.campaign import record
from truepose_simulators.recording.files import write_campaign
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario

HOUR_S = 3600.0
DAY_H, MONTH_H = 24.0, 720.0
BAND = 1.96
PLANTED = """extends = "irb120-tilted"
[[effect]]
name = "{}"
subject = "base"
amplitude = 0.3
from_s = {}
"""


def truepose(*arguments):
    done = typed(*arguments)
    assert done.returncode == 0, done.stderr
    return done


class Measured:
    """A campaign of a cell whose base moved, and the model of its diagnosis."""

    def __init__(self, folder, effect, from_s):
        self._folder = folder
        self._points, self.model = folder / "validation.csv", folder / "model.json"
        scenario = folder / "scenario.toml"
        scenario.write_text(PLANTED.format(effect, from_s), encoding="utf-8")
        recording = record(load_scenario(str(scenario)), 5, RecordingRequest(validation=60), None)
        self._cell, self._stops = recording.cell, recording.validation.stops
        write_campaign(recording, folder)
        self.told = truepose("diagnose", folder, "--model-out", self.model).stdout
        self.last_s = float(self._stops.time_s[-1])

    def true_mm(self, time_s):
        """Where the nests of the held-out stops truly are at another time."""
        stops = self._stops
        times = np.full(len(stops), time_s)
        joints = np.radians(stops.joints_deg)
        conditions = self._cell.conditions(joints, stops.direction, times, stops.attachment)
        return self._cell.true_positions(conditions)[np.arange(len(stops)), stops.nest - 1]

    def predicted(self, time_s):
        """Positions, standard uncertainties and remarks for another time, None for rows without one."""
        asked, out = self._folder / "asked.csv", self._folder / "predicted.csv"
        with self._points.open(encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        with asked.open("w", encoding="utf-8", newline="") as file:
            table = csv.DictWriter(file, rows[0])
            table.writeheader()
            table.writerows(row | {"time_s": "" if time_s is None else time_s} for row in rows)
        remarks = truepose("predict", self.model, asked, "--out", out).stderr
        with out.open(encoding="utf-8") as file:
            found = [
                [float(row[key]) for key in ("x_mm", "y_mm", "z_mm", "u_mm")] for row in csv.DictReader(file)
            ]
        table = np.array(found)
        return table[:, :3], table[:, 3], remarks

    def covered(self, true_mm, time_s):
        """Which share of the coordinates lies in the stated band of 95 %."""
        position, uncertainty, _ = self.predicted(time_s)
        return float(np.mean(np.abs(position - true_mm) <= BAND * uncertainty[:, None]))


@pytest.fixture(scope="module")
def drifting(tmp_path_factory):
    return Measured(tmp_path_factory.mktemp("drifting"), "base_drift", 0.0)


@pytest.fixture(scope="module")
def pushed(tmp_path_factory):
    return Measured(tmp_path_factory.mktemp("pushed"), "base_shift", 1400.0)


@pytest.mark.parametrize("hours", [0.0, DAY_H, MONTH_H])
@pytest.mark.parametrize("goes_on", [True, False])
def test_the_band_holds_a_drift_that_goes_on_and_one_that_stops(drifting, hours, goes_on):
    later_s = drifting.last_s + HOUR_S * hours

    truth = drifting.true_mm(later_s if goes_on else drifting.last_s)

    assert "base drifts by" in drifting.told
    assert drifting.covered(truth, later_s) >= 0.95


def test_a_drift_is_held_and_said_to_be(drifting):
    held, before, nothing = drifting.predicted(drifting.last_s)
    position, after, remarks = drifting.predicted(drifting.last_s + HOUR_S * MONTH_H)

    assert position == pytest.approx(held, abs=1e-3)  # a file has micrometres
    assert np.all(after > 100.0 * before)
    assert nothing == ""
    assert "base_drift was observed only between the first and last readings. 60 of 60 rows" in remarks


@pytest.mark.parametrize("hours", [None, DAY_H, MONTH_H])
def test_a_push_is_past_for_ever_also_where_no_time_is_told(pushed, hours):
    later_s = None if hours is None else pushed.last_s + HOUR_S * hours
    after, before = pushed.true_mm(pushed.last_s), pushed.true_mm(0.0)

    _, uncertainty, _ = pushed.predicted(later_s)

    assert "base jumped" in pushed.told
    assert pushed.covered(after, later_s) >= 0.95
    assert pushed.covered(before, later_s) < 0.5
    assert np.all(uncertainty < 0.05)  # what jumped stands still again
