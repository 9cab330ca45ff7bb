"""Plans are made one at a time, and only while somebody waits for them."""

import asyncio

import pytest

from tests.helpers.ballbar.cells import domain_cell
from truepose.analysis.errors import BusyError
from truepose.domain.ballbar import BallbarPlan
from truepose.domain.cell import BallbarKit
from truepose.sessions.ballbar.planning import BallbarPlanRequest, BallbarWork
from truepose.storage.records import SessionSetup

SETUP = SessionSetup(domain_cell(ballbar=BallbarKit()))


class Worker:
    """Plans when it is let go, and remembers what is under way."""

    def __init__(self):
        self.under_way, self.begun, self.go_on = 0, 0, asyncio.Event()

    async def __call__(self, task, told):
        self.under_way, self.begun = self.under_way + 1, self.begun + 1
        try:
            await self.go_on.wait()
        finally:
            self.under_way -= 1
        return BallbarPlan(())


async def wished(work):
    task = asyncio.create_task(work.choose(SETUP, BallbarPlanRequest()))
    await asyncio.sleep(0)
    await asyncio.sleep(0)
    return task


async def test_one_plan_is_made_at_a_time():
    worker = Worker()
    work = BallbarWork(worker)
    tasks = [await wished(work) for _ in range(3)]

    assert worker.under_way == 1
    worker.go_on.set()
    await asyncio.gather(*tasks)

    assert worker.begun == 3


async def test_where_too_many_wait_the_next_one_is_sent_away():
    worker = Worker()
    work = BallbarWork(worker)
    tasks = [await wished(work) for _ in range(4)]

    with pytest.raises(BusyError, match="Too many requests of this kind are waiting"):
        await work.choose(SETUP, BallbarPlanRequest())
    worker.go_on.set()
    await asyncio.gather(*tasks)


async def test_a_plan_that_nobody_wants_any_more_ends_and_the_next_one_begins():
    worker = Worker()
    work = BallbarWork(worker)
    first, second = await wished(work), await wished(work)

    first.cancel()
    await asyncio.wait({first})
    worker.go_on.set()

    assert await second == BallbarPlan(())
    assert worker.begun == 2


async def test_a_pre_calibration_waits_for_no_plan():
    worker = Worker()
    work = BallbarWork(worker)
    planning = await wished(work)

    precalibrating = asyncio.create_task(work.precalibrator(SETUP)(BallbarPlan(()), ()))
    await asyncio.sleep(0)
    await asyncio.sleep(0)

    assert worker.under_way == 2
    worker.go_on.set()
    await asyncio.gather(planning, precalibrating)
