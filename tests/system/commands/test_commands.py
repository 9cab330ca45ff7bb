"""The commands on files, as a user types them: documents, exit statuses, a sentence for whatever is wrong."""

import csv
import json
import math
import os
import socket
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.helpers.commands import TRUEPOSE, installed
from tests.helpers.commands import typed as truepose
from tests.helpers.identification.synthetic import configurations, measured, nominal_campaign
from truepose.domain.campaign import PointReadings, Stops
from truepose.exchange.campaigns.folder import write_campaign
from truepose.exchange.models.file import read_model
from truepose.exchange.tables.points import point_text
from truepose.identification import predict
from truepose.validation.iso9283.plan import Cube, plan_poses
from truepose.version import __version__ as truepose_version

COMMANDS = ("demo", "serve", "simulate", "identify", "diagnose", "predict", "validate", "nightly")
STATISTICS = {"n", "mean_mm", "rms_mm", "sd_mm", "max_mm", "noise_mm"}


@pytest.fixture(scope="module")
def campaign():
    calibration, truth = measured(nominal_campaign(45))
    fresh = nominal_campaign(40, seed=9)
    held_out, _ = measured(fresh, np.array(list(truth.values.values())), seed=31)
    return replace(calibration, validation=held_out.calibration)


@pytest.fixture(scope="module")
def good(campaign, tmp_path_factory):
    """A campaign folder and the model that `identify` makes of it."""
    folder = tmp_path_factory.mktemp("good")
    write_campaign(campaign, folder / "campaign")
    done = installed("identify", folder / "campaign", "--model-out", folder / "model.json", "--json")
    assert done.returncode == 0, done.stderr
    (folder / "identify.json").write_text(done.stdout)
    return folder


@pytest.fixture
def folder(campaign, tmp_path):
    """A campaign folder of one's own, to be spoilt."""
    write_campaign(campaign, tmp_path / "campaign")
    return tmp_path / "campaign"


def rows_of(file):
    with file.open(newline="") as text:
        return list(csv.DictReader(text))


def write_rows(file, rows):
    with file.open("w", newline="") as text:
        writer = csv.DictWriter(text, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)


def calibration_file(folder):
    return folder / json.loads((folder / "campaign.json").read_text())["files"]["calibration"]


def spoil(folder, change):
    """Rewrite the calibration rows with `change(rows)`, which may return others."""
    file = calibration_file(folder)
    rows = rows_of(file)
    write_rows(file, change(rows) or rows)


def assert_one_sentence(done, *words, status=2):
    assert done.returncode == status, done.stderr
    assert "Traceback" not in done.stderr + done.stdout
    lines = [line for line in done.stderr.splitlines() if line.strip()]
    assert len(lines) == 1, done.stderr
    for word in words:
        assert word in lines[0]
    assert done.stdout == ""


def verdict_of(done):
    """The document of an identification that ended with `no`."""
    assert done.returncode == 1, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return json.loads(done.stdout)


# What scripts rely on


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


def test_without_a_validation_file_cross_validation_stands_in_its_place(folder):
    description = json.loads((folder / "campaign.json").read_text())
    del description["files"]["validation"]
    (folder / "campaign.json").write_text(json.dumps(description))

    document = json.loads(truepose("identify", folder, "--json").stdout)

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


@pytest.mark.parametrize("limit", ["nan", "0", "-1", "inf"])
def test_a_limit_that_judges_nothing_is_refused(good, limit):
    arguments = (good / "model.json", good / "campaign" / "validation.csv", f"--limit-mm={limit}", "--json")

    assert_one_sentence(truepose("validate", *arguments), "--limit-mm", "above 0 mm")


def cycles_file(good, file, lost=None):
    """Thirty cycles of five poses and ten other configurations, as a robot that is its model attains them."""
    model = read_model(good / "model.json")
    down = np.diag([1.0, -1.0, -1.0])
    plan = plan_poses(model.robot, Cube((300.0, 0.0, 250.0), 150.0), down, model.nests[0].centre_mm)
    stops = [stop for stop in plan.session(nest=1).stops if stop.config != lost]
    joints = np.vstack([[stop.joints_rad for stop in stops], configurations(10, seed=4)])
    config = [*(stop.config for stop in stops), *range(201, 211)]
    repeat_of = [*(-1 if stop.repeat_of is None else stop.repeat_of for stop in stops), *[-1] * 10]
    nest = np.ones(len(joints), dtype=np.int64)
    known = Stops(np.array(config), joints, repeat_of=np.array(repeat_of))
    places, _ = predict(model, known, nest)
    scattered = places + 0.01 * np.random.default_rng(3).standard_normal(places.shape)
    file.write_text(point_text(PointReadings(known, nest, scattered, np.full(len(joints), 0.01))))
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


