"""Closed loops of a simulated LR Mate: recorded by physics of another route, calibrated without a tracker."""

from dataclasses import replace

import numpy as np
import pytest

from tests.studies.loops.recorded import calibrated
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.diagnosis import Verdict
from truepose.domain.identification import Status
from truepose.exchange.campaigns.folder import read_campaign
from truepose.identification import identify
from truepose_simulators.recording.__main__ import main

WAVE = """
extends = "lrmate-tilted"
[[effect]]
name = "joint_harmonics"
subject = "joint 5"
amplitude = 0.03
order = 2
"""


@pytest.mark.parametrize("kind", ["wires", "two-balls"])
def test_a_loop_calibrates_all_over_the_work_volume_as_well_as_it_promises(kind):
    arm = calibrated("lrmate-tilted", 2, kind, 100)

    assert arm.nominal_mm > 0.5
    # The study has 0.011 to 0.023 mm; one arm scatters by half of its promise about it.
    assert arm.mean_mm < 0.05
    assert 0.3 < arm.mean_mm / arm.promised_mm < 2.5
    assert arm.answer.counts.outliers == 0
    first = arm.answer.not_identifiable[0]
    assert first.reason.key == "open.base_of_targets"


def test_one_ball_and_an_unknown_sensor_leave_the_size_of_the_arm_open():
    arm = calibrated("lrmate-tilted", 2, "ball", 60)

    named = {entry.reason.key: entry.parameters for entry in arm.answer.not_identifiable}
    assert {"a_3", "d_4", "target_1_x"} <= set(named["open.size"])
    assert arm.mean_mm < 3.0 * arm.promised_mm  # and what it promises says so
    assert arm.promised_mm > 0.1


def diagnosed(tmp_path, scenario, kind):
    options = ["--seed", "2", "--configurations", "70", "--approach", "mixed", "--out", str(tmp_path / kind)]
    assert main([scenario, "--loop", kind, *options]) == 0
    return diagnose(read_campaign(tmp_path / kind))


def test_a_wave_of_a_gear_is_named_in_a_closed_loop(tmp_path):
    (tmp_path / "wave.toml").write_text(WAVE)

    answer = diagnosed(tmp_path, str(tmp_path / "wave.toml"), "gauges")

    (finding,) = answer.findings
    assert (finding.effect, finding.subject) == ("joint_harmonics", "joint 5")
    assert finding.amplitude == pytest.approx(0.03, abs=4.0 * finding.amplitude_standard_uncertainty)
    assert answer.after.mean_mm < 0.2 * answer.before.mean_mm


def test_where_nothing_is_planted_a_closed_loop_names_nothing(tmp_path):
    answer = diagnosed(tmp_path, "lrmate-tilted", "two-spheres")

    assert answer.findings == ()
    assert answer.verdict is Verdict.CONSISTENT
    assert np.isclose(answer.before.mean_mm, answer.after.mean_mm)


def test_readings_that_slipped_are_found_and_no_others(tmp_path):
    options = ["--seed", "5", "--configurations", "80", "--out", str(tmp_path)]
    assert main(["lrmate-tilted", "--loop", "gauges", *options]) == 0
    campaign = read_campaign(tmp_path)
    slipped = [7, 60, 61, 130, 200]
    reading = campaign.contacts.reading_mm.copy()
    reading[slipped] += [0.3, -0.5, 1.0, 2.0, -0.4]

    answer = identify(replace(campaign, contacts=replace(campaign.contacts, reading_mm=reading)))

    assert [outlier.row for outlier in answer.outliers] == slipped
    assert answer.status is Status.CONVERGED
