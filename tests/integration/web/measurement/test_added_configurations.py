"""Configurations added over REST: to a planned session, to one under way, never after its end."""

import pytest

from tests.helpers.diagnosis.answers import make_diagnosis
from tests.helpers.web.clients import command
from tests.integration.web.bench import SESSIONS, Bench, measured, planned
from tests.integration.web.conftest import asking
from tests.integration.web.diagnosing import Diagnostician, served
from truepose.analysis.job_queue.tasks import stored_campaign
from truepose.domain.campaign import ReadingName, ReadingsSetAside

MORE = {
    "person": "Ada",
    "configurations": [{"joints_deg": [float(k), 42.0, -25.0, 0.0, 30.0, 0.0], "nest": 1} for k in (1, 2)],
}


@pytest.fixture
def worker():
    return Diagnostician()


@pytest.fixture
async def client(settings, bench, worker):
    async with served(settings, bench, worker) as (opened, _):
        yield opened


async def confirmed(client, path, question):
    """Let a person confirm, once the session asks what is expected of it."""
    await asking(client)(path, "state", "awaiting_confirmation")
    assert question in (await client.get(path)).json()["prompt"]["message"]
    await command(client, path, "confirm")


async def test_a_planned_session_measures_what_was_added(client, until):
    path = await planned(client)

    added = await client.post(f"{path}/configurations", json=MORE)
    plan = (await client.get(f"{path}/plan")).json()
    await command(client, path, "start")
    await confirmed(client, path, "Is the cell clear")
    session = await until(path, "state", "finished", "failed", "paused")

    assert added.status_code == 201
    assert [stop["config"] for stop in added.json()["stops"]] == [4, 5]
    assert added.json()["session"]["planned"] == 5
    assert added.json()["sentence"].startswith("Added configurations 4 to 5. A person confirms")
    assert [stop["joints_deg"] for stop in plan["stops"][3:]] == [
        entry["joints_deg"] for entry in MORE["configurations"]
    ]
    assert (session["planned"], session["measured"]) == (5, 5)


async def test_a_running_session_asks_a_person_before_it_goes_to_what_was_added(client, bench, until):
    bench.robot.gate.clear()
    path = await planned(client)
    await command(client, path, "start")
    await confirmed(client, path, "Is the cell clear")
    await bench.robot.sent.wait()

    added = await client.post(f"{path}/configurations", json=MORE)
    bench.robot.gate.set()
    await confirmed(client, path, "added to the plan")
    session = await until(path, "state", "finished", "failed", "paused")

    assert added.json()["session"]["state"] == "running"
    assert (session["measured"], session["progress"]["planned"]) == (5, 5)
    assert [change["person"] for change in session["states"]] == [None, None, "Ada", None, "Ada", None]


async def test_after_a_restart_what_was_added_is_still_measured(settings):
    async with served(settings, Bench(), None) as (client, _):
        path = await planned(client)
        await client.post(f"{path}/configurations", json=MORE)
        await command(client, path, "start")

    async with served(settings, Bench(), None) as (client, until):
        await command(client, path, "confirm", person="Grace")
        session = await until(path, "state", "finished", "failed", "paused")

    assert session["measured"] == 5


async def test_one_tap_sent_twice_adds_once(client):
    path, key = await planned(client), {"Idempotency-Key": "tap-1"}

    first = await client.post(f"{path}/configurations", json=MORE, headers=key)
    again = await client.post(f"{path}/configurations", json=MORE, headers=key)
    other = await client.post(f"{path}/configurations", json={**MORE, "person": "Eva"}, headers=key)

    assert again.json()["stops"] == first.json()["stops"]
    assert (await client.get(path)).json()["planned"] == 5
    assert other.status_code == 409


async def test_what_this_cell_cannot_measure_is_left_out_where_that_is_wanted(client):
    path = await planned(client)
    low = {"joints_deg": [0, 90, 40, 0, 30, 0], "nest": 1}
    wanted = {"person": "Ada", "configurations": [low, *MORE["configurations"]], "leave_out_unfit": True}

    added = (await client.post(f"{path}/configurations", json=wanted)).json()

    assert [stop["config"] for stop in added["stops"]] == [4, 5]
    assert [entry["configuration"] for entry in added["left_out"]] == [1]
    assert "table" in added["left_out"][0]["reason"]


async def test_two_additions_take_different_numbers(client):
    path = await planned(client)

    await client.post(f"{path}/configurations", json=MORE)
    second = await client.post(f"{path}/configurations", json=MORE)

    assert [(stop["config"], stop["repeat_of"]) for stop in second.json()["stops"]] == [(6, 4), (7, 5)]


