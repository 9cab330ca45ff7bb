import csv
import json
from dataclasses import replace

import numpy as np
import pytest

from tests.unit.simulators.hands.deeds import POSE, SETUPS, clamp_all, move
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.errors import ScenarioError
from truepose_simulators.instruments.accuracy import BallbarSetup
from truepose_simulators.physics.effects import PlantedChange
from truepose_simulators.recording import RecordingRequest
from truepose_simulators.recording.__main__ import main
from truepose_simulators.recording.ballbars.campaign import BallbarRecordingRequest, record_ballbar
from truepose_simulators.recording.ballbars.plan import plan_from
from truepose_simulators.recording.campaign import record
from truepose_simulators.scenarios.file import load_scenario

TILTED = load_scenario("lrmate-tilted")
NOISE_FREE = replace(TILTED, noise=False)
POSES = [[-88.51593, -5.05317, 137.36035, 136.23349, 92.19679, 15.52431], POSE]
LEGS = [[[2, 1], [1, 1], [3, 1], [2, 3], [1, 3], [1, 2]], [[3, 2], [1, 2], [2, 2], [3, 1], [1, 1], [1, 3]]]
FEW = RecordingRequest(configurations=5, validation=4, attachments=1)


def drawn_up(placements=1, repeats=1, **changes):
    """A plan in which every placement has the same set-ups and poses."""
    return {
        "placements": [
            {
                "number": number,
                "setups": [{"base_point": k, "joints_deg": row} for k, row in enumerate(SETUPS, start=1)],
                "poses": [
                    {
                        "config": 100 * number + k,
                        "joints_deg": POSES[k % 2],
                        "legs": [*LEGS[k % 2]],
                        **changes,
                    }
                    for k in range(2 * repeats)
                ],
            }
            for number in range(1, placements + 1)
        ]
    }


PLAN = plan_from(drawn_up(), "plan")


def recorded(scenario=TILTED, seed=3, plan=PLAN, **wishes):
    return record_ballbar(scenario, seed, plan, BallbarRecordingRequest(tracker=FEW, **wishes))


def generous(scenario):
    """A ballbar that is never out of range, so that every planned leg is there."""
    return replace(scenario, ballbar=replace(scenario.ballbar, range_mm=1000.0))


def true_nests_mm(cell, legs):
    conditions = cell.conditions(np.radians(legs.joints_deg), legs.direction, legs.time_s, legs.attachment)
    return cell.true_positions(conditions)


def test_without_noise_every_length_is_the_distance_of_cup_and_nest():
    recording = recorded(generous(NOISE_FREE))

    legs, cups = recording.legs, recording.cups
    nests = true_nests_mm(recording.cell, legs)[np.arange(len(legs)), legs.tool_point - 1]
    expected = np.linalg.norm(nests - cups.true_mm[legs.base_point - 1], axis=1)
    assert len(legs) == 12
    assert legs.length_mm == pytest.approx(expected, abs=1e-9)
    assert legs.true_mm == pytest.approx(expected, abs=1e-9)


def test_without_noise_cups_are_where_the_true_robot_held_the_ball_and_triangles_are_true():
    recording = recorded(generous(NOISE_FREE))

    cell, cups, sides = recording.cell, recording.cups, recording.sides
    joints = np.radians(SETUPS)
    # Springs and links do not care about directions or times.
    held = cell.true_positions(cell.conditions(joints, np.ones((3, 6)), np.zeros(3), np.ones(3)))[:, 0]
    assert cups.true_mm == pytest.approx(held, abs=1e-9)
    tool = cell.tool_nests_mm
    for placement, points in ((0, tool), (1, cups.true_mm)):
        mine = sides.placement == placement
        ends = points[sides.point_b[mine] - 1] - points[sides.point_a[mine] - 1]
        assert mine.sum() == 3
        assert sides.length_mm[mine] == pytest.approx(np.linalg.norm(ends, axis=1), abs=1e-9)


