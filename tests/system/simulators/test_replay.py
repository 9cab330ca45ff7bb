"""From a measured robot to its model and back: the simulation shows what was measured."""

import asyncio
import csv
import json
import socket
import subprocess
import sys

import numpy as np
import pytest

from tests.helpers.commands import installed, typed
from tests.helpers.machine import HANGS_S
from tests.system.session_bench import LOOK_S, bench
from tests.unit.service.sessions.tracker.operators import PatientOperator
from truepose.domain.campaign import Stops
from truepose.exchange.import_wizard.single_table import read_points_to_predict
from truepose.exchange.models.file import read_model
from truepose.identification import predict
from truepose.planning.tracker.plans import plan_validation
from truepose.sessions.tracker.runner import TrackerRunner
from truepose_simulators.recording.__main__ import main

GEARED = """extends = "irb120-clean"
[[effect]]
name = "joint_harmonics"
subject = "joint 6"
amplitude = 0.05
order = 2
[[effect]]
name = "joint_gain"
subject = "joint 5"
amplitude = 8e-4
"""
DRIFTING = """extends = "irb120-clean"
[[effect]]
name = "instrument_drift"
subject = "tracker"
amplitude = 0.4
rotation_rad_per_h = 3e-4
"""
EFFECTS = "base,geometry,compliance,joint_gain,joint_harmonics"


def column_block(path, *names):
    with path.open(encoding="utf-8") as file:
        return np.array([[float(row[name]) for name in names] for row in csv.DictReader(file)])


def positions_mm(folder, table="calibration.csv"):
    return column_block(folder / table, "x_mm", "y_mm", "z_mm")


@pytest.fixture(scope="module")
def geared(tmp_path_factory):
    """A robot with a wave and a gain that no plain model has: measured, identified, model saved."""
    folder = tmp_path_factory.mktemp("geared")
    (folder / "geared.toml").write_text(GEARED)
    arguments = [str(folder / "geared.toml"), "--seed", "6", "--validation", "100"]
    assert main([*arguments, "--out", str(folder / "measured")]) == 0
    done = typed(
        "identify", folder / "measured", "--effects", EFFECTS, "--model-out", folder / "model.json", "--json"
    )
    assert done.returncode == 0, done.stderr
    return folder


def test_a_replayed_campaign_reads_as_the_measured_one_within_the_noise_of_both(geared):
    arguments = ["irb120-tilted", "--model", str(geared / "model.json"), "--seed", "9"]
    asked = ["--replay", str(geared / "measured"), "--out", str(geared / "replayed")]

    assert main([*arguments, *asked]) == 0

    u_mm = column_block(geared / "measured" / "calibration.csv", "u_mm")
    apart = positions_mm(geared / "replayed") - positions_mm(geared / "measured")
    # Two readings with the arm's scatter of 0.0035 mm each.
    squares = apart**2 / (2.0 * (u_mm**2 + 0.0035**2))
    n, p = squares.size, len(read_model(geared / "model.json").parameters)
    # What the p parameters took up of the measured noise is in both; four standard deviations of the mean.
    assert squares.mean() == pytest.approx(1.0 - p / (2.0 * n), abs=4.0 * np.sqrt(2.0 / n))
    # Without the model's own effects the two would be this far apart; so much is there to be shown.
    plain = typed("identify", geared / "measured", "--json")
    assert json.loads(plain.stdout)["chi2_per_dof"] > 4.0


def test_a_replayed_campaign_is_a_campaign_like_the_measured_one(geared):
    main([
        *("irb120-tilted", "--model", str(geared / "model.json"), "--replay", str(geared / "measured")),
        *("--out", str(geared / "again")),
    ])

    first = json.loads(typed("identify", geared / "measured", "--effects", EFFECTS, "--json").stdout)
    again = json.loads(typed("identify", geared / "again", "--effects", EFFECTS, "--json").stdout)

    assert again["counts"] == {**first["counts"], "outliers": again["counts"]["outliers"]}
    # Both leave their own noise of 300 coordinates: a standard deviation of 9 % each, four of both together.
    assert again["chi2_per_dof"] == pytest.approx(first["chi2_per_dof"], abs=4 * 0.09 * np.sqrt(2))
    identified = {p["name"]: p for p in first["parameters"]}
    for parameter in again["parameters"]:
        original = identified[parameter["name"]]
        spread = np.hypot(original["standard_uncertainty"], parameter["standard_uncertainty"])
        assert abs(parameter["value"] - original["value"]) < 5 * spread


