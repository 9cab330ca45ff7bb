"""Who is given a worker next: short before long where it matters, and nobody before everybody else."""

import asyncio
import contextlib

import pytest

from tests.helpers.machine import HANGS_S
from truepose.analysis.job_queue.scheduling import WorkerSlots

SHORT, LONG = 1.0, 100.0


class Bench:
    """Jobs that hold their place until they are let go."""

    def __init__(self, places):
        self.places = places
        self.begun = []
        self.gates = {}
        self.tasks = []

    async def ask(self, number, expected_s, sender=""):
        self.gates[number] = asyncio.Event()
        self.tasks.append(asyncio.create_task(self._work(number, expected_s, sender)))
        await settled()

    async def end(self, number):
        self.gates[number].set()
        await settled()

    async def _work(self, number, expected_s, sender):
        async with self.places.place(number, expected_s, sender):
            self.begun.append(number)
            await self.gates[number].wait()


async def settled():
    for _ in range(10):
        await asyncio.sleep(0)


@pytest.fixture
async def bench():
    opened = Bench(WorkerSlots())
    yield opened
    for task in opened.tasks:
        task.cancel()
    for task in opened.tasks:
        with contextlib.suppress(asyncio.CancelledError):
            await task


async def test_one_long_and_one_short_job_run_at_a_time_however_many_wait(bench):
    for number in (1, 2, 3):
        await bench.ask(number, LONG)
    await bench.ask(4, SHORT)
    await bench.ask(5, SHORT)

    assert bench.begun == [1, 4]


async def test_two_short_jobs_run_where_nothing_is_long(bench):
    for number in (1, 2, 3):
        await bench.ask(number, SHORT)

    assert bench.begun == [1, 2]
    await bench.end(1)
    assert bench.begun == [1, 2, 3]


async def test_somebody_with_many_jobs_waits_for_somebody_with_one(bench):
    for number in (1, 2, 3, 4):
        await bench.ask(number, LONG, "script")
    await bench.ask(5, LONG, "tablet")

    await bench.end(1)

    assert bench.begun == [1, 5]


async def test_of_one_sender_the_first_comes_first(bench):
    for number in (1, 2, 3):
        await bench.ask(number, LONG)
    await bench.end(1)
    await bench.end(2)

    assert bench.begun == [1, 2, 3]


async def test_a_waiting_job_knows_how_many_go_first(bench):
    for number in (1, 2, 3):
        await bench.ask(number, LONG)

    assert [bench.places.ahead(number) for number in (1, 2, 3)] == [0, 0, 1]


async def test_one_that_goes_away_leaves_its_place_in_the_queue(bench):
    for number in (1, 2, 3):
        await bench.ask(number, LONG)

    bench.tasks[1].cancel()
    await settled()
    await bench.end(1)

    assert bench.begun == [1, 3]


async def test_a_job_that_proves_to_be_long_holds_up_no_short_one():
    bench = Bench(WorkerSlots(short_s=0.02))
    await bench.ask(1, LONG)
    await bench.ask(2, 0.01)
    await bench.ask(3, 0.01)
    begun_at_once = list(bench.begun)

    async with asyncio.timeout(HANGS_S):
        while 3 not in bench.begun:
            await asyncio.sleep(0.01)
    for number in (1, 2, 3):
        await bench.end(number)

    assert begun_at_once == [1, 2]
