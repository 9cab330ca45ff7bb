"""Who goes first: what stops the robot, however many look, stream or send slowly."""

import asyncio
import re

import httpx
import pytest
from fastapi.responses import StreamingResponse

from tests.helpers.machine import HANGS_S
from tests.helpers.web.routes import paths_answering, paths_of, routes_alone
from truepose.sessions.engine.commands import HALTS
from truepose.web.middleware import priority
from truepose.web.middleware.priority import ConcurrencyLimits

APP = routes_alone()
PAUSE, LOOK = "/api/v1/sessions/1/commands", "/api/v1/sessions"


class Held:
    """An application whose requests last until they are let go, but for health and for most commands."""

    def __init__(self):
        self.go = asyncio.Event()
        self.under_way = 0

    async def __call__(self, scope, receive, send):
        body = (await receive())["body"]
        self.under_way += 1
        if scope["path"] not in (PAUSE, "/health") or b"confirm" in body:
            await self.go.wait()
        self.under_way -= 1
        await send({"type": "http.response.start", "status": 200, "headers": []})
        await send({"type": "http.response.body", "body": b""})

    async def holds(self, n):
        """Wait until so many requests are under way."""
        while self.under_way < n:
            await asyncio.sleep(0)


@pytest.fixture
def held():
    return Held()


@pytest.fixture
async def client(held):
    async with httpx.AsyncClient(
        transport=httpx.ASGITransport(ConcurrencyLimits(held)), base_url="http://h"
    ) as opened:
        yield opened
        held.go.set()


@pytest.fixture
async def asking(client):
    """Ask so often at once without waiting for answers."""
    tasks = []

    def ask(path, times, **more):
        tasks.extend(asyncio.create_task(client.request("GET", path, **more)) for _ in range(times))
        return tasks

    yield ask
    for task in tasks:
        task.cancel()
    await asyncio.gather(*tasks, return_exceptions=True)


async def test_a_flood_of_readers_waits_and_a_pause_does_not(client, held, asking, monkeypatch):
    monkeypatch.setattr(priority, "_WAIT_S", 0.05)
    flood = asking(LOOK, 400)
    await held.holds(16)

    stopped = [(await client.post(path)).status_code for path in (PAUSE, PAUSE)]
    health = (await client.get("/health")).status_code
    async with asyncio.timeout(HANGS_S):
        while len(refused := [task for task in flood if task.done()]) < 400 - 16:
            await asyncio.sleep(0.01)

    assert [*stopped, health] == [200, 200, 200]
    assert held.under_way == 16  # the others, which nobody refuses any more
    assert len(refused) == 400 - 16
    assert {task.result().status_code for task in refused} == {503}
    assert all(task.result().headers["retry-after"] for task in refused)


@pytest.mark.parametrize("command", HALTS)
async def test_commands_that_wait_for_the_disk_keep_no_halt_waiting(client, held, asking, command):
    asking(PAUSE, 80, json={"command": "confirm"})
    await held.holds(16)

    halted = await asyncio.wait_for(client.post(PAUSE, json={"command": command}), HANGS_S)

    assert halted.status_code == 200


async def test_those_that_wait_are_answered_when_it_is_their_turn(held, asking):
    many = asking(LOOK, 100)
    await held.holds(16)

    held.go.set()

    assert {answer.status_code for answer in await asyncio.gather(*many)} == {200}


async def test_streams_take_no_place_of_others(client, held, asking):
    asking("/api/v1/events", 384)
    await held.holds(384)

    assert (await client.get("/api/v1/sessions/1/live")).status_code == 503
    held.go.set()
    assert (await client.get(LOOK)).status_code == 200


async def test_who_sends_slowly_takes_no_place():
    never = asyncio.Event()

    async def receive():
        await never.wait()

    async def drop(message):
        raise AssertionError(message)

    door = ConcurrencyLimits(Held())
    scope = {"type": "http", "method": "POST", "path": LOOK, "headers": [], "query_string": b""}
    senders = [asyncio.create_task(door(scope, receive, drop)) for _ in range(100)]
    async with httpx.AsyncClient(transport=httpx.ASGITransport(door), base_url="http://h") as other:
        assert (await other.get("/health")).status_code == 200
    for sender in senders:
        sender.cancel()
    await asyncio.gather(*senders, return_exceptions=True)


async def test_who_leaves_as_a_place_comes_free_does_not_go_in():
    lane = priority._Lane(1, 1)
    inside = []

    async def go_in():
        async with lane.place():
            inside.append("late")

    async with lane.place():
        waiting = asyncio.create_task(go_in())
        while not lane.waiting:
            await asyncio.sleep(0)
    waiting.cancel()
    await asyncio.wait({waiting})

    assert waiting.cancelled()
    assert inside == []
    assert not lane.inside.locked()


async def test_bodies_together_have_a_limit_that_an_act_does_not_feel(client, held, asking, monkeypatch):
    monkeypatch.setattr(priority, "_BODIES_BYTES", 2**20)
    asking(LOOK, 1, content=b" " * 2**20)
    await held.holds(1)

    assert (await client.post(LOOK, content=b" " * 2**17)).status_code == 503
    assert (await client.post(PAUSE, content=b" " * 2**15)).status_code == 200


def test_every_route_that_stops_something_is_urgent():
    stopping = [path for path in paths_of(APP) if re.search(r"/(commands|health)$", path)]

    assert len(stopping) == 2
    assert all(priority._URGENT.fullmatch(path) for path in stopping)


def test_every_judgement_of_readings_that_is_made_when_asked_waits_with_the_drawings():
    judged = [
        path for path in paths_of(APP) if re.search(r"/(promise|proof|circles|sphere|accuracy|result)$", path)
    ]

    assert len(judged) == 6
    assert all(priority._DRAWN.fullmatch(path) for path in judged)


def test_every_stream_goes_in_the_lane_of_streams():
    streams = paths_answering(APP, StreamingResponse)

    assert streams
    assert {path for path in paths_of(APP) if priority._STREAMS.fullmatch(path)} == streams
