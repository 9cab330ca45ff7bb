"""Closed loops as they are recorded: what is read is what is truly there, and the papers do not tell more."""

import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.rigid import move
from truepose_simulators.recording.__main__ import main
from truepose_simulators.recording.closed_loop_campaign import LoopRecordingRequest, record_loop
from truepose_simulators.recording.closed_loops import LOOPS
from truepose_simulators.recording.plan import RecordingRequest
from truepose_simulators.scenarios.file import load_scenario

TILTED = load_scenario("lrmate-tilted")
NOISE_FREE = replace(TILTED, noise=False)
FEW = RecordingRequest(configurations=1, validation=2, attachments=1, reference_every=0)


def recorded(kind, scenario=NOISE_FREE, configurations=12, validation=4, **changes):
    return record_loop(
        scenario, 3, LoopRecordingRequest(kind, configurations, validation, tracker=FEW, **changes)
    )


def nominal_places(recording, contacts):
    flange = nominal_flange(recording.cell.plant.arm, np.radians(contacts.joints_deg))
    return move(flange, np.array(recording.cell.scenario.tool.nests_mm)[contacts.nest - 1])


@pytest.mark.parametrize("kind", LOOPS)
def test_every_loop_is_recorded_near_where_its_drawing_has_it(kind):
    recording = recorded(kind)

    contacts, loop = recording.calibration, recording.loop
    assert set(contacts.target.tolist()) == set(range(1, len(loop.placed) + 1))
    assert set(contacts.config.tolist()) == set(range(1, 13))
    if loop.spread_mm and kind != "face":  # whose sensor looks at it from 40 mm away
        assert (
            np.abs(contacts.reading_mm).max() < 20.0
        )  # its range, for an arm and a fixture off by millimetres


@pytest.mark.parametrize("kind", ["sphere", "tilted-plane"])
def test_a_probe_goes_on_until_it_touches_and_then_reads_nothing(kind):
    recording = recorded(kind)
    places = nominal_places(recording, recording.calibration)

    assert not recording.calibration.reading_mm.any()
    placed = recording.loop.placed[0]
    off = places - np.array(placed.place_mm)
    normal = np.array(placed.normal) / np.linalg.norm(placed.normal)
    gap = np.linalg.norm(off, axis=1) - 15.7 if kind == "sphere" else off @ normal
    # What the fixture and the arm are off by, either a few millimetres.
    assert np.abs(gap).max() < 10.0
    assert np.std(gap) > 0.05  # and it is not the nominal arm that touches


def test_the_scatter_of_the_arm_shows_in_where_the_probe_triggers():
    still, scattered = (recorded("tilted-plane", scenario).calibration for scenario in (NOISE_FREE, TILTED))

    moved = np.degrees(1e-5) < np.abs(still.joints_deg - scattered.joints_deg).max(axis=1)
    assert not scattered.reading_mm.any()
    assert moved.any()


def test_readings_of_one_stop_share_its_scatter():
    still, scattered = (recorded("gauges", scenario).calibration for scenario in (NOISE_FREE, TILTED))

    off = (scattered.reading_mm - still.reading_mm).reshape(-1, 3)
    assert 0.001 < np.std(off) < 0.01  # 0.0035 mm of scatter, 0.001 mm of the gauges, twelve stops


def test_a_certified_distance_is_the_true_one_within_its_uncertainty():
    recording = recorded("two-spheres", TILTED)

    drawn = (np.array(placed.place_mm) for placed in recording.loop.placed)
    nominal = float(np.linalg.norm(np.subtract(*drawn)))
    assert abs(recording.distance_mm - nominal) < 12.0  # each stands off its drawing by up to 3 mm an axis
    again = recorded("two-spheres", NOISE_FREE)
    assert abs(recording.distance_mm - again.distance_mm) < 0.005  # u is 0.001 mm


def test_the_same_seed_gives_the_same_loop():
    first, second = recorded("wires", TILTED), recorded("wires", TILTED)

    assert np.array_equal(first.calibration.reading_mm, second.calibration.reading_mm)


def test_a_folder_says_what_papers_know_and_no_more(tmp_path):
    arguments = ["--seed", "2", "--configurations", "9", "--validation", "3", "--out", str(tmp_path)]

    assert main(["lrmate-tilted", "--loop", "two-balls", *arguments]) == 0

    document = json.loads((tmp_path / "campaign.json").read_text())
    assert document["kind"] == "contacts"
    assert document["tool_nests_mm"][1] is None  # the sensor sits somewhere
    assert document["tool_nests_mm"][0] is not None
    with (tmp_path / "targets.csv").open() as file:
        targets = list(csv.DictReader(file))
    assert [row["kind"] for row in targets] == ["ball", "ball"]
    assert set(targets[0]) == {"target", "kind", "zero_mm", "u_zero_mm", "form_mm"}
    with (tmp_path / "contacts.csv").open() as file:
        contacts = list(csv.DictReader(file))
    assert [row["axis"] for row in contacts[:4]] == ["x", "y", "z", "x"]
    assert len(contacts) == 27


def test_a_loop_that_there_is_not_is_refused_by_name():
    with pytest.raises(ScenarioError, match="two-spheres"):
        LoopRecordingRequest("cube")


def test_a_loop_is_no_ballbar(tmp_path, capsys):
    with pytest.raises(SystemExit):
        main(["lrmate-tilted", "--loop", "wires", "--model", "m.json", "--out", str(tmp_path)])

    assert "--loop" in capsys.readouterr().err