def test_points_without_cycles_are_no_test_of_iso_9283(good):
    points = good / "campaign" / "validation.csv"

    done = truepose("validate", good / "model.json", points, "--iso9283", "--json")

    assert_one_sentence(done, "holds no pose that was visited again and again", "repeat_of")


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
    answers = rows_of(tmp_path / "out.csv")
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
    rows = rows_of(calibration_file(tmp_path / "campaign"))[:5]
    for row in rows:
        del row["time_s"]
    write_rows(tmp_path / "points.csv", rows)

    predicted = truepose(
        "predict", tmp_path / "model.json", tmp_path / "points.csv", "--out", tmp_path / "out.csv"
    )
    french = truepose(
        "predict", tmp_path / "model.json", tmp_path / "points.csv", "--out", tmp_path / "out.csv",
        "--language", "fr",
    )  # fmt: skip
    validated = truepose("validate", tmp_path / "model.json", tmp_path / "points.csv", "--json")

    sentence = (
        "base_drift needs time_s, which 5 of 5 rows lack: "
        "for these rows it is taken as after the last reading"
    )
    assert sentence in predicted.stderr
    assert "time_s" in french.stderr
    assert sentence not in french.stderr
    assert len(rows_of(tmp_path / "out.csv")) == 5
    assert sentence in validated.stderr
    assert set(json.loads(validated.stdout)["position"]) == {"nominal", "identified"}


def test_predict_without_nests_gives_every_nest_of_every_row(good, tmp_path):
    write_rows(tmp_path / "points.csv", [{"config": 1, **{f"q{j}_deg": 5 for j in range(1, 7)}}])

    truepose("predict", good / "model.json", tmp_path / "points.csv", "--out", tmp_path / "out.csv")

    assert [row["nest"] for row in rows_of(tmp_path / "out.csv")] == ["1", "2", "3"]


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
        [str(TRUEPOSE)], env={**os.environ, **asked}, capture_output=True, text=True, timeout=60, check=False
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


# Bad input: the table


def put(row, column, value):
    def change(rows):
        rows[row][column] = value

    return change


def renamed(old, new):
    return lambda rows: [{new if name == old else name: value for name, value in row.items()} for row in rows]


def without(column):
    return lambda rows: [{name: value for name, value in row.items() if name != column} for row in rows]


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (without("q3_deg"), ("q3_deg",)),
        (renamed("q3_deg", "joint3"), ("q3_deg",)),
        (renamed("q3_deg", "q3_rad"), ("q3_rad", "deg")),
        (renamed("x_mm", "x_m"), ("x_m", "mm")),
        (put(4, "x_mm", "nan"), ("line 6", "x_mm")),
        (put(4, "x_mm", "inf"), ("line 6", "x_mm")),
        (put(4, "y_mm", "twelve"), ("line 6", "y_mm", "twelve")),
        (put(4, "y_mm", "12,5"), ("line 6", "y_mm")),
        (put(4, "u_mm", "0"), ("line 6", "u_mm")),
        (put(4, "nest", "7"), ("line 6", "nest")),
        (put(4, "config", ""), ("line 6", "config")),
    ],
    ids=[
        "missing column", "wrong column", "joints in rad", "positions in m", "NaN", "infinite",
        "text", "decimal comma", "no uncertainty", "unknown nest", "empty",
    ],
)  # fmt: skip
def test_a_bad_table_is_one_sentence_with_file_line_and_column(folder, change, words):
    spoil(folder, change)

    done = truepose("identify", folder, "--json")

    assert_one_sentence(done, "calibration.csv", *words)


def test_a_missing_file_is_named(folder):
    calibration_file(folder).unlink()

    assert_one_sentence(installed("identify", folder), "calibration.csv")