def test_a_fourth_cup_makes_six_sides_and_further_legs():
    document = drawn_up()
    document["placements"][0]["setups"].append({"base_point": 4, "joints_deg": POSES[0]})
    document["placements"][0]["poses"][1]["legs"] += [[4, 1], [4, 2]]

    recording = recorded(generous(NOISE_FREE), plan=plan_from(document, "plan"))

    cups, sides, legs = recording.cups, recording.sides, recording.legs
    mine = sides.placement == 1
    pairs = list(zip(sides.point_a[mine].tolist(), sides.point_b[mine].tolist(), strict=True))
    assert pairs == [(1, 2), (1, 3), (1, 4), (2, 3), (2, 4), (3, 4)]
    assert cups.base_point.tolist() == [1, 2, 3, 4]
    fourth = legs.base_point == 4
    nests = true_nests_mm(recording.cell, legs)[fourth, legs.tool_point[fourth] - 1]
    assert legs.length_mm[fourth] == pytest.approx(np.linalg.norm(nests - cups.true_mm[3], axis=1), abs=1e-9)


def test_a_pose_that_the_arm_cannot_correct_is_left_out_and_named():
    plan = plan_from(drawn_up(aimed_mm=[300.0, 300.0, 300.0, 300.0, 300.0, 900.0]), "plan")

    recording = recorded(plan=plan, aimed=True)

    assert recording.not_reached == (100, 101)
    assert len(recording.legs) + len(recording.out_of_range) == 0


def test_set_ups_of_later_placements_are_aimed_at_their_cups():
    document = drawn_up(placements=2)
    cups = recorded(
        replace(NOISE_FREE, errors=replace(NOISE_FREE.errors, link_translation_mm=0.0))
    ).cups.true_mm
    for placement in document["placements"]:
        placement["cups_mm"] = cups.tolist()

    aimed = recorded(NOISE_FREE, plan=plan_from(document, "plan"), aimed=True).cups

    off_mm = np.linalg.norm(aimed.true_mm.reshape(2, 3, 3) - cups, axis=2)
    # Another robot than that of the plan misses by its own errors, a corrected one by 0.05 per axis.
    assert off_mm[0].max() > 0.2
    assert off_mm[1].max() < 4 * 0.05 * np.sqrt(3.0)


def test_a_reading_out_of_range_is_no_row():
    everything, measured = recorded(generous(NOISE_FREE)), recorded(NOISE_FREE)

    beyond = np.abs(everything.legs.length_mm - 300.0) > 1.0
    assert 0 < beyond.sum() < len(beyond)
    assert measured.legs.length_mm == pytest.approx(everything.legs.length_mm[~beyond])
    assert measured.out_of_range.length_mm == pytest.approx(everything.legs.length_mm[beyond])
    assert (np.abs(measured.sides.length_mm[measured.sides.placement == 1] - 300.0) <= 1.0).all()


def test_readings_of_a_stop_share_the_arms_scatter_and_the_rest_is_the_ballbars():
    plan = plan_from(drawn_up(repeats=150), "plan")
    quiet_arm = replace(TILTED, arm=replace(TILTED.arm, scatter_mm=0.0))

    of_ballbar, of_both = (recorded(generous(scenario), plan=plan).legs for scenario in (quiet_arm, TILTED))

    error, whole = (legs.length_mm - legs.true_mm for legs in (of_ballbar, of_both))
    # Reading k of a group follows 2 k snaps of 0.0006; the bound at 0.003 hardly cuts.
    place = np.tile(np.arange(1, 7), 300)
    expected = np.sqrt(0.00051**2 + 2 * 0.0006**2 * place)
    for k in (1, 6):
        # Standard deviation of 300 draws: 4 %, four of these.
        assert error[place == k].std() == pytest.approx(expected[place == k][0], rel=0.16)
    assert np.abs(error).max() < 0.003 + 6 * 0.00051
    # One direction of three times 0.0035 besides; 300 stops.
    assert whole.std() == pytest.approx(np.hypot(0.0035, error.std()), rel=0.16)
    # Legs 1 and 2 of a pose end at the same nest: half of their errors' variance and more is common.
    first, second = whole.reshape(300, 6)[::2, 0], whole.reshape(300, 6)[::2, 1]
    assert np.corrcoef(first, second)[0, 1] > 0.3


