"""The event loop in which waiting takes no time."""

import asyncio
import time

import pytest

from truepose_drivers.contract.case import SimulatedTimeLoop


def run(coroutine):
    with asyncio.Runner(loop_factory=SimulatedTimeLoop) as runner:
        return runner.run(coroutine)


async def slept(duration_s: float) -> float:
    loop = asyncio.get_running_loop()
    begun_s = loop.time()
    await asyncio.sleep(duration_s)
    return loop.time() - begun_s


def test_a_day_passes_at_once_and_is_a_day_long():
    begun_s = time.monotonic()

    assert run(slept(86_400.0)) == pytest.approx(86_400.0)

    assert time.monotonic() - begun_s < 3_600.0


def test_the_computing_in_between_takes_no_time():
    async def computing() -> float:
        time.sleep(0.01)
        return asyncio.get_running_loop().time()

    assert run(computing()) == 0.0


def test_timers_ring_in_their_order_and_the_shorter_limit_holds():
    rung = []

    async def ring(after_s: float) -> None:
        await asyncio.sleep(after_s)
        rung.append(after_s)

    async def limited() -> None:
        with pytest.raises(TimeoutError):
            async with asyncio.timeout(2.5):
                await asyncio.gather(ring(3.0), ring(1.0), ring(2.0))

    run(limited())

    assert rung == [1.0, 2.0]


def test_to_wait_for_nothing_is_told_instead_of_hanging():
    async def waits() -> None:
        await asyncio.Event().wait()

    with pytest.raises(RuntimeError, match="nothing will bring about"):
        run(waits())