def test_a_missing_folder_is_named(tmp_path):
    assert_one_sentence(truepose("identify", tmp_path / "nowhere"), "nowhere")


def test_a_campaign_with_validation_alone_has_nothing_to_identify_from(folder):
    description = json.loads((folder / "campaign.json").read_text())
    del description["files"]["calibration"]
    (folder / "campaign.json").write_text(json.dumps(description))

    assert_one_sentence(truepose("identify", folder, "--json"), "calibration")


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"format": "something else"}'])
def test_a_description_that_is_none_is_refused(folder, text):
    (folder / "campaign.json").write_text(text)

    assert_one_sentence(truepose("identify", folder), "campaign.json")


def test_an_unknown_effect_lists_the_known_ones(folder):
    done = truepose("identify", folder, "--effects", "base,magic")

    assert_one_sentence(done, "'magic'", "base, tool, geometry", "compliance")


@pytest.mark.parametrize(
    ("effects", "words"),
    [
        (",", "auto"),
        ("geometry,joint_offset", "leave one of the two out"),
        ("base,base", "is named twice: name it once"),
    ],
)
def test_effects_that_make_no_model_are_refused(folder, effects, words):
    assert_one_sentence(truepose("identify", folder, "--effects", effects), words)


# Bad input: readings that parse and cannot be meant


def scaled(columns, factor):
    def change(rows):
        for row in rows:
            for column in columns:
                row[column] = repr(float(row[column]) * factor)

    return change


def all_equal(rows):
    return [rows[0] | {"config": row["config"]} for row in rows]


JOINTS = [f"q{joint}_deg" for joint in range(1, 7)]


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        (lambda rows: rows[:3], "too_few_data", "3 different configurations"),
        (
            lambda rows: [rows[0] | {"config": row["config"]} for row in rows],
            "too_few_data",
            "one configuration",
        ),
        (scaled(JOINTS, math.pi / 180.0), "wrong_nominal_model", "radians"),
        (scaled(["x_mm", "y_mm", "z_mm"], 1e-3), "wrong_nominal_model", "metres"),
        (scaled(["y_mm"], -1.0), "wrong_nominal_model", "left-handed"),
    ],
    ids=["three", "all equal", "radians", "metres", "left-handed"],
)
def test_readings_that_cannot_be_meant_are_answered_with_the_reason(folder, change, status, words):
    spoil(folder, change)

    done = truepose("identify", folder, "--json", "--model-out", folder / "model.json")

    document = verdict_of(done)
    assert document["status"] == status
    assert words in document["message"]
    assert not (folder / "model.json").exists()
    assert "No model was written" in done.stderr


def test_a_table_without_lengths_is_another_robot_s(folder):
    description = json.loads((folder / "campaign.json").read_text())
    for row in description["dhm_nominal"]:
        row.update(alpha_deg=0.0, a_mm=0.0, d_mm=0.0)
    (folder / "campaign.json").write_text(json.dumps(description))

    done = truepose("identify", folder, "--json")

    assert verdict_of(done)["status"] == "wrong_nominal_model"
    assert "Warning" not in done.stderr


def test_gravity_that_points_upwards_is_said(folder):
    description = json.loads((folder / "campaign.json").read_text())
    description["gravity_m_s2_world"] = [0.0, 0.0, 9.81]
    (folder / "campaign.json").write_text(json.dumps(description))

    document = json.loads(truepose("identify", folder, "--json").stdout)

    assert (
        "came out negative, which is impossible for a spring: check the direction of gravity"
        in document["message"]
    )


def test_two_exchanged_rows_are_listed(folder):
    def exchange(rows):
        for column in ("x_mm", "y_mm", "z_mm"):
            rows[6][column], rows[18][column] = rows[18][column], rows[6][column]

    spoil(folder, exchange)

    document = json.loads(truepose("identify", folder, "--json").stdout)

    assert [outlier["config"] for outlier in document["outliers"]] == [7, 19]
    assert all("swapped" in outlier["reason"] for outlier in document["outliers"])


def test_a_wrong_nest_label_is_listed(folder):
    spoil(folder, put(10, "nest", "3"))

    document = json.loads(truepose("identify", folder, "--json").stdout)

    assert [outlier["config"] for outlier in document["outliers"]] == [11]
    assert "it fits nest 2" in document["outliers"][0]["reason"]