def test_clamped_cups_are_off_by_the_clamp_and_the_tracker_reads_them_to_its_mean():
    cups = [recorded(seed=seed).cups for seed in range(40)]
    held = [recorded(NOISE_FREE, seed=seed).cups.true_mm for seed in range(40)]

    clamped = np.array([one.true_mm - true for one, true in zip(cups, held, strict=True)])
    read = np.array([one.read_mm - one.true_mm for one in cups])
    # 360 draws: 3.7 %, four of these.
    assert clamped.std() == pytest.approx(np.hypot(0.01, 0.0035), rel=0.15)
    # Ten readings of 0.016, and the registration on certified nests.
    assert cups[0].u_mm == pytest.approx(np.full(3, 0.005), abs=0.0005)
    assert 0.004 < read.std() < 0.015


def test_poses_are_aimed_to_what_a_pre_calibrated_model_misses():
    plan = plan_from(drawn_up(repeats=40), "plan")

    raw, aimed = (recorded(plan=plan, aimed=aimed) for aimed in (False, True))

    assert len(raw.out_of_range) > 0
    assert len(aimed.out_of_range) == 0
    assert aimed.not_reached == ()
    # 480 legs: 3.2 %, four of these; scatter and ballbar add 0.2 % to 0.05.
    assert (aimed.legs.length_mm - 300.0).std() == pytest.approx(0.05, rel=0.13)
    assert not np.array_equal(aimed.legs.joints_deg, raw.legs.joints_deg[:1])


def test_aimed_lengths_may_be_stated_leg_by_leg():
    wanted = [299.3, 299.58, 299.86, 300.14, 300.42, 300.7]
    plan = plan_from(drawn_up(aimed_mm=wanted), "plan")

    legs = recorded(NOISE_FREE, plan=plan, aimed=True, aim_error_mm=0.0).legs

    # Joints are written with five decimals of a degree, 1e-4 mm at 0.7 m; directions may be others.
    assert legs.length_mm == pytest.approx(wanted * 2, abs=1e-3)


def test_initialisations_are_counted_as_they_happen():
    legs = recorded(generous(TILTED), plan=plan_from(drawn_up(placements=2), "plan")).legs

    # 1 the tool, 2 the first base, 3 and 4 its poses, 5 the second base, 6 and 7 its poses.
    assert dict(zip(legs.config.tolist(), legs.init.tolist(), strict=True)) == {
        100: 3,
        101: 4,
        200: 6,
        201: 7,
    }
    assert (np.diff(legs.time_s) > 0).all()


def test_the_tracker_measures_the_same_robot_whatever_the_plan():
    one, other = recorded(), recorded(plan=plan_from(drawn_up(placements=2), "plan"))
    alone = record(TILTED, 3, FEW)

    for recording in (one, other):
        stops = recording.tracker.calibration.stops
        assert np.array_equal(stops.joints_deg, alone.calibration.stops.joints_deg)
        assert stops.time_s[0] > recording.legs.time_s[-1]
        assert recording.tracker.validation.true_mm == pytest.approx(alone.validation.true_mm, abs=1e-9)
    nest = one.tracker.validation.stops.nest
    assert one.true_validation_mm[np.arange(4), nest - 1] == pytest.approx(one.tracker.validation.true_mm)


def test_the_same_plan_gives_the_same_campaign_and_another_seed_another_one():
    first, same, other = (recorded(seed=seed) for seed in (1, 1, 2))

    assert np.array_equal(first.legs.length_mm, same.legs.length_mm)
    assert np.array_equal(first.cups.read_mm, same.cups.read_mm)
    assert not np.isin(other.cups.true_mm, first.cups.true_mm).any()


