"""The commands on files, as a user types them: documents, exit statuses, a sentence for whatever is wrong."""

import json
import os
import socket
import subprocess
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.commands import TRUEPOSE, installed
from tests.helpers.commands import typed as truepose
from tests.helpers.domain.lost_visit import cycle_stops, planned_poses
from tests.helpers.exchange.rows import read_rows, write_rows
from tests.helpers.identification.synthetic import configurations
from truepose.domain.campaign import PointReadings
from truepose.exchange.campaigns.folder import write_campaign
from truepose.exchange.models.file import read_model
from truepose.exchange.tables.points import point_text
from truepose.identification import predict
from truepose.version import __version__ as truepose_version

COMMANDS = ("demo", "serve", "simulate", "identify", "diagnose", "predict", "validate", "nightly")
STATISTICS = {"n", "mean_mm", "rms_mm", "sd_mm", "max_mm", "noise_mm"}


def test_identify_prints_one_document_with_the_promised_keys(good):
    document = json.loads((good / "identify.json").read_text())

    assert {
        "robot", "status", "message", "effects", "counts", "parameters", "not_identifiable",
        "outliers", "statistics", "chi2_per_dof",
    } <= set(document)  # fmt: skip
    assert document["status"] == "converged"
    assert set(document["counts"]) == {"configurations", "observations", "parameters", "outliers"}
    assert document["counts"] == {"configurations": 45, "observations": 135, "parameters": 31, "outliers": 0}
    assert {"name", "effect", "value", "unit", "standard_uncertainty"} <= set(document["parameters"][0])
    units = {parameter["name"]: parameter["unit"] for parameter in document["parameters"]}
    assert (units["base_x"], units["base_rz"], units["alpha_2"], units["c_2"]) == (
        "mm", "deg", "deg", "rad/(N*mm)",
    )  # fmt: skip
    for block in ("calibration", "validation"):
        for model in ("nominal", "identified"):
            assert set(document["statistics"][block][model]) == STATISTICS
    assert "cross_validation" not in document["statistics"]
    assert document["quantity"] == "position"


def test_without_a_validation_file_cross_validation_stands_in_its_place(campaign, tmp_path):
    write_campaign(replace(campaign, validation=None), tmp_path)

    document = json.loads(truepose("identify", tmp_path, "--json").stdout)

    assert set(document["statistics"]["cross_validation"]["identified"]) == STATISTICS
    assert "validation" not in document["statistics"]


def test_the_table_of_an_identification_names_the_figures(good):
    done = truepose("identify", good / "campaign")

    assert done.returncode == 0
    assert "Converged" in done.stdout and "identified" in done.stdout
    assert done.stderr == ""


def test_validate_prints_positions_and_distances_and_passes(good):
    done = installed("validate", good / "model.json", good / "campaign" / "validation.csv", "--json")

    document = json.loads(done.stdout)
    assert done.returncode == 0
    assert document["pass"] is True
    for block in ("position", "distance"):
        for model in ("nominal", "identified"):
            assert set(document[block][model]) == STATISTICS
    assert document["distance"]["identified"]["n"] == 40 * 39 // 2
    stated = json.loads((good / "identify.json").read_text())["statistics"]["validation"]["identified"]
    assert document["position"]["identified"]["rms_mm"] == pytest.approx(stated["rms_mm"], rel=1e-9)


@pytest.mark.parametrize(("limit", "status"), [("0.5", 0), ("0.001", 1)])
def test_validate_judges_by_the_limit(good, limit, status):
    arguments = ("validate", good / "model.json", good / "campaign" / "validation.csv", "--limit-mm", limit)

    document = truepose(*arguments, "--json")
    table = truepose(*arguments)

    assert (document.returncode, table.returncode) == (status, status)
    assert json.loads(document.stdout)["pass"] is (status == 0)


def cycles_file(good, file, lost=None):
    """Thirty cycles of five poses and ten other configurations, as a robot that is its model attains them."""
    model = read_model(good / "model.json")
    poses = planned_poses(model.robot, model.nests[0].centre_mm)
    known = cycle_stops(poses, lost, configurations(10, seed=4))
    nest = np.ones(len(known), dtype=np.int64)
    places, _ = predict(model, known, nest)
    scattered = places + 0.01 * np.random.default_rng(3).standard_normal(places.shape)
    file.write_text(point_text(PointReadings(known, nest, scattered, np.full(len(known), 0.01))))
    return file


def test_validate_adds_the_figures_of_iso_9283(good, tmp_path):
    points = cycles_file(good, tmp_path / "cycles.csv", lost=8)  # P3 in the second cycle
    page = tmp_path / "accuracy.html"

    done = truepose(
        "validate", good / "model.json", points, "--iso9283", "--report", page, "--load", "3 kg", "--json"
    )

    assert (done.returncode, done.stderr) == (0, "")
    test = json.loads(done.stdout)["iso9283"]
    assert (test["poses"], test["cycles"], test["work_space"]["identified"]["n"]) == (5, 30, 10)
    assert [w["reason"] for w in test["withheld"] if w["symbol"] == "RP"] == [
        "P3 was measured in 29 cycles (cycle 2 is missing); ISO 9283 requires 30, "
        "and missing cycles are not filled in"
    ]
    repeatability = {f["subject"]: f["value"] for f in test["figures"] if f["symbol"] == "RP"}
    # 3.6 standard deviations of a radius of three normal components, known from 30 visits to some 10 %
    assert repeatability == pytest.approx(dict.fromkeys(("P1", "P2", "P4", "P5"), 0.036), rel=0.4)
    assert test["sentence"].startswith("Five poses do not prove accuracy in a workspace")
    assert "3 kg" in page.read_text()