# Bad input: models


def newer(text):
    document = json.loads(text)
    document["version"] = 99
    return json.dumps(document)


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (newer, "version 99"),
        (lambda text: text[: len(text) // 2], "model.json"),
        (lambda text: "no JSON at all", "model.json"),
        (lambda text: "[1, 2]", "model.json"),
    ],
    ids=["newer", "cut off", "text", "a list"],
)
@pytest.mark.parametrize("command", ["predict", "validate"])
def test_a_model_that_cannot_be_read_is_one_sentence(good, tmp_path, command, change, words):
    model = tmp_path / "model.json"
    model.write_text(change((good / "model.json").read_text()))
    more = ("--out", tmp_path / "out.csv") if command == "predict" else ()

    done = truepose(command, model, good / "campaign" / "validation.csv", *more)

    assert_one_sentence(done, "model.json", words)
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize("command", ["predict", "validate"])
def test_rows_that_lack_joints_are_refused(good, tmp_path, command):
    rows = rows_of(good / "campaign" / "validation.csv")
    write_rows(tmp_path / "points.csv", without("q6_deg")(rows))
    more = ("--out", tmp_path / "out.csv") if command == "predict" else ()

    done = truepose(command, good / "model.json", tmp_path / "points.csv", *more)

    assert_one_sentence(done, "points.csv", "q6_deg")
    assert not (tmp_path / "out.csv").exists()


# Bad input: where the answer should go


@pytest.mark.parametrize("option", ["--model-out", "--report"])
@pytest.mark.parametrize("place", ["nowhere/file", "."])
def test_a_place_that_cannot_be_written_is_refused_before_the_work(folder, option, place):
    done = truepose("identify", folder, option, folder / place, "--json")

    assert_one_sentence(done, "folder")


def test_predictions_into_a_missing_folder_are_refused(good, tmp_path):
    points = good / "campaign" / "validation.csv"

    done = truepose("predict", good / "model.json", points, "--out", tmp_path / "nowhere" / "out.csv")

    assert_one_sentence(done, "nowhere")
    assert not (tmp_path / "nowhere").exists()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_a_full_disk_is_named(good):
    points = good / "campaign" / "validation.csv"

    predicted = truepose("predict", good / "model.json", points, "--out", "/dev/full")
    identified = truepose("identify", good / "campaign", "--model-out", "/dev/full")

    assert_one_sentence(predicted, "/dev/full cannot be written")
    assert_one_sentence(identified, "/dev/full cannot be written")


@pytest.mark.parametrize("arguments", [("identify",), ("identify", "--bogus"), ("nonsense",)])
def test_a_command_that_cannot_be_understood_says_so(arguments):
    done = truepose(*arguments)

    assert done.returncode == 2
    assert "Error" in done.stderr and "Traceback" not in done.stderr
    assert done.stdout == ""


def test_a_simulated_cell_ends_with_the_command_that_started_it():
    command = [str(TRUEPOSE), "simulate", "irb120-clean", "--seed", "3", "--pace", "0"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        first = json.loads(process.stdout.readline())
        with socket.create_connection((first["host"], first["port"]), timeout=5):
            pass
        process.terminate()
        process.wait(timeout=20)

    with pytest.raises(ConnectionRefusedError):
        socket.create_connection((first["host"], first["port"]), timeout=5)


@pytest.mark.parametrize(
    "arguments",
    [
        ("identify", "it.zip"),
        ("diagnose", "folder"),
        ("predict", "it.zip", "it.zip", "--out", "out.csv"),
        ("validate", "it.zip", "it.zip"),
        ("inspect", "it.zip"),
        ("serve", "--cell", "it.zip", "--port", "0"),
    ],
)
def test_a_pipe_is_no_file_and_nobody_waits_for_it(tmp_path, arguments):
    os.mkfifo(tmp_path / "it.zip")
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "campaign.json").symlink_to(tmp_path / "it.zip")

    refused = truepose(*arguments, cwd=tmp_path)

    assert refused.returncode == 2
    assert ": this is a pipe, not a file; name a file." in refused.stderr
    assert refused.stderr.count("\n") == 1
    assert refused.stderr.count("\n") == 1
