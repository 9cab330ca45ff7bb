"""Sessions over REST: planned, confirmed by a person, paused, ended, found again."""

import asyncio
import threading

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, served
from tests.integration.web.bench import SESSIONS, Bench, begun, planned, session_request, stops
from truepose.sessions.tracker import service


async def running(client, bench):
    """A session whose first motion has begun and does not end yet."""
    bench.robot.gate.clear()
    path = await begun(client)
    await asyncio.wait_for(bench.robot.sent.wait(), HANGS_S)
    return path


async def test_a_session_runs_from_plan_to_readings(client, until):
    path = await begun(client)

    session = await until(path, "state", "finished", "failed", "paused")
    readings = (await client.get(f"{path}/readings", params={"kind": "point"})).json()

    assert session["state"] == "finished", session["reason"]
    assert (session["planned"], session["measured"], session["skipped"]) == (3, 3, 0)
    assert [reading["point"]["config"] for reading in readings] == [1, 2, 3]
    assert readings[1]["point"]["commanded_deg"] == stops(3)[1]["joints_deg"]
    assert session["progress"]["done"] == 3
    assert session["registration"]["tracker_position_mm"] == pytest.approx([0, 0, 0], abs=1e-6)


async def test_the_first_session_of_a_robot_begins_with_its_dry_run_and_goes_at_reduced_speed(
    client, bench, until
):
    speeds, set_limits, questions = [], bench.robot.set_limits, []

    async def noted(limits):
        speeds.append(limits.tool_speed_mm_s)
        await set_limits(limits)

    bench.robot.set_limits = noted
    for _ in range(2):
        path = await planned(client, n=3)
        started = await command(client, path, "start")
        questions.append(started.json()["session"]["prompt"]["message"])
        await command(client, path, "confirm")
        await until(path, "state", "finished", "failed", "paused")

    first, second = questions
    assert first.startswith(
        "No session with this robot has been completed here yet. According to the dry run, this session has 3"
    )
    assert "limited to 250 mm/s until a session has been completed" in first
    assert second.startswith("The robot is about to move.")
    assert (speeds[0], speeds[-1]) == (250.0, 500.0)


@pytest.mark.parametrize("device", ["tracker", "robot"])
async def test_a_driver_that_fails_has_the_session_await_a_person_who_can_go_on(client, bench, until, device):
    asked = "measure_point" if device == "tracker" else "read_joints"
    answer = getattr(getattr(bench, device), asked)
    failed = []

    async def fail_once(**given):
        if bench.robot.moves == 2 and not failed:
            failed.append(True)
            raise KeyError("langid")
        return await answer(**given)

    setattr(getattr(bench, device), asked, fail_once)
    path = await begun(client)
    await until(path, "state", "running", "finished", "failed", "paused")

    waiting = await until(path, "state", "awaiting_confirmation", "finished", "failed", "paused")
    assert waiting["state"] == "awaiting_confirmation", waiting
    assert f"driver fake_{device} failed in {asked} (KeyError: 'langid')" in waiting["prompt"]["message"]
    await command(client, path, "confirm")

    session = await until(path, "state", "finished", "failed", "paused")
    assert (session["state"], session["measured"]) == ("finished", 3), session["reason"]


async def test_nothing_moves_before_a_named_person_has_confirmed(client, bench):
    path = await planned(client)

    started = await command(client, path, "start")
    nameless = await command(client, path, "confirm", person="  ")
    await asyncio.sleep(0.05)

    assert started.json()["session"]["state"] == "awaiting_confirmation"
    assert "Is the cell clear" in started.json()["session"]["prompt"]["message"]
    assert nameless.status_code == 422
    assert bench.robot.moves == 0


async def test_a_pause_says_that_the_motion_ends_first_and_then_holds(client, bench, until):
    path = await running(client, bench)

    answer = await command(client, path, "pause")
    bench.robot.gate.set()
    await until(path, "state", "paused")
    moves = bench.robot.moves
    await asyncio.sleep(0.05)

    assert "ends first" in answer.json()["sentence"]
    assert bench.robot.moves == moves
    assert (await command(client, path, "resume")).status_code == 200
    assert (await until(path, "state", "finished"))["measured"] == 3


async def test_an_aborted_session_keeps_its_readings(client, bench, until):
    path = await running(client, bench)

    await command(client, path, "abort")
    bench.robot.gate.set()
    session = await until(path, "state", "aborted")

    assert session["state"] == "aborted"
    assert (await client.get(f"{path}/readings")).json() != []


async def test_a_planned_session_can_be_ended_without_ever_moving(client, bench):
    path = await planned(client)

    answer = await command(client, path, "abort")

    assert answer.json()["session"]["state"] == "aborted"
    assert (await client.get(path)).json()["person"] == "Ada"
    assert (await command(client, path, "start")).status_code == 409


