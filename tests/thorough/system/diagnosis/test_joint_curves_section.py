"""The report on joints that are off by curves: a small campaign held against what is true in its cell."""

import json

import pytest

from tests.studies.diagnosis_report.joint_curves import judged
from truepose.diagnosis.diagnose import diagnose
from truepose.exchange.campaigns.folder import read_campaign


@pytest.fixture(scope="module")
def recorded(recorder, tmp_path_factory):
    """The diagnosis of a campaign of the scenario, the campaign, and its truth."""
    folder = tmp_path_factory.mktemp("curves")
    recorder.record(
        "irb120-curves", "--seed", "7", "--out", str(folder), "--configurations", "300", "--validation", "200"
    )
    campaign = read_campaign(folder)
    return diagnose(campaign), campaign, json.loads((folder / "truth.json").read_text(encoding="utf-8"))


def test_the_joints_are_named_and_no_other_and_unseen_readings_are_met_to_their_noise(recorded):
    found = judged(*recorded)

    assert found.named
    assert 0.9 < found.rms_mm / found.noise_mm < 1.15
    assert found.covered > 0.85


def test_a_curve_of_another_joint_is_not_within_its_band(recorded):
    found, campaign, truth = recorded
    turned = {"joint 1": "joint 2", "joint 2": "joint 3", "joint 3": "joint 1"}
    effects = [{**line, "subject": turned[line["subject"]]} for line in truth["effects"]]

    assert judged(found, campaign, {**truth, "effects": effects}).covered < 0.7
