"""Events arrive in order, once each, and can be resumed where a client stopped."""

import asyncio
import json

import httpx
import pytest

from tests.integration.web.bench import begun, number_of, planned
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.web.api import events as streams


@pytest.fixture
async def client(settings, bench):
    """A client over a socket: the test transport of ASGI waits for the end of a reply."""
    with listening(create_app(settings, bench.registry())) as url:
        async with httpx.AsyncClient(base_url=url, timeout=60) as opened:
            yield opened


async def events(client, count=None, last_event_id=None, opened=None, **query):
    """Read the stream: so many events, or to its end; tells by `opened` that it has begun."""
    headers = {} if last_event_id is None else {"Last-Event-ID": str(last_event_id)}
    found = []
    async with client.stream("GET", "/api/v1/events", params=query, headers=headers) as stream:
        assert stream.status_code == 200
        assert stream.headers["content-type"].startswith("text/event-stream")
        if opened is not None:
            opened.set()
        event = {}
        async for line in stream.aiter_lines():
            name, _, value = line.partition(": ")
            if line == "" and "data" in event:
                found.append((int(event["id"]), event["event"], json.loads(event["data"])))
                event = {}
                if len(found) == count:
                    break
            elif name:
                event[name] = value
    return found


async def until_finished(client, number):
    found = await events(client, 1, session_id=number)
    while found[-1][2].get("state") != "finished":
        found += await events(client, 1, found[-1][0], session_id=number)
    return found


async def test_a_session_is_told_from_its_plan_to_its_end(client):
    number = number_of(await begun(client))

    told = await until_finished(client, number)
    states = [document["state"] for _, kind, document in told if kind == "session.state"]
    readings = [document for _, kind, document in told if kind == "session.reading"]

    assert states == ["planned", "awaiting_confirmation", "running", "finished"]
    assert [r["reading"]["config"] for r in readings if r["kind"] == "point"] == [1, 2, 3]
    assert all(document["session_id"] == number for _, _, document in told)


async def test_a_client_that_resumes_misses_nothing_and_hears_nothing_twice(client):
    number = number_of(await begun(client))
    whole = await until_finished(client, number)

    for split in (1, len(whole) // 2, len(whole) - 1):
        first = await events(client, split, session_id=number)
        rest = await events(client, len(whole) - split, first[-1][0], session_id=number)

        assert first + rest == whole
    assert [identity for identity, _, _ in whole] == sorted({identity for identity, _, _ in whole})


async def test_without_a_record_the_stream_begins_with_what_happens_next(client):
    await planned(client)
    opened = asyncio.Event()
    following = asyncio.create_task(events(client, 1, opened=opened))
    await opened.wait()

    second = number_of(await planned(client))

    ((_, kind, document),) = await following
    assert (kind, document["session_id"]) == ("session.state", second)


async def test_last_event_id_0_tells_everything_from_the_first(client):
    first, second = [number_of(await planned(client)) for _ in range(2)]

    told = await events(client, 2, 0)

    assert [document["session_id"] for _, _, document in told] == [first, second]


async def test_a_bounded_stream_ends_by_itself(client):
    number = number_of(await planned(client))

    told = await events(client, session_id=number, stop_after_s=1.0)

    assert [kind for _, kind, _ in told] == ["session.state"]


@pytest.mark.parametrize(
    ("query", "sentence"), [({"session_id": 7}, "no session 7"), ({"job_id": 7}, "no job 7")]
)
async def test_what_is_not_there_cannot_be_followed(client, query, sentence):
    refused = await client.get("/api/v1/events", params=query)

    assert refused.status_code == 404
    assert sentence in refused.json()["detail"]


async def test_a_last_event_id_that_is_no_number_is_refused(client):
    refused = await client.get("/api/v1/events", headers={"Last-Event-ID": "yesterday"})

    assert refused.status_code == 422
    assert "Last-Event-ID" in refused.json()["detail"]


async def test_a_client_that_leaves_as_something_happens_is_gone():
    commit = asyncio.Event()
    waiting = asyncio.create_task(streams._happens(commit))
    await asyncio.sleep(0)
    await asyncio.sleep(0)

    commit.set()
    waiting.cancel()
    await asyncio.wait({waiting})

    assert waiting.cancelled()