async def test_after_a_restart_the_session_awaits_a_person_and_then_goes_on(settings, bench):
    bench.robot.gate.clear()
    async with served(settings, bench.registry()) as client:
        path = await running(client, bench)

    later = Bench()
    async with served(settings, later.registry()) as client:
        found = (await client.get(path)).json()
        await asyncio.sleep(0.05)
        moves_before = later.robot.moves
        await command(client, path, "confirm", person="Grace")
        async with asyncio.timeout(HANGS_S):
            while (session := (await client.get(path)).json())["state"] != "finished":
                await asyncio.sleep(0.005)

    assert found["state"] == "awaiting_confirmation"
    assert "service was stopped" in found["reason"]
    assert moves_before == 0
    assert session["measured"] == 3


async def test_one_session_runs_at_a_time(client):
    first, second = await planned(client), await planned(client)
    await command(client, first, "start")

    refused = await command(client, second, "start")

    assert refused.status_code == 409
    assert refused.json()["detail"].startswith(
        "Session 1 is awaiting confirmation; only one session runs at a time"
    )


async def test_a_device_under_a_session_is_not_disconnected(client, bench):
    await running(client, bench)

    refused = await client.post("/api/v1/devices/tracker/disconnect")

    assert refused.status_code == 409
    assert "Session 1 is using the device 'tracker'" in refused.json()["detail"]


@pytest.mark.parametrize("action", ["pause", "resume", "confirm"])
async def test_what_cannot_be_asked_now_is_refused_with_the_state(client, action):
    path = await planned(client)

    refused = await command(client, path, action)

    assert refused.status_code == 409
    assert "planned" in refused.json()["detail"]


async def test_a_stop_beyond_a_joint_limit_is_refused_when_planned(client):
    far = [{"config": 1, "joints_deg": [0, 45, -30, 0, 500, 0], "nest": 1}]

    refused = await client.post(SESSIONS, json=session_request(plan={"method": "given", "stops": far}))

    assert refused.status_code == 409
    assert "oint 5" in refused.json()["detail"]


async def test_a_plan_sent_twice_with_one_key_is_one_session(client):
    key = {"Idempotency-Key": "left-arm-1"}

    first = await client.post(SESSIONS, json=session_request(), headers=key)
    again = await client.post(SESSIONS, json=session_request(), headers=key)
    other = await client.post(SESSIONS, json=session_request(name="other"), headers=key)

    assert first.json()["id"] == again.json()["id"]
    assert len((await client.get(SESSIONS)).json()) == 1
    assert other.status_code == 409
    assert "left-arm-1" in other.json()["detail"]


async def test_the_plan_can_be_read_back_in_degrees(client):
    path = await planned(client, approach_offset_deg=None)

    plan = (await client.get(f"{path}/plan")).json()

    assert [stop["joints_deg"] for stop in plan["stops"]] == [stop["joints_deg"] for stop in stops(3)]
    assert plan["approach_offset_deg"] is None


async def test_before_the_first_motion_progress_is_zero(client):
    path = await planned(client)

    progress = (await client.get(f"{path}/progress")).json()

    assert (progress["done"], progress["planned"]) == (0, 3)


async def test_a_plan_of_more_stops_than_anybody_measures_is_refused(client):
    refused = await client.post("/api/v1/sessions", json=session_request(5001))

    assert refused.status_code == 422
    assert "5000" in refused.json()["detail"]


async def test_a_plan_is_judged_off_the_loop_that_answers_everybody(client, monkeypatch):
    judged_on = []
    monkeypatch.setattr(service, "check_plan", lambda *_: judged_on.append(threading.current_thread().name))

    await planned(client)

    assert judged_on
    assert "MainThread" not in judged_on


@pytest.mark.parametrize("kind", ["laser", "", 5, None])
async def test_a_kind_that_there_is_not_is_refused_by_the_names_of_those_there_are(client, kind):
    refused = await client.post("/api/v1/sessions", json={**session_request(), "kind": kind})

    assert refused.status_code == 422
    assert "kind should be one of tracker, contact, ballbar" in refused.json()["detail"]
    assert (await client.get("/api/v1/sessions")).json() == []


async def test_a_fault_is_found_where_it_was_sent(client):
    none = {"method": "choose", "configurations": 0}
    joints = {"method": "given", "stops": [{"config": 1, "joints_deg": [0, "up"], "nest": 1}]}

    details = [
        (await client.post("/api/v1/sessions", json=session_request(plan=plan))).json()["detail"]
        for plan in (none, joints)
    ]

    assert [detail.partition(":")[0] for detail in details] == [
        "plan.configurations",
        "plan.stops.0.joints_deg.1",
    ]


@pytest.mark.parametrize("body", [[1, [{}], "tracker"], "tracker", 5, [], None])
async def test_a_body_that_is_no_object_is_refused_as_a_whole(client, body):
    refused = await client.post("/api/v1/sessions", json=body)

    assert refused.status_code == 422
    assert refused.json()["detail"].startswith("the body: ")
