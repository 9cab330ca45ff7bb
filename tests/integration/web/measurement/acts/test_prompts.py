"""Questions have numbers: an answer to one that is not asked any more is refused, whatever the session."""

import asyncio

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command, served
from tests.integration.web.ballbar_bench import WANTED, Tablet, with_ballbar
from tests.integration.web.bench import SESSIONS, Bench, planned, session_request

PATH = "/api/v1/sessions/1"


@pytest.fixture
def settings(settings):
    return with_ballbar(settings)


@pytest.fixture
async def asked(client, bench):
    """A tracker session that asks its first question."""
    bench.ballbar.dead = True  # nobody has it on the arm
    await planned(client)
    return (await command(client, PATH, "start")).json()["session"]


async def answer(client, what, prompt_id=None):
    return await command(client, PATH, what, prompt_id=prompt_id)


async def paused(client, bench, until, first):
    """The session after a pause during its first motion, with the question of the pause."""
    bench.robot.gate.clear()
    await answer(client, "confirm", first["prompt"]["id"])
    await asyncio.wait_for(bench.robot.sent.wait(), HANGS_S)
    await command(client, PATH, "pause")
    bench.robot.gate.set()
    return await until(PATH, "state", "paused")


async def test_the_question_that_is_asked_is_confirmed_by_its_number(client, bench, until, asked):
    confirmed = await answer(client, "confirm", asked["prompt"]["id"])
    session = await until(PATH, "state", "finished")

    assert confirmed.status_code == 200
    assert session["measured"] == 3


async def test_an_answer_that_names_no_question_lets_nothing_move(client, bench, asked):
    refused = await answer(client, "confirm")

    assert refused.status_code == 409
    assert f"prompt_id {asked['prompt']['id']}" in refused.json()["detail"]
    assert (await client.get(PATH)).json()["state"] == "awaiting_confirmation"
    assert bench.robot.moves == 0


async def test_where_nothing_is_asked_there_is_no_number(client, until, asked):
    planned = await client.post("/api/v1/sessions", json=session_request())
    await command(client, PATH, "confirm")
    finished = await until(PATH, "state", "finished")

    assert planned.json()["prompt"] is None
    assert finished["prompt"] is None


async def test_an_answer_to_an_earlier_question_moves_nothing(client, bench, until, asked):
    session = await paused(client, bench, until, asked)
    moves = bench.robot.moves

    stale = await answer(client, "resume", asked["prompt"]["id"])
    await asyncio.sleep(0.05)

    assert session["prompt"]["id"] > asked["prompt"]["id"]
    assert stale.status_code == 409
    assert "not the open question" in stale.json()["detail"]
    assert bench.robot.moves == moves
    assert (await client.get(PATH)).json()["state"] == "paused"
    assert (await answer(client, "resume", session["prompt"]["id"])).status_code == 200


async def test_a_number_that_is_no_number_is_refused(client, asked):
    assert (await answer(client, "confirm", "first")).status_code == 422
    assert (await answer(client, "confirm", 0)).status_code == 422


async def test_a_ballbar_session_goes_on_from_the_question_that_was_read(client):
    await client.post(SESSIONS, json=WANTED)
    tablet = Tablet(client)
    await tablet.press("start")
    first = (await tablet.press("stop")).json()["session"]
    await tablet.press("confirm", prompt_id=first["prompt"]["id"])
    second = (await tablet.press("stop")).json()["session"]

    stale = await tablet.press("confirm", prompt_id=first["prompt"]["id"])
    good = await tablet.press("confirm", prompt_id=second["prompt"]["id"])

    assert second["prompt"]["id"] > first["prompt"]["id"]
    assert (stale.status_code, good.status_code) == (409, 200)
    assert good.json()["session"]["state"] == "running"


async def test_a_question_from_before_a_restart_is_not_the_one_that_is_asked_after_it(settings, bench):
    bench.ballbar.dead = True
    async with served(settings, bench.registry()) as client:
        await planned(client)
        before = (await command(client, PATH, "start")).json()["session"]

    later = Bench()
    later.ballbar.dead = True
    async with served(settings, later.registry()) as client:
        stale = await answer(client, "confirm", before["prompt"]["id"])
        asked = (await client.get(PATH)).json()
        moves = later.robot.moves
        good = await answer(client, "confirm", asked["prompt"]["id"])

    assert stale.status_code == 409
    assert asked["prompt"]["id"] > before["prompt"]["id"]
    assert moves == 0
    assert good.status_code == 200
