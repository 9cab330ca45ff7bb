import json

import numpy as np
import pytest

from truepose_simulators.faults.kinds import TrackerBlinded
from truepose_simulators.instruments.truth_endpoint import answer


def ask(cell, **request):
    return json.loads(json.dumps(answer(json.dumps(request).encode(), cell), allow_nan=False))


async def test_positions_are_those_of_the_arm_approached_from_below(make_cell):
    cell = make_cell(seed=2)
    joints = np.random.default_rng(1).uniform(-1, 1, (5, 6))
    stops = cell.conditions(joints, np.ones((5, 6)), np.zeros(5), np.ones(5))

    all_nests = np.array(ask(cell, op="positions", joints_rad=joints.tolist())["positions_mm"])
    one_each = ask(cell, op="positions", joints_rad=joints.tolist(), nests=[1, 2, 3, 1, 2])["positions_mm"]

    assert np.array_equal(all_nests, cell.true_positions(stops))
    assert np.array_equal(one_each, all_nests[np.arange(5), [0, 1, 2, 0, 1]])


def test_asking_for_the_truth_neither_takes_time_nor_draws_noise(make_cell):
    cell, untouched = make_cell(seed=2), make_cell(seed=2)

    ask(cell, op="positions", joints_rad=[[0.1] * 6])
    ask(cell, op="plant")
    ask(cell, op="aim")

    assert cell.clock.now_s == 0.0
    assert cell.rng.normal() == untouched.rng.normal()


def test_a_planted_change_shows_in_the_truth_from_its_time_on(make_cell):
    cell = make_cell(seed=2)
    ask(cell, op="effect", name="joint_gain", subject="joint 1", amplitude=1e-3, from_s=50.0)
    joints = [[1.0, 0, 0, 0, 0, 0]] * 2

    positions = ask(cell, op="positions", joints_rad=joints, time_s=[0.0, 50.0], nests=[1, 1])["positions_mm"]

    moved = np.linalg.norm(np.subtract(*positions))
    assert moved == pytest.approx((374.0 + 125.0) * 1e-3, rel=0.01)  # link errors: 1 mm in 499


def test_a_planted_change_may_say_more_and_the_plant_tells_it_all(make_cell):
    cell = make_cell(seed=2)

    assert ask(cell, op="effect", name="joint_harmonics", subject="joint 6", amplitude=0.03, order=2) == {}

    wave = {"name": "joint_harmonics", "subject": "joint 6", "amplitude": 0.03, "from_s": 0.0, "order": 2}
    assert ask(cell, op="plant")["effects"] == [wave]


def test_a_planted_nest_offset_is_among_the_true_nests(make_cell):
    cell = make_cell(seed=2)
    before = ask(cell, op="plant")["tool_nests_mm"]

    ask(cell, op="effect", name="nest_offset", subject="nest 2", amplitude=0.06, direction=[0, 0, 1])

    moved = np.subtract(ask(cell, op="plant")["tool_nests_mm"], before)
    assert moved == pytest.approx(np.array([[0, 0, 0], [0, 0, 0.06], [0, 0, 0]]), abs=1e-12)


def test_the_plant_is_told_in_full(make_cell):
    cell = make_cell("irb120-clean", seed=2)

    plant = ask(cell, op="plant")

    assert plant["robot"] == "irb120"
    assert plant["seed"] == 2
    assert np.array_equal(plant["links"], cell.plant.motions[1:7])
    assert np.array_equal(plant["base"], cell.plant.motions[0])
    assert plant["links"][2][4] == 0.0
    assert np.array_equal(plant["tool_nests_mm"], cell.tool_nests_mm)
    rotation = np.array(plant["tracker_frame"]["rotation"])
    assert rotation @ rotation.T == pytest.approx(np.eye(3), abs=1e-12)


def test_an_operators_aim_is_good_to_about_20_mm(make_cell):
    cell = make_cell(seed=2)
    frame = ask(cell, op="plant")["tracker_frame"]

    aims = np.array(ask(cell, op="aim")["fixed_nests_seen_from_tracker_mm"])

    seen = (cell.fixed_nests_mm() - frame["translation_mm"]) @ np.array(frame["rotation"])
    assert np.abs(aims - seen).max() <= 10.0
    assert not (aims % 20.0).any()


def test_mounting_the_tool_anew_counts_attachments(make_cell):
    cell = make_cell()

    assert ask(cell, op="attach") == {"attachment": 2}
    assert cell.attachment == 2


def test_a_fault_may_be_scripted_while_the_cell_runs(make_cell):
    cell = make_cell()

    assert ask(cell, op="fault", kind="tracker_blinded") == {}
    assert cell.faults.holds(TrackerBlinded, 0.0)


@pytest.mark.parametrize(
    ("request_", "sentence"),
    [
        ({"op": "positions"}, 'key "joints_rad" must be a list of rows of 6 angles'),
        ({"op": "positions", "joints_rad": [[1, 2, 3]]}, 'key "joints_rad" must be a list of rows of 6'),
        ({"op": "positions", "joints_rad": [[1] * 6, [1]]}, 'key "joints_rad" must hold numbers'),
        ({"op": "positions", "joints_rad": "x"}, 'key "joints_rad" must be a list of rows of 6'),
        ({"op": "positions", "joints_rad": [["x"] * 6]}, 'key "joints_rad" must hold numbers'),
        (
            {"op": "positions", "joints_rad": [[0] * 6], "nests": [4]},
            'key "nests" must have 1 entries from 1',
        ),
        ({"op": "positions", "joints_rad": [[0] * 6], "nests": [1, 2]}, 'key "nests" must have 1 entries'),
        (
            {"op": "positions", "joints_rad": [[0] * 6], "time_s": [1, 2]},
            'key "time_s" must be one time or 1',
        ),
        (
            {"op": "positions", "joints_rad": [[0] * 6], "time_s": 1e308},
            'key "time_s" must lie within 1e+09 s',
        ),
        ({"op": "positions", "joints_rad": [[None] * 6]}, 'key "joints_rad" must hold finite numbers'),
        ({"op": "effect", "name": "joint_gain"}, 'key "subject" is missing'),
        (
            {"op": "effect", "name": "joint_gain", "subject": "joint 3", "amplitude": 1e-3, "form_s": 9},
            'effect joint_gain: unknown key "form_s"',
        ),
        (
            {"op": "effect", "name": "payload", "subject": "tool", "amplitude": 1e300},
            "effect payload: amplitude must be -20 to 20, not 1e+300",
        ),
        ({"op": "fault", "kind": "smr_missing", "nest": 9}, 'key "nest" must be 1 to 3, not 9'),
        ({"op": "fault", "kind": "smr_missing", "nest": "1"}, 'key "nest" must be a whole number'),
        ({"op": ["plant"]}, 'key "op" must be one of positions, plant'),
        ([1], 'a request is an object such as {"op": "plant"}'),
    ],
)
def test_an_impossible_request_is_answered_with_a_sentence(make_cell, request_, sentence):
    reply = answer(json.dumps(request_).encode(), make_cell())

    assert sentence in reply["error"]


def test_a_line_that_is_no_json_is_answered_with_a_sentence(make_cell):
    assert "not JSON" in answer(b"\xff{", make_cell())["error"]