@pytest.mark.parametrize(("rule", "verdict"), [("guard-band", "cannot be decided"), ("simple", "conforms")])
def test_validate_decides_by_the_rule_that_is_named(good, rule, verdict):
    points = good / "campaign" / "validation.csv"
    largest = json.loads(truepose("validate", good / "model.json", points, "--json").stdout)
    limit = largest["position"]["identified"]["max_mm"] * 1.01
    arguments = ("--limit-mm", limit, "--decision-rule", rule, "--json")

    document = json.loads(truepose("validate", good / "model.json", points, *arguments).stdout)

    assert document["pass"] is True
    assert document["decision"]["verdict"] == verdict
    assert document["decision"]["rule"] == rule.replace("-", " ")
    assert largest["decision"] is None


def test_predict_answers_in_the_order_of_the_input(good, tmp_path):
    rows = [
        {"config": str(config), **{f"q{j}_deg": str(10.0 * j - config) for j in range(1, 7)}, "nest": nest}
        for config, nest in ((7, "2"), (3, "1"), (5, "3"))
    ]
    write_rows(tmp_path / "points.csv", rows)

    done = installed("predict", good / "model.json", tmp_path / "points.csv", "--out", tmp_path / "out.csv")

    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
    answers = read_rows(tmp_path / "out.csv")
    assert list(answers[0]) == ["config", "nest", "x_mm", "y_mm", "z_mm", "u_mm"]
    assert [(row["config"], row["nest"]) for row in answers] == [("7", "2"), ("3", "1"), ("5", "3")]
    assert all(0.0 < float(row["u_mm"]) < 0.1 for row in answers)


def test_what_cannot_be_predicted_of_a_row_is_said_beside_the_predictions(campaign, tmp_path):
    n = len(campaign.calibration)
    stops = replace(campaign.calibration.stops, time_s=60.0 * np.arange(n))
    timed = replace(campaign, calibration=replace(campaign.calibration, stops=stops), validation=None)
    write_campaign(timed, tmp_path / "campaign")
    truepose(
        "identify", tmp_path / "campaign", "--effects", "base,geometry,compliance,base_drift",
        "--model-out", tmp_path / "model.json",
    )  # fmt: skip
    rows = read_rows(tmp_path / "campaign" / "calibration.csv")[:5]
    for row in rows:
        del row["time_s"]
    write_rows(tmp_path / "points.csv", rows)

    files = (tmp_path / "model.json", tmp_path / "points.csv")
    predicted = truepose("predict", *files, "--out", tmp_path / "out.csv")
    french = truepose("predict", *files, "--out", tmp_path / "out.csv", "--language", "fr")
    validated = truepose("validate", *files, "--json")

    sentence = (
        "base_drift needs time_s, which 5 of 5 rows lack: "
        "these rows are treated as later than the last reading"
    )
    assert sentence in predicted.stderr
    assert "time_s" in french.stderr
    assert sentence not in french.stderr
    assert len(read_rows(tmp_path / "out.csv")) == 5
    assert sentence in validated.stderr
    assert set(json.loads(validated.stdout)["position"]) == {"nominal", "identified"}


def test_predict_without_nests_gives_every_nest_of_every_row(good, tmp_path):
    write_rows(tmp_path / "points.csv", [{"config": 1, **{f"q{j}_deg": 5 for j in range(1, 7)}}])

    truepose("predict", good / "model.json", tmp_path / "points.csv", "--out", tmp_path / "out.csv")

    assert [row["nest"] for row in read_rows(tmp_path / "out.csv")] == ["1", "2", "3"]


def test_the_program_says_its_version():
    done = truepose("--version")

    assert (done.returncode, done.stdout, done.stderr) == (0, f"truepose {truepose_version}\n", "")


@pytest.mark.parametrize(
    ("typed", "offered"), [("truepose di", "diagnose"), ("truepose identify --mo", "--model-out")]
)
def test_a_shell_is_told_how_a_word_may_end(typed, offered):
    words = len(typed.split()) - 1
    asked = {"_TRUEPOSE_COMPLETE": "complete_bash", "COMP_WORDS": typed, "COMP_CWORD": str(words)}

    done = subprocess.run(
        [str(TRUEPOSE)], env={**os.environ, **asked}, capture_output=True, text=True, timeout=180, check=False
    )

    assert done.stdout.split() == [offered]


@pytest.mark.parametrize("command", COMMANDS)
def test_help_shows_an_example(command):
    done = truepose(command, "--help")

    assert done.returncode == 0
    assert f"Example: truepose {command}" in " ".join(done.stdout.split())


def test_a_reader_that_has_had_enough_ends_nothing_with_a_traceback(good):
    reading, writing = os.pipe()
    os.close(reading)
    command = [str(TRUEPOSE), "identify", str(good / "campaign"), "--json"]
    with os.fdopen(writing, "w") as closed:
        done = subprocess.run(
            command, stdout=closed, stderr=subprocess.PIPE, text=True, timeout=120, check=False
        )

    assert (done.returncode, done.stderr) == (0, "")


def test_a_simulated_cell_ends_with_the_command_that_started_it():
    command = [str(TRUEPOSE), "simulate", "irb120-clean", "--seed", "3", "--pace", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        first = json.loads(process.stdout.readline())
        with socket.create_connection((first["host"], first["port"]), timeout=5):
            pass
        process.terminate()
        process.wait(timeout=60)

    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((first["host"], first["port"]), timeout=5)
