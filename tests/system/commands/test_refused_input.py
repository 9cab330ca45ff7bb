"""The commands on what cannot be used: an exit status and one sentence that names the file and the reason."""

import json
import math
import os
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.helpers.commands import assert_one_sentence, installed
from tests.helpers.commands import typed as truepose
from tests.helpers.exchange.rows import read_rows, write_rows


def spoil(folder, change):
    """Rewrite the calibration rows with `change(rows)`, which may return others."""
    file = folder / "calibration.csv"
    rows = read_rows(file)
    write_rows(file, change(rows) or rows)


@contextmanager
def description_of(folder):
    """What the campaign says of itself, which is written as it is left."""
    file = folder / "campaign.json"
    description = json.loads(file.read_text())
    yield description
    file.write_text(json.dumps(description))


def verdict_of(done):
    """The document of an identification that ended with `no`."""
    assert done.returncode == 1, done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    return json.loads(done.stdout)


# The table


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
    (folder / "calibration.csv").unlink()

    assert_one_sentence(installed("identify", folder), "calibration.csv")


def test_a_missing_folder_is_named(tmp_path):
    assert_one_sentence(truepose("identify", tmp_path / "nowhere"), "nowhere")


def test_a_campaign_with_validation_alone_has_nothing_to_identify_from(folder):
    with description_of(folder) as description:
        del description["files"]["calibration"]

    assert_one_sentence(truepose("identify", folder, "--json"), "calibration")


@pytest.mark.parametrize("text", ["", "{", "[]", "null", '{"format": "something else"}'])
def test_a_description_that_is_none_is_refused(folder, text):
    (folder / "campaign.json").write_text(text)

    assert_one_sentence(truepose("identify", folder), "campaign.json")


@pytest.mark.parametrize(
    ("effects", "words"),
    [
        ("base,magic", ("'magic'", "base, tool, geometry", "compliance")),
        (",", ("auto",)),
        ("geometry,joint_offset", ("Leave out one of the two effects",)),
        ("base,base", ("is given twice. Give it once",)),
    ],
)
def test_effects_that_make_no_model_are_refused(folder, effects, words):
    assert_one_sentence(truepose("identify", folder, "--effects", effects), *words)


# Readings that parse and cannot be meant


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
        (all_equal, "too_few_data", "one configuration"),
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
    with description_of(folder) as description:
        for row in description["dhm_nominal"]:
            row.update(alpha_deg=0.0, a_mm=0.0, d_mm=0.0)

    done = truepose("identify", folder, "--json")

    assert verdict_of(done)["status"] == "wrong_nominal_model"
    assert "Warning" not in done.stderr


def test_gravity_that_points_upwards_is_said(folder):
    with description_of(folder) as description:
        description["gravity_m_s2_world"] = [0.0, 0.0, 9.81]

    document = json.loads(truepose("identify", folder, "--json").stdout)

    assert (
        "came out negative, which is impossible for a spring: check the direction of gravity"
        in document["message"]
    )


def exchange(rows):
    for column in ("x_mm", "y_mm", "z_mm"):
        rows[6][column], rows[18][column] = rows[18][column], rows[6][column]


@pytest.mark.parametrize(
    ("change", "listed", "reason"),
    [(exchange, [7, 19], "swapped"), (put(10, "nest", "3"), [11], "it fits nest 2")],
    ids=["exchanged", "wrong nest"],
)
def test_rows_that_cannot_belong_to_their_configurations_are_listed(folder, change, listed, reason):
    spoil(folder, change)

    document = json.loads(truepose("identify", folder, "--json").stdout)

    assert [outlier["config"] for outlier in document["outliers"]] == listed
    assert all(reason in outlier["reason"] for outlier in document["outliers"])


# Models


def newer(text):
    document = json.loads(text)
    document["version"] = 99
    return json.dumps(document)


def asked(command, model, points, out):
    """The command on these files, and where the answer goes of the one that writes it."""
    return truepose(command, model, points, *(("--out", out) if command == "predict" else ()))


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

    done = asked(command, model, good / "campaign" / "validation.csv", tmp_path / "out.csv")

    assert_one_sentence(done, "model.json", words)
    assert not (tmp_path / "out.csv").exists()


@pytest.mark.parametrize("command", ["predict", "validate"])
def test_rows_that_lack_joints_are_refused(good, tmp_path, command):
    rows = read_rows(good / "campaign" / "validation.csv")
    write_rows(tmp_path / "points.csv", without("q6_deg")(rows))

    done = asked(command, good / "model.json", tmp_path / "points.csv", tmp_path / "out.csv")

    assert_one_sentence(done, "points.csv", "q6_deg")
    assert not (tmp_path / "out.csv").exists()


# What is asked, and where the answer should go


@pytest.mark.parametrize("limit", ["nan", "0", "-1", "inf"])
def test_a_limit_that_judges_nothing_is_refused(good, limit):
    arguments = (good / "model.json", good / "campaign" / "validation.csv", f"--limit-mm={limit}", "--json")

    assert_one_sentence(truepose("validate", *arguments), "--limit-mm", "above 0 mm")


def test_points_without_cycles_are_no_test_of_iso_9283(good):
    points = good / "campaign" / "validation.csv"

    done = truepose("validate", good / "model.json", points, "--iso9283", "--json")

    assert_one_sentence(done, "has no repeatedly measured pose", "repeat_of")


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
