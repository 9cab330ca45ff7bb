"""Who moves the arm of a cell is somebody whose name can be read, and whom the cell file announces."""

import asyncio

import pytest

from tests.helpers.machine import HANGS_S
from tests.helpers.web.clients import command
from tests.integration.web.ballbar_bench import BALLBAR, WANTED, Tablet
from tests.integration.web.bench import CELL, SESSIONS, planned

NAME = "urn:truepose:problem:name"
UNREADABLE = ["\u200b", "\u202e", "\u0301", "...", "\ue000", "A\u0000", "\U000f0000A"]


@pytest.fixture
def people():
    return 'people = ["Ada Lovelace", "Grace Hopper"]\n'


@pytest.fixture
def cell_text(people):
    return people + CELL + BALLBAR


@pytest.fixture(autouse=True)
def unplugged(bench):
    """A ballbar between two balls would forbid motion by itself."""
    bench.ballbar.dead = True


async def started(client):
    await planned(client)
    await command(client, f"{SESSIONS}/1", "start", person="Ada Lovelace")


async def act(client, what, person):
    return await command(client, f"{SESSIONS}/1", what, person=person)


@pytest.mark.parametrize("name", UNREADABLE)
async def test_a_name_that_nobody_can_read_confirms_nothing(client, bench, name):
    await started(client)

    refused = await act(client, "confirm", name)

    assert refused.status_code in {409, 422}
    assert "name" in refused.json()["detail"]
    assert refused.json()["type"] == NAME
    assert bench.robot.moves == 0


async def test_somebody_whom_nobody_announced_confirms_and_adds_nothing(client, bench):
    await started(client)

    refused = await act(client, "confirm", "Mallory")
    added = await client.post(
        f"{SESSIONS}/1/configurations",
        json={"configurations": [{"joints_deg": [0, 40, -30, 0, 30, 0]}], "person": "Mallory"},
    )

    assert (refused.status_code, added.status_code) == (409, 409)
    assert "Ada Lovelace, Grace Hopper" in refused.json()["detail"]
    assert (await client.get(f"{SESSIONS}/1")).json()["state"] == "awaiting_confirmation"
    assert bench.robot.moves == 0


async def test_an_announced_person_is_on_record_as_announced(client, until):
    await started(client)

    assert (await act(client, "confirm", " ada lovelace")).status_code == 200
    session = await until(f"{SESSIONS}/1", "state", "finished")

    assert {state["person"] for state in session["states"]} == {None, "Ada Lovelace"}


async def test_everybody_may_halt_and_only_those_announced_go_on(client, bench, until):
    await started(client)
    bench.robot.gate.clear()
    await act(client, "confirm", "Ada Lovelace")
    await asyncio.wait_for(bench.robot.sent.wait(), HANGS_S)

    paused = await act(client, "pause", "Mallory")
    bench.robot.gate.set()
    await until(f"{SESSIONS}/1", "state", "paused")
    resumed = await act(client, "resume", "Mallory")
    ended = await act(client, "abort", "Mallory")

    assert (paused.status_code, resumed.status_code, ended.status_code) == (200, 409, 200)


async def test_at_the_tablet_everybody_may_stop_and_only_those_announced_act(client):
    await client.post(SESSIONS, json=WANTED)
    tablet = Tablet(client)

    refused = await tablet.press("start", person="Mallory")
    begun = await tablet.press("start", person="grace hopper")
    taken_over = await Tablet(client, "tablet-2").press("hand_over", person="Mallory")
    stopped = await Tablet(client, "tablet-3").press("stop", person="Mallory")
    confirmed = await tablet.press("confirm", person="Mallory")

    assert [answer.status_code for answer in (begun, stopped)] == [200, 200]
    assert [answer.status_code for answer in (refused, taken_over, confirmed)] == [409, 409, 409]
    assert {answer.json()["type"] for answer in (refused, taken_over, confirmed)} == {NAME}
    assert {line["person"] for line in await tablet.ledger()} <= {None, "Grace Hopper", "Mallory"}


async def test_a_ballbar_session_says_who_may_act(client):
    await client.post(SESSIONS, json=WANTED)

    session = await Tablet(client).see()

    assert session["people"] == ["Ada Lovelace", "Grace Hopper"]


async def test_the_cell_says_who_may(client):
    cell = (await client.get("/api/v1/cells/bench")).json()
    health = (await client.get("/health")).json()
    page = (await client.get("/")).text

    assert cell["people"] == ["Ada Lovelace", "Grace Hopper"]
    assert health["people"] == "announced"
    assert "Ada Lovelace, Grace Hopper" in page


@pytest.mark.parametrize("people", [""])
async def test_a_cell_that_announces_nobody_says_so(client, people):
    assert (await client.get("/api/v1/cells/bench")).json()["people"] == []
    assert (await client.get("/health")).json()["people"] == "anybody"
    assert "no operators are configured" in (await client.get("/")).text