def test_fixed_nests_are_replayed_as_they_were_read_through_a_drifting_tracker(tmp_path):
    (tmp_path / "drifting.toml").write_text(DRIFTING)
    main([str(tmp_path / "drifting.toml"), "--out", str(tmp_path / "measured"), "--validation", "0"])
    model = tmp_path / "model.json"
    effects = "base,geometry,compliance,instrument_drift"
    done = typed("identify", tmp_path / "measured", "--effects", effects, "--model-out", model)
    assert done.returncode == 0, done.stderr

    asked = ["--replay", str(tmp_path / "measured"), "--out", str(tmp_path / "replayed"), "--seed", "2"]
    assert main(["irb120-clean", "--model", str(model), *asked]) == 0

    u_mm = column_block(tmp_path / "measured" / "reference.csv", "u_mm")
    apart = positions_mm(tmp_path / "replayed", "reference.csv") - positions_mm(
        tmp_path / "measured", "reference.csv"
    )
    squares = apart**2 / (2.0 * u_mm**2)
    # 10 looks at 3 nests: 90 squares, their mean known to sqrt(2 / 90); four of these. The drift alone, of
    # 0.3 mm in the 47 min, would be 20 deviations at the end.
    assert squares.mean() == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / squares.size))


@pytest.mark.parametrize("campaign", ["fanuc-r2000", "iiwa7-1p25kg", "motoman-right"])
def test_real_robots_replay_as_their_models_predict(measured_data, tmp_path, campaign):
    folder, model = measured_data / "campaigns" / campaign, tmp_path / "model.json"
    assert typed("identify", folder, "--model-out", model).returncode == 0
    (tmp_path / "quiet.toml").write_text('extends = "irb120-tilted"\nnoise = false\n')
    arguments = [str(tmp_path / "quiet.toml"), "--model", str(model)]

    assert main([*arguments, "--replay", str(folder), "--out", str(tmp_path / "out")]) == 0

    identified = read_model(model)
    rows = read_points_to_predict(
        folder / "calibration.csv", identified.robot.n_joints, [nest.nest for nest in identified.nests]
    )
    predicted, _ = predict(identified, rows.stops, rows.nest)
    # The limit of test_identified_models, for the same reasons.
    assert positions_mm(tmp_path / "out") == pytest.approx(predicted, abs=1e-3)


async def test_a_session_over_the_wire_measures_the_robot_of_the_model(geared, forked_processes):
    identified = read_model(geared / "model.json")
    async with bench("irb120-clean", 3, "--model", str(geared / "model.json")) as opened:
        plan = plan_validation(opened.space, 25, seed=1)
        runner = TrackerRunner(plan, opened.cell, opened.journal)
        running = asyncio.create_task(runner.run())
        async with asyncio.timeout(HANGS_S):
            await PatientOperator(look_s=LOOK_S).attend(runner, running)

    points = opened.journal.points
    stops = Stops(
        config=np.array([point.config for point in points]),
        joints_rad=np.array([point.commanded_rad for point in points]),
    )
    predicted, _ = predict(identified, stops, np.array([point.nest for point in points]))
    errors = np.array([point.position_world_mm for point in points]) - predicted
    # Tracker 0.0155 mm per axis, scatter 0.0035, registration 0.003, as in test_session_on_simulated_cell.
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(0.016, rel=0.3)


def test_the_command_announces_the_models_cell_and_it_stands_where_predicted(geared):
    command = [sys.executable, "-m", "truepose", "simulate", "--pace", "0", "--model", geared / "model.json"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process:
        endpoints = {}
        while "hands" not in endpoints:
            entry = json.loads(process.stdout.readline())
            endpoints[entry["device"]] = entry
        joints = [0.3, 0.5, -0.4, 1.0, -0.7, 2.0]
        with socket.create_connection((endpoints["truth"]["host"], endpoints["truth"]["port"])) as truth:
            truth.sendall(
                json.dumps({"op": "positions", "joints_rad": [joints], "nests": [2]}).encode() + b"\n"
            )
            answer = json.loads(truth.makefile("rb").readline())
        process.terminate()
        process.communicate()  # what it still announces must not meet a closed pipe

    assert process.returncode == 0
    assert list(endpoints) == ["tracker", "robot", "robot-log", "clock", "truth", "ballbar", "hands"]
    stops = Stops(config=np.array([1]), joints_rad=np.array([joints]))
    predicted, _ = predict(read_model(geared / "model.json"), stops, np.array([2]))
    assert answer["positions_mm"] == pytest.approx(predicted, abs=1e-3)


def test_the_command_refuses_a_file_that_is_no_model(geared):
    done = installed("simulate", "--model", geared / "measured" / "campaign.json")

    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr == 'campaign.json is not a model file; one begins with "format": "truepose-model"\n'
