"""`truepose diagnose` as a user types it: document, files, statuses, a sentence for whatever is wrong."""

import json
from dataclasses import replace

import pytest

from tests.helpers.commands import assert_one_sentence, installed
from tests.helpers.commands import typed as truepose
from tests.helpers.identification.synthetic import measured, nominal_campaign
from truepose.domain.campaign import Campaign
from truepose.exchange.campaigns.folder import write_campaign

KEYS = {
    "robot", "verdict", "findings", "before", "after", "held_out", "remaining", "next_measurements", "message"
}  # fmt: skip


def with_gain(campaign: Campaign, joint: int, gain: float) -> Campaign:
    """The campaign of a robot whose joint turned by 1 + gain of what the file says."""
    stops = campaign.calibration.stops
    commanded = stops.joints_rad.copy()
    commanded[:, joint - 1] /= 1.0 + gain
    readings = replace(campaign.calibration, stops=replace(stops, joints_rad=commanded))
    return replace(campaign, calibration=readings)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A robot whose joint 2 turns 1e-3 too far: 0.09 deg at 90 deg, plain against 0.03 mm of noise."""
    calibration, _ = measured(nominal_campaign(60))
    made = tmp_path_factory.mktemp("diagnosed") / "campaign"
    write_campaign(with_gain(calibration, 2, 1e-3), made)
    return made


@pytest.fixture(scope="module")
def done(folder):
    model, report = folder.parent / "extended.json", folder.parent / "diagnosis.html"
    finished = installed("diagnose", folder, "--json", "--model-out", model, "--report", report)
    assert finished.returncode == 0, finished.stderr
    return finished


def test_one_document_names_the_cause(done):
    document = json.loads(done.stdout)

    first = document["findings"][0]
    assert document.keys() >= KEYS
    assert (first["effect"], first["subject"]) == ("joint_gain", "joint 2")
    assert first["amplitude"] == pytest.approx(1e-3, abs=4 * first["amplitude_standard_uncertainty"])


def test_nothing_but_sentences_goes_to_standard_error(done):
    assert "Traceback" not in done.stderr
    assert "\x1b" not in done.stderr  # a bar is for terminals


def test_the_extended_model_predicts(folder, done):
    model = json.loads((folder.parent / "extended.json").read_text())
    files = (folder.parent / "extended.json", folder / "calibration.csv")

    predicted = truepose("predict", *files, "--out", folder.parent / "predicted.csv")

    assert "joint_gain" in model["effects"]
    assert predicted.returncode == 0, predicted.stderr


def test_the_report_stands_alone(folder, done):
    page = (folder.parent / "diagnosis.html").read_text()

    assert json.loads(done.stdout)["message"].split(":")[0] in page
    assert "<script src" not in page


def test_the_first_line_on_a_terminal_is_the_answer(folder, done):
    told = truepose("diagnose", folder)

    assert told.returncode == 0
    said = json.loads(done.stdout)
    assert told.stdout.splitlines()[:2] == [said["outcome"], said["message"]]
    assert "before" in told.stdout


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--effects", "base,geometri"), "Unknown effect 'geometri'"),
        (("--effects", ","), "is empty: give"),
        (("--model-out", "nowhere/extended.json"), "does not exist; create it first"),
    ],
)
def test_what_cannot_be_asked_is_one_sentence(folder, arguments, words):
    assert_one_sentence(truepose("diagnose", folder, *arguments), words)


def test_a_missing_folder_is_named(tmp_path):
    assert_one_sentence(truepose("diagnose", tmp_path / "nowhere", "--json"), "nowhere")


def test_a_campaign_too_small_to_be_fitted_is_answered_with_no(folder, tmp_path):
    few, _ = measured(nominal_campaign(4))
    write_campaign(few, tmp_path / "few")

    told = truepose("diagnose", tmp_path / "few", "--json", "--model-out", tmp_path / "model.json")

    assert told.returncode == 1
    assert json.loads(told.stdout)["before"] is None
    assert not (tmp_path / "model.json").exists()
