"""Ballbar sessions over REST: planned, walked through, found again after a restart."""

import asyncio

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, served
from tests.integration.web.ballbar_bench import PLACEMENT, SESSIONS, WANTED, Tablet, with_ballbar
from tests.integration.web.bench import Bench, planned
from tests.integration.web.leaving_clients import LeavingClient, Waiting


@pytest.fixture
def settings(settings):
    return with_ballbar(settings)


@pytest.fixture
async def tablet(client):
    created = await client.post(SESSIONS, json=WANTED)
    assert created.status_code == 201, created.text
    return Tablet(client)


async def until_step(tablet, step_id):
    async with asyncio.timeout(HANGS_S):
        while (session := await tablet.see())["step"]["id"] != step_id:
            await asyncio.sleep(0.005)
    return session


async def until_step_after(tablet, step_id):
    async with asyncio.timeout(HANGS_S):
        while (await tablet.see())["step"]["id"] == step_id:
            await asyncio.sleep(0.005)


async def test_a_planned_session_lists_its_steps_before_the_start(client, tablet):
    session = await tablet.see()
    steps = (await client.get(f"{tablet.path}/plan")).json()["steps"]

    assert (session["state"], session["step"]["id"], session["simulated"]) == (
        "planned",
        "tool/initialise",
        False,
    )
    assert session["commands"] == ["abort", "start"]
    assert {step["outcome"] for step in steps} == {"open"}
    assert len(steps) == session["step"]["count"]
    assert [step["points"] for step in steps if step["id"].startswith("tool/side")] == [
        ["T1", "T2"],
        ["T2", "T3"],
        ["T1", "T3"],
    ]
    legs = [step for step in steps if "/pose-2/leg-" in step["id"]]
    assert [leg["points"] for leg in legs][3] == ["B2", "T3"]
    assert {tuple(leg["bars_mm"]) for leg in legs} == {(150.0, 50.0)}
    assert steps[0]["kind"] == "initialise"
    assert (await client.get(tablet.path)).json()["role"] == "ballbar"
    assert (await client.get(f"{tablet.path}/progress")).status_code == 200


async def test_a_planned_session_says_beforehand_where_swaps_are_hardly_seen(tablet):
    session = await tablet.see()

    poses = session["unseen_swaps_poses"]
    assert set(poses) <= {1, 2}
    assert bool(session["unseen_swaps"]) == bool(poses)
    assert session["legs_alike"] == []


async def test_the_list_of_sessions_has_both_kinds(client, tablet):
    await planned(client)

    listed = (await client.get("/api/v1/sessions")).json()

    assert [(entry["id"], entry["role"], entry["planned"]) for entry in listed] == [
        (1, "ballbar", 2),
        (2, "calibration", 3),
    ]


async def test_a_length_is_kept_with_everything_that_it_rests_on(client, tablet, bench):
    bench.ballbar.deviation_mm = 0.0123
    await tablet.press("start")

    stored = await tablet.press("store", step_id="tool/initialise")
    while stored.status_code == 409:  # until there is a sample; or it was stored by itself
        if (await tablet.see())["step"]["id"] != "tool/initialise":
            break
        stored = await tablet.press("store", step_id="tool/initialise")

    (entry,) = [entry for entry in await tablet.ledger() if entry["kind"] == "measured"]
    assert entry["length"]["length_mm"] == 150.0
    assert entry["length"]["deviation_mm"] == pytest.approx(0.0123, abs=1e-9)
    assert entry["length"]["instrument_serial"] == "42"
    assert entry["length"]["temperature_c"] == 23.0
    assert entry["recorded_at"].endswith("+00:00")


async def test_a_repeated_act_gets_the_same_answer_and_is_done_once(tablet):
    first = (await tablet.press("start", key="k1")).json()
    again = (await tablet.press("start", key="k1")).json()

    assert (again["sentence"], again["entry"]) == (first["sentence"], first["entry"])
    assert first["session"]["state"] == "running"
    assert [e["number"] for e in await tablet.ledger() if e["key"] == "k1"] == [first["entry"]]


