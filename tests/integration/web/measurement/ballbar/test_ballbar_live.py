"""The live stream of a ballbar session: samples, situations, a sign of life each second."""

import asyncio
import contextlib
import json
import time

import httpx
import pytest

from tests.helpers.machine import HANGS_S
from tests.integration.web.ballbar_bench import SESSIONS, WANTED, Tablet, with_ballbar
from tests.integration.web.bench import Bench, FakeBallbar
from tests.integration.web.listening import listening
from truepose.app import create_app
from truepose.web.api.sessions import following


@pytest.fixture
def settings(settings):
    return with_ballbar(settings)


@pytest.fixture
def url(settings):
    with listening(create_app(settings, Bench().registry())) as found:
        yield found


@pytest.fixture
async def client(url):
    async with httpx.AsyncClient(base_url=url, trust_env=False) as opened:
        yield opened


@pytest.fixture
async def tablet(client):
    await client.post(SESSIONS, json=WANTED)
    return Tablet(client)


async def follow(client, path, until, tablet="tablet-1", within_s=30.0):
    """Return what came on the stream until `until` holds of it: pairs of kind and document, "" a comment."""
    found, kind = [], ""
    async with (
        asyncio.timeout(within_s),
        client.stream("GET", f"{path}/live", params={"tablet": tablet}) as stream,
    ):
        async for line in stream.aiter_lines():
            field, _, value = line.partition(": ")
            if field == "event":
                kind = value
            elif line.startswith(":"):
                found.append(("", None))
            elif field == "data":
                found.append((kind, json.loads(value)))
            if until(found):
                return found
    return found


def kinds(found):
    return [kind for kind, _ in found]


def states(found):
    return [document["state"] for kind, document in found if kind == "situation"]


async def test_the_stream_begins_with_the_session_as_it_is(client, tablet):
    found = await follow(client, tablet.path, lambda found: len(found) >= 1)

    kind, session = found[0]
    assert (kind, session["state"], session["watching"]) == ("situation", "planned", 1)


async def test_of_a_session_at_rest_a_comment_comes_each_second(client, tablet):
    began = time.monotonic()

    found = await follow(client, tablet.path, lambda found: kinds(found).count("") >= 2)

    assert time.monotonic() - began > 1.0  # two of them are a second apart
    assert "sample" not in kinds(found)


async def test_a_session_that_begins_tells_so_and_sends_its_samples(client, tablet):
    beginning = []

    def sampled(found):
        if not beginning:
            beginning.append(asyncio.create_task(tablet.press("start")))
        return kinds(found).count("sample") >= 3

    found = await follow(client, tablet.path, sampled)
    await beginning[0]

    sample = next(document for kind, document in found if kind == "sample")
    assert states(found)[0] == "planned"
    assert "running" in states(found)
    assert sample["state"] in {"in_range", "unstable"}
    assert abs(sample["sampled_at_ms"] - time.time() * 1000) < 60_000  # the wall clock, not the cell's
    assert {
        "time_s",
        "length_mm",
        "deviation_mm",
        "stable_share",
        "spread_mm",
        "robot_still",
    } <= sample.keys()


async def test_the_stream_goes_on_while_the_ballbar_of_an_ended_session_is_being_closed(
    client, tablet, monkeypatch
):
    async def close_slowly(self):
        await asyncio.sleep(0.5)

    monkeypatch.setattr(FakeBallbar, "close", close_slowly)

    await tablet.press("start")
    ending = []

    def outlived(found):
        if not ending and "sample" in kinds(found):
            ending.append(asyncio.create_task(tablet.press("abort")))
        return states(found)[-1:] == ["aborted"] and kinds(found)[-2:] == ["", ""]

    await follow(client, tablet.path, outlived)

    assert (await ending[0]).status_code == 200


async def test_tablets_that_follow_are_counted(client, tablet):
    first = asyncio.create_task(
        follow(
            client,
            tablet.path,
            lambda found: any(d and d["watching"] == 2 for kind, d in found if kind == "situation"),
        )
    )
    await asyncio.sleep(0.2)
    second = asyncio.create_task(
        follow(client, tablet.path, lambda found: kinds(found).count("") >= 5, tablet="tablet-2")
    )

    seen = await first

    second.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await second
    assert seen[-1][1]["watching"] == 2
    async with asyncio.timeout(HANGS_S):
        while (await tablet.see())["watching"] > 0:
            await asyncio.sleep(0.05)


async def test_a_session_that_is_not_there_has_no_stream(client):
    refused = await client.get(f"{SESSIONS}/7/live", params={"tablet": "t"})

    assert refused.status_code == 404


async def test_a_tablet_that_leaves_as_a_sample_comes_is_gone():
    mailbox = following._Mailbox()
    taking = asyncio.create_task(mailbox.take())
    await asyncio.sleep(0)
    await asyncio.sleep(0)

    mailbox.put_sample("a length")
    taking.cancel()
    await asyncio.wait({taking})

    assert taking.cancelled()
