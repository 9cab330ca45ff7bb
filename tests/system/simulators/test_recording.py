"""Recorded campaign folders, read by the program that they are made for."""

import csv
import json
import subprocess
import sys

import numpy as np
import pytest

from tests.helpers.commands import typed
from truepose.exchange.campaigns.folder import read_campaign
from truepose_simulators.recording import RecordingRequest, record, write_campaign
from truepose_simulators.recording.__main__ import main
from truepose_simulators.scenarios.file import load_scenario


def rows(path):
    with path.open(encoding="utf-8") as file:
        return list(csv.DictReader(file))


def identified(folder):
    return json.loads(typed("identify", folder, "--json").stdout)


def test_a_tilted_robot_is_identified_down_to_the_noise_of_the_readings(tmp_path):
    assert main(["irb120-tilted", "--seed", "4", "--out", str(tmp_path)]) == 0

    document = identified(tmp_path)

    assert document["counts"]["configurations"] == 100
    # 100 readings of three coordinates for 31 parameters: sd of chi2 per degree 0.087, four of these.
    assert document["chi2_per_dof"] == pytest.approx(1.0, abs=0.35)
    held_out = document["statistics"]["validation"]["identified"]
    # Noise alone is 0.026; the parameters add sqrt(31 / 300) of it in quadrature, 5 %.
    assert held_out["mean_mm"] < 0.030


@pytest.mark.parametrize("seed", [1, 4])
def test_an_everyday_robot_keeps_what_a_real_one_keeps(tmp_path, seed):
    main(["irb120-everyday", "--seed", str(seed), "--out", str(tmp_path)])

    held_out = identified(tmp_path)["statistics"]["validation"]["identified"]

    # A. Nubiola, thesis, ETS Montreal 2014, chapter 2: 0.146 and more; seeds differ by some hundredths.
    assert 0.11 < held_out["mean_mm"] < 0.20


def test_the_tables_hold_what_was_recorded(tmp_path):
    recording = record(load_scenario("lrmate-tilted"), 2, RecordingRequest(20, 10, revisits=4))
    write_campaign(recording, tmp_path)

    calibration = rows(tmp_path / "calibration.csv")

    assert list(calibration[0])[:8] == ["config", *(f"q{j}_deg" for j in range(1, 7)), "dir1"]
    assert [row["repeat_of"] for row in calibration][:20] == [""] * 20
    again = calibration[20]
    first = calibration[int(again["repeat_of"]) - 1]
    assert [again[f"q{j}_deg"] for j in range(1, 7)] == [first[f"q{j}_deg"] for j in range(1, 7)]
    position = np.array([[float(row[f"{axis}_mm"]) for axis in "xyz"] for row in calibration])
    assert position == pytest.approx(recording.calibration.readings.position_mm, abs=0.5e-4)  # decimals
    assert len(rows(tmp_path / "validation.csv")) == 10
    assert len(rows(tmp_path / "reference.csv")) == 12  # three nests at stops 1, 11, 21, 31


def test_the_truth_beside_it_says_what_is_planted_and_where_the_nests_were(tmp_path):
    scenario = tmp_path / "geared.toml"
    scenario.write_text(
        'extends = "irb120-clean"\n[[effect]]\nname = "joint_harmonics"\nsubject = "joint 6"\n'
        "amplitude = 0.03\norder = 2\nphase_deg = 10\n"
    )
    main([str(scenario), "--out", str(tmp_path / "out"), "--configurations", "10", "--validation", "3"])

    truth = json.loads((tmp_path / "out" / "truth.json").read_text())

    planted = {"name": "joint_harmonics", "subject": "joint 6", "amplitude": 0.03, "from_s": 0.0}
    assert truth["effects"] == [{**planted, "order": 2, "phase_deg": 10}]
    assert np.shape(truth["true_positions_mm"]["validation"]) == (3, 3)


def test_a_campaign_without_validation_and_references_has_no_such_files(tmp_path):
    main(["irb120-clean", "--out", str(tmp_path), "--validation", "0", "--reference-every", "0"])

    campaign = read_campaign(tmp_path)

    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "calibration.csv",
        "campaign.json",
        "truth.json",
    ]
    assert campaign.validation is None


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["irb6600"], 'no scenario "irb6600"'),
        (["irb120-clean", "--configurations", "0"], '"configurations" must be 1 or more'),
    ],
)
def test_what_cannot_be_recorded_is_said_in_a_sentence(tmp_path, capsys, arguments, sentence):
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 2

    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1


def test_a_folder_that_cannot_be_written_is_said(tmp_path, capsys):
    (tmp_path / "taken").write_text("a file")

    assert main(["irb120-clean", "--out", str(tmp_path / "taken")]) == 2
    assert "cannot be written" in capsys.readouterr().err


def test_the_recorder_is_a_command(tmp_path):
    command = [sys.executable, "-m", "truepose_simulators.recording", "irb120-clean", "--out", str(tmp_path)]

    done = subprocess.run([*command, "--configurations", "12"], capture_output=True, text=True, check=False)

    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    assert len(rows(tmp_path / "calibration.csv")) == 12