def test_a_quiet_robot_is_the_same_everyday_robot_without_drift_and_warm_up():
    everyday = load_scenario("lrmate-everyday")

    loud, quiet = (Cell(one, 5, CellClock(0)) for one in (everyday, everyday.quiet()))

    assert {change.name for change in loud.planted.changes} - {c.name for c in quiet.planted.changes} == {
        "base_drift",
        "thermal_growth",
    }
    # What is left is drawn the same.
    kept = [change for change in loud.planted.changes if change.name not in {"base_drift", "thermal_growth"}]
    assert kept == list(quiet.planted.changes)
    assert TILTED.quiet() is TILTED


def planted(*changes):
    return generous(replace(NOISE_FREE, effects=changes))


def test_a_fixture_that_moves_takes_its_cups_along_from_then_on():
    still = recorded(generous(NOISE_FREE)).legs
    between = (still.time_s[5] + still.time_s[6]) / 2.0
    shift = PlantedChange("fixture_shift", "placement 1", 0.3, between, {"direction": [0, 0, 1]})

    recording = recorded(planted(shift))

    changed = recording.legs.length_mm - still.length_mm
    assert not changed[:6].any()
    nests = true_nests_mm(recording.cell, still)[np.arange(12), still.tool_point - 1]
    cups = recording.cups.true_mm[still.base_point - 1] + [0.0, 0.0, 0.3]
    assert recording.legs.length_mm[6:] == pytest.approx(np.linalg.norm(nests - cups, axis=1)[6:], abs=1e-9)


def test_a_ballbar_with_a_wrong_scale_reads_every_length_too_long_by_it():
    still = recorded(generous(NOISE_FREE))

    scaled = recorded(planted(PlantedChange("instrument_scale", "ballbar", 1e-5)))

    assert scaled.legs.length_mm == pytest.approx(still.legs.length_mm * (1.0 + 1e-5), abs=1e-9)
    assert scaled.sides.length_mm == pytest.approx(still.sides.length_mm * (1.0 + 1e-5), abs=1e-9)
    assert np.array_equal(
        scaled.tracker.validation.readings.position_mm, still.tracker.validation.readings.position_mm
    )


def test_a_wrong_zero_is_shared_by_the_readings_of_one_initialisation():
    still = recorded(generous(NOISE_FREE)).legs

    off = recorded(planted(PlantedChange("ballbar_zero", "ballbar", 0.01))).legs

    error = (off.length_mm - still.length_mm).reshape(2, 6)
    assert np.ptp(error, axis=1) == pytest.approx(0.0, abs=1e-9)
    assert abs(error[0, 0] - error[1, 0]) > 1e-4


def test_confused_nests_are_read_and_written_down_under_the_planned_names():
    still = recorded(generous(NOISE_FREE))

    swapped = recorded(planted(PlantedChange("label_swap", "nest 1, nest 3", 1.0)))

    legs, nests = swapped.legs, true_nests_mm(still.cell, still.legs)
    read = np.array([3, 2, 1])[legs.tool_point - 1]
    cups = swapped.cups.true_mm[legs.base_point - 1]
    expected = np.linalg.norm(nests[np.arange(12), read - 1] - cups, axis=1)
    assert np.array_equal(legs.tool_point, still.legs.tool_point)
    assert legs.length_mm == pytest.approx(expected, abs=1e-9)