async def test_acts_with_one_key_that_come_at_once_are_one(tablet):
    answers = await asyncio.gather(*(tablet.press("start", key="k1") for _ in range(5)))

    assert {answer.json()["entry"] for answer in answers} == {1}
    assert len([e for e in await tablet.ledger() if e["key"] == "k1"]) == 1


async def test_the_key_of_an_act_is_not_for_another_act(tablet):
    await tablet.press("start", key="k1")

    refused = await tablet.press("abort", key="k1")

    assert refused.status_code == 409
    assert "another command" in refused.json()["detail"]
    assert (await tablet.see())["state"] == "running"


async def test_a_step_that_is_no_longer_there_is_refused_and_the_key_stays_free(tablet):
    await tablet.press("start")
    await until_step_after(tablet, "tool/initialise")

    refused = await tablet.press("store", key="k", step_id="tool/initialise")

    assert refused.status_code == 409
    assert (await tablet.press("abort", key="k")).status_code == 200


async def test_a_tablet_that_watches_does_not_act_until_it_takes_over(client, tablet):
    await tablet.press("start")
    other = Tablet(client, "tablet-2")

    refused = await other.press("pause")
    taken = await other.press("hand_over")

    assert refused.status_code == 409
    assert taken.json()["session"]["acting"] == {"tablet": "tablet-2", "person": "Ada"}
    assert (await tablet.press("pause")).status_code == 409
    assert (await other.press("pause")).json()["session"]["state"] == "paused"


async def test_pages_of_the_ledger_follow_its_numbers(tablet):
    await tablet.press("start")
    await tablet.press("pause")

    entries = await tablet.ledger()
    rest = await tablet.ledger(after=entries[0]["number"], limit=1)

    assert [entry["number"] for entry in rest] == [entries[1]["number"]]


async def test_one_session_runs_at_a_time_whichever_its_instrument(client, tablet):
    await tablet.press("start")
    await planned(client)
    await client.post(SESSIONS, json=WANTED)

    tracker = await command(client, "/api/v1/sessions/2", "start")
    ballbar = await Tablet(client, session_id=3).press("start")

    for refused in (tracker, ballbar):
        assert refused.status_code == 409
        assert "Session 1" in refused.json()["detail"]


async def test_of_two_sessions_of_both_kinds_that_start_at_once_one_starts(client, tablet):
    await planned(client)

    answers = await asyncio.gather(command(client, "/api/v1/sessions/2", "start"), tablet.press("start"))
    states = [session["state"] for session in (await client.get("/api/v1/sessions")).json()]

    assert sorted(answer.is_success for answer in answers) == [False, True]
    assert sorted(answer.status_code for answer in answers)[1] == 409
    assert states.count("planned") == 1


async def test_a_tracker_session_is_no_ballbar_session(client):
    await planned(client)

    assert (await client.get(f"{SESSIONS}/1/situation")).json()["kind"] == "tracker"
    assert "stops" in (await client.get(f"{SESSIONS}/1/plan")).json()
    assert (await client.get(f"{SESSIONS}/1/ledger")).json() == {"entries": []}


async def test_a_session_that_was_never_started_can_be_ended(tablet):
    ended = (await tablet.press("abort")).json()

    assert ended["session"]["state"] == "aborted"
    assert (await tablet.press("start")).status_code == 409


async def test_a_plan_beyond_the_joints_is_refused_when_it_is_made(client):
    pose = {**PLACEMENT["poses"][0], "joints_deg": [700.0, 20, 0, 0, 40, 0]}
    wanted = {**WANTED, "placements": [{**PLACEMENT, "poses": [pose]}]}

    refused = await client.post(SESSIONS, json=wanted)

    assert refused.status_code == 409
    assert "joint 1" in refused.json()["detail"]


async def test_the_scene_before_the_start_shows_the_robot_only(client, tablet):
    scene = (await client.get(f"{tablet.path}/scene")).json()

    assert scene["points"] == []
    assert scene["leg"] is None
    assert scene["before_move_arm_mm"] is None
    assert scene["arm_mm"] == [[0.0, 0.0, 0.0]]  # nobody has moved the arm yet


