"""Configurations added over REST: to a planned session, to one under way, never after its end."""

import pytest

from tests.integration.web.bench import Bench, session_request
from tests.integration.web.conftest import asking
from tests.integration.web.test_diagnoses import served

SESSIONS = "/api/v1/sessions"
MORE = {
    "person": "Ada",
    "configurations": [{"joints_deg": [float(k), 42.0, -25.0, 0.0, 30.0, 0.0], "nest": 1} for k in (1, 2)],
}


async def planned(client, n=3):
    return (await client.post(SESSIONS, json=session_request(n))).headers["Location"]


async def confirmed(client, path, question):
    """Let a person confirm, once the session asks what is expected of it."""
    await asking(client)(path, "state", "awaiting_confirmation")
    assert question in (await client.get(path)).json()["question"]
    await client.post(f"{path}/confirm", json={"person": "Ada"})


async def test_a_planned_session_measures_what_was_added(client, until):
    path = await planned(client)

    added = await client.post(f"{path}/configurations", json=MORE)
    plan = (await client.get(f"{path}/plan")).json()
    await client.post(f"{path}/start")
    await confirmed(client, path, "Is the cell clear")
    session = await until(path, "state", "finished", "failed", "paused")

    assert added.status_code == 201
    assert [stop["config"] for stop in added.json()["stops"]] == [4, 5]
    assert added.json()["session"]["planned"] == 5
    assert added.json()["sentence"].startswith("Added configurations 4 to 5; a person confirms")
    assert [stop["joints_deg"] for stop in plan["stops"][3:]] == [
        entry["joints_deg"] for entry in MORE["configurations"]
    ]
    assert (session["planned"], session["measured"]) == (5, 5)


async def test_a_running_session_asks_a_person_before_it_goes_to_what_was_added(client, bench, until):
    bench.robot.gate.clear()
    path = await planned(client)
    await client.post(f"{path}/start")
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
        await client.post(f"{path}/start")

    async with served(settings, Bench(), None) as (client, until):
        await client.post(f"{path}/confirm", json={"person": "Grace"})
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


async def test_two_additions_take_different_numbers(client):
    path = await planned(client)

    await client.post(f"{path}/configurations", json=MORE)
    second = await client.post(f"{path}/configurations", json=MORE)

    assert [(stop["config"], stop["repeat_of"]) for stop in second.json()["stops"]] == [(6, 4), (7, 5)]


async def test_a_session_that_has_ended_takes_no_more(client, until):
    path = await planned(client)
    await client.post(f"{path}/start")
    await client.post(f"{path}/confirm", json={"person": "Ada"})
    await until(path, "state", "finished")

    refused = await client.post(f"{path}/configurations", json=MORE)

    assert refused.status_code == 409
    assert refused.json()["detail"] == "Session 1 is finished; plan a new one for what is missing."
    assert (await client.get(path)).json()["planned"] == 3


@pytest.mark.parametrize(
    ("change", "status", "words"),
    [
        ({"configurations": []}, 422, "configurations"),
        ({"person": "  "}, 422, "person"),
        ({"configurations": [{"joints_deg": [0, 42, -25, 0, 30]}]}, 409, "needs 6 finite joint angles"),
        ({"configurations": [{"joints_deg": [0, 42, -25, 0, 500, 0], "nest": 1}]}, 409, "oint 5"),
        ({"configurations": [{"joints_deg": [0, 90, 40, 0, 30, 0], "nest": 1}]}, 409, "table"),
        ({"configurations": [{"joints_deg": [0, 42, -25, 0, 30, 0], "nest": 99}]}, 409, "none of them"),
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