def test_wild_legs_are_off_by_their_size_either_way():
    plan = plan_from(drawn_up(repeats=10), "plan")
    still = recorded(generous(NOISE_FREE), plan=plan).legs
    wild = PlantedChange("outliers", "readings", 0.3, details={"size_mm": 0.2})

    off = recorded(planted(wild), plan=plan).legs.length_mm - still.length_mm

    hit = np.abs(off) > 1e-6
    assert np.abs(off[hit]) == pytest.approx(0.2, abs=1e-9)
    assert {-1.0, 1.0} == set(np.sign(off[hit]))


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        (lambda d: d["placements"][0]["setups"].pop(), "set-ups must be of base points 1 to 3 or 1 to 4"),
        (lambda d: d["placements"].append(d["placements"][0]), "unique, see placement 1"),
        (lambda d: d["placements"][0].update(poses=[]), "no pose with a leg"),
        (lambda d: d["placements"][0]["poses"][0].update(config=101), "unique, see config 101"),
        (lambda d: d["placements"][0]["poses"][0].update(legs=[[4, 1]]), "no leg 4-1"),
        (lambda d: d["placements"][0]["poses"][0].update(joints_deg=[0.0]), "must have 6 entries"),
        (lambda d: d["placements"][0]["poses"][0].update(joints_deg=[500.0] * 6), "config 100: joint 1"),
        (lambda d: d["placements"][0]["poses"][0].update(aimed_mm=[300.0]), "lengths, one per leg"),
        (lambda d: d["placements"][0]["poses"][0].update(leg=[]), 'unknown key "leg"'),
        (lambda d: d["placements"][0].update(cups_mm=[[0, 0, 0]] * 3), "mm from the planned cup"),
        (lambda d: d.update(placements=3), 'key "placements" must be a list'),
    ],
)
def test_a_plan_that_does_not_go_with_the_cell_is_refused(change, sentence):
    document = json.loads(json.dumps(drawn_up()))
    change(document)

    with pytest.raises(ScenarioError, match=sentence):
        recorded(plan=plan_from(document, "plan.json"))


def test_a_ballbar_without_range_is_refused():
    with pytest.raises(ScenarioError, match="range_mm"):
        BallbarSetup(range_mm=0.0)


def test_the_command_writes_both_campaigns_of_the_robot_and_the_truth(tmp_path):
    plan, out = tmp_path / "plan.json", tmp_path / "out"
    plan.write_text(json.dumps(drawn_up()))
    wishes = ["--seed", "3", "--quiet", "--aimed", "--configurations", "6", "--validation", "7"]

    assert main(["lrmate-everyday", *wishes, "--ballbar", str(plan), "--out", str(out)]) == 0
    documents = {
        name: json.loads((out / f"{name}.json").read_text()) for name in ("campaign", "tracker", "truth")
    }
    assert documents["campaign"]["kind"] == "ballbar"
    assert set(documents["campaign"]["files"]) == {"legs", "setup", "fixture", "cups", "validation"}
    assert set(documents["tracker"]["files"]) == {"calibration", "validation", "reference"}
    rows = {path.stem: list(csv.DictReader(path.read_text().splitlines())) for path in out.glob("*.csv")}
    assert {name: len(table) for name, table in rows.items() if name != "fixture"} == {
        "legs": 12,
        "setup": 3,
        "cups": 3,
        "calibration": 6,
        "validation": 7,
        "true_validation": 21,
        "reference": 6,
    }
    assert rows["legs"][0]["u_mm"] == "0.00158"
    assert len(documents["truth"]["cups"]) == 3


@pytest.mark.parametrize("text", ["{", "[]"])
def test_a_plan_file_that_is_none_is_refused_by_its_name(tmp_path, capsys, text):
    plan = tmp_path / "plan.json"
    plan.write_text(text)

    assert main(["lrmate-tilted", "--ballbar", str(plan), "--out", str(tmp_path / "out")]) == 2
    assert "plan.json" in capsys.readouterr().err


async def test_a_campaign_is_what_a_person_would_have_measured_in_the_cell():
    scenario = replace(NOISE_FREE, ballbar=BallbarSetup(range_mm=3.0))
    recording = recorded(scenario)
    cell = Cell(scenario, 3, CellClock(0))

    await clamp_all(cell)
    lengths = []
    for joints_deg, legs in zip(POSES, LEGS, strict=True):
        await move(cell, joints_deg)
        cell.hands.do("calibrator", {"bars": "base"})
        for base, tool in legs:
            cell.hands.do("connect", {"base": base, "tool": tool})
            lengths.append(300.0 + cell.ballbar.sample(cell.clock.now_s).deviation_mm)
        cell.hands.do("detach", {})

    clamped = np.array([cup.place_mm for cup in cell.fixture.cups])
    assert clamped == pytest.approx(recording.cups.true_mm, abs=1e-9)
    assert lengths == pytest.approx(recording.legs.length_mm, abs=1e-9)