async def test_after_a_restart_the_same_step_is_shown_and_nothing_moves_before_a_person_confirms(
    settings, bench
):
    async with served(settings, bench.registry()) as client:
        await client.post(SESSIONS, json=WANTED)
        tablet = Tablet(client)
        await tablet.press("start", key="k1")
        before = await until_step(tablet, "tool/side-1-2")

    again = Bench()
    async with served(settings, again.registry()) as client:
        tablet = Tablet(client)
        async with asyncio.timeout(HANGS_S):
            while (after := await tablet.see())["state"] != "awaiting_confirmation":
                await asyncio.sleep(0.005)
        repeated = await tablet.press("start", key="k1")

        assert after["step"]["id"] == before["step"]["id"]
        assert repeated.json()["entry"] == 1
        assert repeated.json()["session"]["state"] == "awaiting_confirmation"
        assert again.robot.moves == 0
        assert (await tablet.press("confirm")).json()["session"]["state"] == "running"


async def test_a_word_from_before_a_stop_does_not_end_it(tablet):
    begun = await tablet.press("start")
    await tablet.press("stop")
    assert (await tablet.see())["state"] == "awaiting_confirmation"
    pressed_at_s = float(begun.headers["Truepose-Time"]) - 10

    late = await tablet.press("confirm", step_id="tool/initialise", pressed_at_s=pressed_at_s)

    assert late.status_code == 409
    assert (await tablet.see())["state"] == "awaiting_confirmation"
    assert (await tablet.press("confirm")).status_code == 200


async def test_simulated_hands_do_what_they_are_told(client, tablet, bench):
    told = await client.get("/api/v1/simulated-hands")
    done = await client.post("/api/v1/simulated-hands", json={"action": "connect", "base": 2, "tool": 3})

    assert told.json()["simulated"] is True
    assert done.status_code == 204
    assert bench.hands.done == [("connect", {"base": 2, "tool": 3})]


async def test_what_the_hands_cannot_do_is_said_in_one_sentence(client, tablet, bench):
    bench.hands.refusal = "The bars are not on."

    refused = await client.post("/api/v1/simulated-hands", json={"action": "detach"})

    assert (refused.status_code, refused.json()["detail"]) == (409, "The bars are not on.")


async def test_the_base_is_put_where_the_session_under_way_wants_it(client, tablet, bench):
    await tablet.press("start")

    await client.post("/api/v1/simulated-hands", json={"action": "place_base", "placement": 1})

    action, details = bench.hands.done[-1]
    assert action == "place_base"
    assert (details["x_mm"], details["z_mm"], details["rz_deg"]) == (350.0, 50.0, 0.0)


@pytest.mark.parametrize(
    ("session_ids", "says"), [([1], "no valid ballbar length"), ([2, 1], "ballbar")], ids=["alone", "judging"]
)
async def test_a_session_without_a_leg_makes_no_campaign_and_judges_none(client, tablet, session_ids, says):
    await planned(client)

    refused = await client.post("/api/v1/campaigns", json={"session_ids": session_ids})

    assert refused.status_code == 409
    assert says in refused.json()["detail"]


async def test_a_session_that_was_not_started_leaves_the_devices_to_others(client, tablet):
    too_early = await tablet.press("pause")

    assert too_early.status_code == 409
    await planned(client)
    assert (await command(client, "/api/v1/sessions/2", "start")).status_code == 200


async def test_a_plan_ends_with_the_connection_of_whoever_asked_for_it(app, client):
    planning = Waiting()
    app.state.context.ballbar_sessions._choose = planning
    leaving = LeavingClient(
        app, SESSIONS, b'{"kind": "ballbar", "name": "six legs", "poses": 6}', "application/json"
    )
    async with asyncio.timeout(HANGS_S):
        await planning.begun.wait()

    await leaving.leave()

    assert planning.ended.is_set()
    assert (await client.get("/api/v1/sessions")).json() == []


