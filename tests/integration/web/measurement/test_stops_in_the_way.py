"""Given stops at which the arm would touch floor, table or itself are refused, and at the act too."""

from math import radians

import pytest

from tests.helpers.web.clients import command, served
from tests.integration.web.ballbar_bench import BALLBAR, PLACEMENT
from tests.integration.web.bench import CELL, SESSIONS, begun, session_request, stops
from tests.integration.web.conftest import asking
from truepose_drivers.errors import ConnectionLostError

START = {"command": "start", "person": "Ada"}
BELOW = [0.0, 90.0, 0.0, 0.0, 90.0, 0.0]  # the tool looks down from the outstretched arm
ON_A_PEDESTAL = "[base_in_world]\nx_mm = 0\ny_mm = 0\nz_mm = 800\nrx_deg = 0\nry_deg = 0\nrz_deg = 0\n"
LOW_FLOOR = "[limits]\nfloor_z_mm = -300\n"


def given(*joints_deg):
    return {
        "method": "given",
        "stops": [stop | {"joints_deg": q} for stop, q in zip(stops(9), joints_deg, strict=False)],
    }


async def test_a_stop_with_a_nest_below_the_table_is_refused_with_stop_body_and_depth(client):
    refused = await client.post(SESSIONS, json=session_request(plan=given(stops(1)[0]["joints_deg"], BELOW)))

    assert refused.status_code == 409
    sentence = refused.json()["detail"]
    assert "configuration 2" in sentence
    assert "tool nest" in sentence
    assert "mm below floor or table" in sentence


async def test_an_approach_below_the_table_is_refused(client):
    wanted = session_request(plan=given(BELOW), approach_offset_deg=20.0)

    assert (await client.post(SESSIONS, json=wanted)).status_code == 409


@pytest.mark.parametrize("base", [ON_A_PEDESTAL, LOW_FLOOR])
async def test_a_robot_that_stands_high_or_has_a_low_floor_may_go_there(settings, bench, base):
    settings.cell_file.write_text(CELL.replace("[[fixed_nest]]", base + "[[fixed_nest]]", 1))
    async with served(settings, bench.registry()) as client:
        answer = await client.post(SESSIONS, json=session_request(plan=given(BELOW)))

    assert answer.status_code == 201, answer.text


async def test_a_floor_that_is_stated_higher_since_binds_at_the_start(settings, bench):
    for floor, path in (("", SESSIONS), ("[limits]\nfloor_z_mm = 900.0\n", f"{SESSIONS}/1/commands")):
        settings.cell_file.write_text(CELL + floor)
        async with served(settings, bench.registry()) as client:
            answer = await client.post(path, json=START if floor else session_request())

    assert answer.status_code == 409
    assert "below floor or table" in answer.json()["detail"]
    assert bench.robot.moves == 0


BEFORE = [-80.0, 80.0, -40.0, 0.0, -70.0, -130.0]
BEYOND = [-40.0, 80.0, -30.0, -40.0, 90.0, -20.0]  # above the table as well; the way there leads through it
DEPTH = "tool nest 2 would be 76 mm below floor or table"


@pytest.fixture
async def on_a_stated_floor(settings, bench):
    settings.cell_file.write_text(CELL + "[limits]\nfloor_z_mm = 0.0\n")
    async with served(settings, bench.registry()) as client:
        yield client


async def test_a_way_through_a_stated_floor_is_refused_with_both_configurations(on_a_stated_floor):
    refused = await on_a_stated_floor.post(SESSIONS, json=session_request(plan=given(BEFORE, BEYOND)))

    assert refused.status_code == 409
    sentence = refused.json()["detail"]
    assert "from configuration 1 to the approach to configuration 2" in sentence
    assert DEPTH in sentence
    assert "Change the order" in sentence


async def test_a_way_through_an_assumed_floor_is_said_at_the_planning_and_before_the_confirmation(client):
    wanted = session_request(plan=given(BEFORE, BEYOND))
    key = {"Idempotency-Key": "once"}
    planned, repeated = [await client.post(SESSIONS, json=wanted, headers=key) for _ in range(2)]
    started = await command(client, planned.headers["Location"], "start")

    assert planned.status_code == 201, planned.text
    (note,) = repeated.json()["notes"]
    assert DEPTH in note
    assert planned.json()["notes"] == [note]
    assert DEPTH in started.json()["sentence"]
    assert DEPTH in started.json()["session"]["prompt"]["message"]


async def test_of_clear_ways_nothing_is_said(client):
    planned = await client.post(SESSIONS, json=session_request())
    started = await command(client, planned.headers["Location"], "start")

    assert planned.json()["notes"] == []
    assert (
        "until a session has been completed. The robot is about to move."
        in started.json()["session"]["prompt"]["message"]
    )