async def test_a_session_that_has_ended_takes_no_more(client, until):
    path = await measured(client, until)

    refused = await client.post(f"{path}/configurations", json=MORE)

    assert refused.status_code == 409
    sentence = "Session 1 is finished; plan a new session for the remaining configurations."
    assert refused.json()["detail"] == sentence
    assert (await client.get(path)).json()["planned"] == 3


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        ({"configurations": []}, 422, "configurations"),
        ({"person": "  "}, 422, "person"),
        ({"configurations": [{"joints_deg": [0, 42, -25, 0, 30]}]}, 409, "needs 6 finite joint angles"),
        ({"configurations": [{"joints_deg": [0, 42, -25, 0, 500, 0], "nest": 1}]}, 409, "oint 5"),
        ({"configurations": [{"joints_deg": [0, 90, 40, 0, 30, 0], "nest": 1}]}, 409, "table"),
        ({"configurations": [{"joints_deg": [0, 42, -25, 0, 30, 0], "nest": 99}]}, 409, "no nest 99"),
        ({"reason": "why not"}, 422, "reason"),
    ],
)
async def test_what_cannot_be_added_is_refused_with_the_reason(client, change, status, words):
    path = await planned(client)

    refused = await client.post(f"{path}/configurations", json={**MORE, **change})

    assert (refused.status_code, refused.headers["content-type"]) == (status, "application/problem+json")
    assert words in refused.json()["detail"]
    assert (await client.get(path)).json()["planned"] == 3


async def test_nothing_is_added_to_what_is_not_there(client):
    assert (await client.post(f"{SESSIONS}/7/configurations", json=MORE)).status_code == 404


async def diagnosed_so_far(client, until, bench, **asked_for):
    """A session held in a motion, with a diagnosis of what it has measured so far."""
    path = await planned(client, 60)
    await command(client, path, "start")
    await confirmed(client, path, "Is the cell clear")
    await until(path, "measured", *range(1, 60))
    bench.robot.gate.clear()
    asked = await client.post(f"{path}/diagnosis", json=asked_for)
    await until(asked.headers["Location"], "state", "succeeded")
    return path


async def test_a_diagnosis_that_asked_for_more_is_run_again_when_the_session_has_it(
    client, until, bench, worker
):
    worker.found = [make_diagnosis(start_effects=("base", "tool", "geometry"))]
    path = await diagnosed_so_far(client, until, bench, effects=["base", "tool", "geometry"])

    await client.post(f"{path}/configurations", json={**MORE, "diagnosis_id": 1})
    bench.robot.gate.set()
    await confirmed(client, path, "added to the plan")
    await until(path, "state", "finished")
    job = await until("/api/v1/jobs/2", "state", "succeeded", "failed")
    again = (await client.get(job["result_url"])).json()

    first, second = (stored_campaign(task.campaign).calibration for task in worker.tasks)
    assert again["session_id"] == 1
    assert worker.tasks[1].effects == ("base", "tool", "geometry")
    assert (len(first) < 60, len(second)) == (True, 62)


async def test_readings_that_were_set_aside_stay_so_when_it_is_run_again(client, until, bench, worker):
    aside = ReadingsSetAside((ReadingName(1, 1),), "it slipped", "Ada Byron", (0,), ("it slipped",))
    worker.found = [make_diagnosis(set_aside=aside)]
    path = await diagnosed_so_far(client, until, bench)

    await client.post(f"{path}/configurations", json={**MORE, "diagnosis_id": 1})
    bench.robot.gate.set()
    await confirmed(client, path, "added to the plan")
    await until("/api/v1/jobs/2", "state", "succeeded", "failed")

    assert [task.set_aside for task in worker.tasks] == [None, aside]


async def test_it_is_judged_by_the_same_validation_session_again(client, until, bench):
    await measured(client, until, role="validation")
    path = await diagnosed_so_far(client, until, bench, validation_session_id=1)

    await client.post(f"{path}/configurations", json={**MORE, "diagnosis_id": 1})
    bench.robot.gate.set()
    await confirmed(client, path, "added to the plan")
    await until("/api/v1/jobs/2", "state", "succeeded", "failed")

    campaigns = (await client.get("/api/v1/campaigns")).json()
    assert [campaign["session_ids"] for campaign in campaigns] == [[2, 1], [2, 1]]
    assert [campaign["calibration_points"] for campaign in campaigns][1] == 62


async def test_a_session_to_which_nothing_was_added_is_not_diagnosed_by_itself(client, until, worker):
    await measured(client, until)

    assert (await client.get("/api/v1/jobs")).json() == []


async def test_only_a_diagnosis_of_the_same_session_is_run_again(client, until, bench, worker):
    await diagnosed_so_far(client, until, bench)
    other = await planned(client)

    refused = await client.post(f"{other}/configurations", json={**MORE, "diagnosis_id": 1})
    missing = await client.post(f"{other}/configurations", json={**MORE, "diagnosis_id": 9})
    bench.robot.gate.set()

    assert (refused.status_code, missing.status_code) == (409, 404)
    assert "was not made from the readings of session 2" in refused.json()["detail"]
    assert (await client.get(other)).json()["planned"] == 3
