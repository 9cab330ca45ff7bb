"""A repeated request waits for the answer that is under way; work that nobody waits for ends."""

import asyncio

import pytest

from tests.helpers.machine import HANGS_S
from truepose.sessions.requests import RequestsUnderWay
from truepose.storage.errors import KeyReusedError
from truepose.storage.records import RequestKey

KEY = RequestKey("k", "fingerprint")


class Work:
    """Answers when it is let go."""

    def __init__(self):
        self.begun = 0
        self.go_on = asyncio.Event()
        self.ended = asyncio.Event()

    async def __call__(self):
        self.begun += 1
        try:
            await self.go_on.wait()
        finally:
            self.ended.set()
        return self.begun


async def asked(requests, work, key=KEY):
    request = asyncio.create_task(requests.shared("name", key, work))
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    return request


async def left(request):
    request.cancel()
    await asyncio.wait({request})


async def test_work_for_which_nobody_has_waited_for_a_while_ends():
    work, requests = Work(), RequestsUnderWay(kept_s=0.0)
    request = await asked(requests, work)

    await left(request)

    async with asyncio.timeout(HANGS_S):
        await work.ended.wait()
    assert not work.go_on.is_set()


async def test_whoever_asks_again_in_time_gets_the_same_answer():
    work, requests = Work(), RequestsUnderWay(kept_s=60.0)
    await left(await asked(requests, work))

    again = await asked(requests, work)
    work.go_on.set()

    assert await again == 1


async def test_work_goes_on_while_one_of_two_waits():
    work, requests = Work(), RequestsUnderWay(kept_s=0.0)
    first, second = await asked(requests, work), await asked(requests, work)

    await left(first)
    await asyncio.sleep(0)
    work.go_on.set()

    assert await second == 1


async def test_after_the_end_the_same_request_begins_anew():
    work, requests = Work(), RequestsUnderWay(kept_s=0.0)
    await left(await asked(requests, work))
    async with asyncio.timeout(HANGS_S):
        await work.ended.wait()

    again = await asked(requests, work)
    work.go_on.set()

    assert await again == 2


async def test_without_a_limit_the_work_goes_on_for_nobody():
    work, requests = Work(), RequestsUnderWay()
    await left(await asked(requests, work))
    work.go_on.set()

    async with asyncio.timeout(HANGS_S):
        await work.ended.wait()
    assert work.begun == 1


async def test_another_request_under_the_same_name_is_refused():
    work, requests = Work(), RequestsUnderWay(kept_s=60.0)
    first = await asked(requests, work)

    with pytest.raises(KeyReusedError):
        await requests.shared("name", RequestKey("k", "another"), work)
    await left(first)