async def test_the_way_from_where_a_connected_arm_stands_is_looked_at(client, bench):
    await bench.robot.connect()
    await bench.robot.move_joints(tuple(radians(angle) for angle in BEFORE))
    wanted = session_request(plan=given(BEYOND))

    planned = await client.post(SESSIONS, json=wanted)
    started = await command(client, planned.headers["Location"], "start")

    assert planned.json()["notes"] == []
    sentence = started.json()["sentence"]
    assert "from the present position of the arm to the approach to configuration 1" in sentence
    assert DEPTH in started.json()["sentence"]


async def test_a_robot_that_does_not_say_where_it_stands_keeps_no_question_waiting(client, bench):
    async def fail():
        raise ConnectionLostError("the link is gone")

    await bench.robot.connect()
    bench.robot.read_joints = fail
    planned = await client.post(SESSIONS, json=session_request(plan=given(BEYOND)))
    started = await command(client, planned.headers["Location"], "start")

    assert (
        "until a session has been completed. The robot is about to move."
        in started.json()["session"]["prompt"]["message"]
    )


SEEN = [12.0, 55.0, 11.0, -127.0, 80.0, 145.0]  # by the tracker; the way to it leads through the table
MORE = {"person": "Ada", "configurations": [{"joints_deg": SEEN}]}


async def test_an_added_configuration_behind_a_stated_floor_is_refused(on_a_stated_floor):
    planned = await on_a_stated_floor.post(SESSIONS, json=session_request(plan=given(BEFORE)))
    refused = await on_a_stated_floor.post(f"{planned.headers['Location']}/configurations", json=MORE)

    assert refused.status_code == 409, refused.text
    assert "from configuration 1 to the approach to configuration 2" in refused.json()["detail"]


async def test_an_added_configuration_behind_an_assumed_floor_is_said(client, bench, until):
    await bench.robot.connect()
    bench.robot.gate.clear()
    path = await begun(client, plan=given(BEFORE))
    await bench.robot.sent.wait()

    added = await client.post(f"{path}/configurations", json=MORE)
    bench.robot.gate.set()
    await asking(client)(path, "state", "awaiting_confirmation")
    question = (await client.get(path)).json()["prompt"]["message"]

    assert "tool nest 2 would be 75 mm below floor or table" in added.json()["sentence"]
    assert "from the present position of the arm to the approach to configuration 2" in question
    assert "tool nest 2 would be 75 mm below floor or table" in question


def ballbar_session(*joints_deg):
    poses = [pose | {"joints_deg": q} for pose, q in zip(PLACEMENT["poses"], joints_deg, strict=True)]
    return {"kind": "ballbar", "name": "six legs", "placements": [PLACEMENT | {"poses": poses}]}


@pytest.mark.parametrize(("floor", "status"), [("", 201), ("[limits]\nfloor_z_mm = 0.0\n", 409)])
async def test_a_way_of_a_given_ballbar_plan_is_judged_as_one_of_a_tracker_plan(
    settings, bench, floor, status
):
    settings.cell_file.write_text(CELL + BALLBAR + floor)
    async with served(settings, bench.registry()) as client:
        planned = await client.post(SESSIONS, json=ballbar_session(BEFORE, BEYOND))
        notes = (await client.get(f"{SESSIONS}/1")).json().get("notes")

    assert planned.status_code == status, planned.text
    said = planned.json()["detail"] if floor else notes[0]
    assert "placement-1/pose-1" in said
    assert "below floor or table" in said


async def test_a_pose_of_a_given_ballbar_plan_below_the_table_is_refused(settings, bench):
    settings.cell_file.write_text(CELL + BALLBAR)
    async with served(settings, bench.registry()) as client:
        refused = await client.post(SESSIONS, json=ballbar_session(BEFORE, BELOW))

    assert refused.status_code == 409
    assert "The target of step placement-1/pose-2/move is not possible: tool nest" in refused.json()["detail"]


async def test_a_way_through_a_floor_that_is_stated_since_is_refused_at_the_start(settings, bench):
    wanted = session_request(plan=given(BEFORE, BEYOND))
    for floor, path in (("", SESSIONS), ("[limits]\nfloor_z_mm = 0.0\n", f"{SESSIONS}/1/commands")):
        settings.cell_file.write_text(CELL + floor)
        async with served(settings, bench.registry()) as client:
            answer = await client.post(path, json=START if floor else wanted)

    assert answer.status_code == 409
    assert DEPTH in answer.json()["detail"]
    assert bench.robot.moves == 0
