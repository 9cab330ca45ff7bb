"""The simulated cell's clock over a link."""

import asyncio

import pytest

from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.api import Clock
from truepose_drivers.cell_clock.driver import CellClock
from truepose_drivers.cell_clock.protocol import Now, Sleep, Time, decode_request, encode
from truepose_drivers.errors import ConnectionLostError, DeviceRefusedError
from truepose_drivers.framing import LineReader, Refusal

pytestmark = pytest.mark.simulated_time


class FakeCell:
    """A clock at pace 0: sleeping costs no wall time, except that `stuck` sleeps never end."""

    def __init__(self, *, stuck: bool = False) -> None:
        self.time_s = 100.0
        self.connections = 0
        self.stuck = stuck

    async def serve(self, end: MemoryEnd) -> None:
        self.connections += 1
        reader = LineReader()
        while data := await end.receive():
            reader.receive_data(data)
            while (line := reader.next_message()) is not None:
                await end.send(await self.answer(line))

    async def answer(self, line: bytes) -> bytes:
        match decode_request(line):
            case Sleep(duration_s):
                if self.stuck:
                    await asyncio.Event().wait()
                self.time_s += duration_s
            case Now():
                pass
        return encode(Time(self.time_s))


def replying(reply: bytes):
    async def serve(end: MemoryEnd) -> None:
        await end.receive()
        await end.send(reply)
        await end.receive()

    return serve


def clock_on(serve, chunk_bytes: int = 4096) -> CellClock:
    return CellClock(lambda: MemoryLink(serve, chunk_bytes=chunk_bytes), answer_timeout_s=5.0)


@pytest.fixture
def cell():
    return FakeCell()


@pytest.fixture
def clock(cell):
    return clock_on(cell.serve)


@pytest.mark.parametrize("chunk_bytes", [1, 7, 4096])
async def test_sleeping_advances_the_time_of_the_cell(chunk_bytes):
    clock: Clock = clock_on(FakeCell().serve, chunk_bytes)

    await clock.sleep(4.0)

    assert await clock.now_s() == 104.0


async def test_one_connection_serves_all_questions_of_one_task(cell, clock):
    for _ in range(5):
        await clock.now_s()

    assert cell.connections == 1


async def test_a_sleeping_task_does_not_hold_up_one_that_asks_the_time():
    cell = FakeCell(stuck=True)
    clock = clock_on(cell.serve)
    sleeping = asyncio.create_task(clock.sleep(1e6))
    await asyncio.sleep(0)

    assert await clock.now_s() == 100.0

    sleeping.cancel()
    await asyncio.gather(sleeping, return_exceptions=True)


async def test_a_refusal_is_passed_on_with_its_sentence():
    clock = clock_on(replying(encode(Refusal("the cell is closed"))))

    with pytest.raises(DeviceRefusedError, match="the cell is closed"):
        await clock.now_s()


async def test_a_clock_that_hangs_up_is_lost_and_asked_afresh_the_next_time():
    async def hang_up(end: MemoryEnd) -> None:
        await end.receive()

    serves = [hang_up, FakeCell().serve]
    clock = CellClock(lambda: MemoryLink(serves.pop(0)))
    with pytest.raises(ConnectionLostError):
        await clock.now_s()

    assert await clock.now_s() == 100.0


async def test_closing_leaves_nothing_open_and_the_clock_usable(cell, clock):
    await clock.now_s()

    await clock.close()

    assert await clock.now_s() == 100.0
    assert cell.connections == 2