SIX_POSES = {"kind": "ballbar", "name": "six legs", "poses": 6}
LATER = {"Prefer": "wait=5, respond-async"}


class Chooser:
    """A worker that chooses what it was told to, once it may."""

    def __init__(self, plan):
        self.plan = plan
        self.may = asyncio.Event()

    async def __call__(self, task, told):
        await told(0.5, "choosing placements and poses")
        await self.may.wait()
        return self.plan


@pytest.fixture
async def chooser(app, tablet):
    chosen = Chooser((await app.state.context.ballbar_sessions.view(1)).plan)
    app.state.context.job_desk._queue._perform = chosen
    return chosen


async def test_poses_are_chosen_by_a_job_where_that_is_preferred(client, chooser, until):
    told = await client.post(SESSIONS, json=SIX_POSES, headers=LATER)
    running = await until(told.headers["Location"], "message", "choosing placements and poses")
    chooser.may.set()
    job = await until(told.headers["Location"], "state", "succeeded", "failed")

    assert (told.status_code, told.headers["Preference-Applied"]) == (202, "respond-async")
    assert (running["kind"], running["request"]["poses"]) == ("ballbar_plan", 6)
    assert running["fraction"] >= 0.5 and running["remaining_s"] > 0
    assert (await client.get(job["result_url"])).json()["name"] == "six legs"
    assert f'href="/sessions/{job["result_id"]}"' in (await client.get(f"/jobs/{job['id']}")).text


async def test_a_plan_that_is_cancelled_leaves_no_session(client, chooser, until):
    told = await client.post(SESSIONS, json=SIX_POSES, headers=LATER)
    await until(told.headers["Location"], "state", "running")

    cancelled = await client.post(f"{told.headers['Location']}/cancel")

    assert cancelled.json()["state"] == "cancelled"
    assert len((await client.get("/api/v1/sessions")).json()) == 1  # the one that is there from the start


async def test_given_poses_need_no_job(client, tablet):
    made = await client.post(SESSIONS, json=WANTED, headers=LATER)

    assert (made.status_code, made.json()["name"]) == (201, "six legs")


async def test_a_sphere_test_without_a_place_is_no_job(client, tablet):
    refused = await client.post(SESSIONS, json=_SPHERE, headers=LATER)

    assert refused.status_code == 422
    assert (await client.get("/api/v1/jobs")).json() == []


async def test_a_tracker_session_moves_nothing_while_the_ballbar_hangs_where_it_was_left(
    client, bench, until
):
    """As after a session with the ballbar that was ended early: nobody was asked to take it off."""
    path = await planned(client)
    await command(client, path, "start")

    left_on = await command(client, path, "confirm")

    assert left_on.status_code == 409
    assert "from the last session" in left_on.json()["detail"]
    assert bench.robot.moves == 0
    bench.ballbar.deviation_mm = -17.2  # run to its end
    assert (await command(client, path, "confirm")).is_success
    assert (await until(path, "state", "finished", "failed"))["state"] == "finished"


_SPHERE = {"kind": "ballbar", "name": "sphere", "plan": {"method": "sphere"}}


@pytest.mark.parametrize(
    ("placements", "says"),
    [
        (None, "give exactly one placement of the fixture"),
        ([PLACEMENT], "give the placement without poses"),
        ([{"x_mm": 1500, "y_mm": 0, "z_mm": 150}], "cannot hold the setting ball"),
    ],
)
async def test_a_sphere_test_without_a_place_for_its_ball_is_refused(client, placements, says):
    refused = await client.post(SESSIONS, json=_SPHERE | {"placements": placements})

    assert refused.status_code == 422
    assert says in refused.json()["detail"]


async def test_a_sphere_test_by_a_model_that_there_is_not_is_refused(client):
    wanted = _SPHERE | {"plan": {"method": "sphere", "model_id": 99}}

    assert (await client.post(SESSIONS, json=wanted)).status_code == 404
