"""The tracker's server on a socket: one application, one command at a time, streams split anywhere."""

import asyncio
import contextlib
import struct
from dataclasses import replace

import pytest

from tests.helpers.instruments.sockets import connections_to
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.faults.kinds import TrackerCut
from truepose_simulators.instruments.accuracy import ProbeSetup, TrackerSetup
from truepose_simulators.instruments.leica_emscon.server import tracker_endpoint
from truepose_simulators.scenarios.file import load_scenario

# Replies cross the loopback in well under a millisecond; nothing here waits for this long unless it fails.
PATIENCE_S = 60.0  # with an answer, on a busy machine


class HeldClock(CellClock):
    """Real time that stands still: whoever sleeps waits until the test lets go."""

    def __init__(self):
        self.released = asyncio.Event()
        super().__init__(1, wall_s=lambda: 0.0, wall_sleep=self.hold)

    async def hold(self, duration_s):
        if duration_s > 0.0:
            await self.released.wait()


class Client:
    """A bare emScon client."""

    def __init__(self, reader, writer):
        self.reader, self.writer = reader, writer

    def send(self, command, members=b""):
        self.writer.write(struct.pack("<iII", 12 + len(members), 0, command) + members)

    async def receive(self):
        """Return type, first and second word and the whole packet."""
        head = await asyncio.wait_for(self.reader.readexactly(4), PATIENCE_S)
        rest = await asyncio.wait_for(self.reader.readexactly(struct.unpack("<i", head)[0] - 4), PATIENCE_S)
        second = struct.unpack_from("<I", rest, 8)[0] if len(rest) >= 12 else None
        return (*struct.unpack_from("<II", rest), second, head + rest)

    async def ask(self, command, members=b""):
        """Return the status of the answer."""
        self.send(command, members)
        kind, answered, status, _ = await self.receive()
        assert (kind, answered) == (0, command)
        return status


@contextlib.asynccontextmanager
async def tracker(clock, **changes):
    """Serve a tracker and hand out a way to connect."""
    scenario = replace(load_scenario("irb120-tilted"), tracker=TrackerSetup(initialise_s=0.0), **changes)
    endpoint = tracker_endpoint(Cell(scenario, 1, clock))
    async with connections_to(endpoint) as connect:

        async def connected():
            return Client(*await connect())

        yield connected


@contextlib.asynccontextmanager
async def measuring(queue=0):
    """Have a client whose measurement was accepted and is held back, and the clock that holds it."""
    clock = HeldClock()
    async with tracker(clock) as connect:
        client = await connect()
        assert await client.ask(7) == 0
        await client.ask(120, struct.pack("<2i", 200, queue))
        assert await client.ask(49) == 0
        yield client, clock, connect


async def left(client):
    client.writer.close()
    await client.writer.wait_closed()
    await asyncio.sleep(0.05)  # until the server has read the end of the stream


async def test_a_second_application_is_told_so_and_takes_over_when_the_first_leaves():
    async with tracker(CellClock(0)) as connect:
        first, second = await connect(), await connect()

        assert await first.ask(7) == 0
        assert await second.ask(7) == 10011
        await left(first)

        assert await second.ask(54) == 0


async def test_a_command_while_another_runs_is_answered_busy():
    async with measuring() as (client, clock, _):
        assert await client.ask(1) == 1
        assert await client.ask(49) == 1
        clock.released.set()

        assert (await client.receive())[0] == 2
        assert await client.ask(1) == 0


async def test_stopping_a_measurement_is_always_accepted_and_no_result_follows():
    async with measuring() as (client, clock, _):
        assert await client.ask(52) == 0
        clock.released.set()

        assert await client.ask(2) == 0  # the next packet is this answer, not a result


async def test_a_queue_takes_as_many_commands_as_it_was_set_to():
    async with measuring(queue=2) as (client, clock, _):
        client.send(98)
        client.send(2)
        assert await client.ask(1) == 1  # the third finds the queue full
        clock.released.set()

        kinds = [(await client.receive())[:2] for _ in range(3)]
        assert kinds[0][0] == 2
        assert kinds[1:] == [(0, 98), (0, 2)]


async def test_clearing_the_queue_drops_what_waits():
    async with measuring(queue=2) as (client, clock, _):
        client.send(98)

        assert await client.ask(130, struct.pack("<i", 0)) == 0
        clock.released.set()

        assert (await client.receive())[0] == 2
        assert await client.ask(2) == 0


async def test_a_client_that_leaves_in_the_middle_of_a_command_frees_the_tracker():
    async with measuring() as (first, _, connect):
        second = await connect()
        await left(first)

        assert await second.ask(1) == 0


@pytest.mark.parametrize("chunk_bytes", [1, 5, 13])
async def test_requests_may_be_split_anywhere_and_joined(chunk_bytes):
    stream = struct.pack("<iII", 12, 0, 7) + struct.pack("<iII5i", 32, 0, 5, 1, 0, 0, 0, 0)
    async with tracker(CellClock(0)) as connect:
        client = await connect()
        for start in range(0, len(stream), chunk_bytes):
            client.writer.write(stream[start : start + chunk_bytes])
            await client.writer.drain()
            await asyncio.sleep(0)

        assert [(await client.receive())[:3] for _ in range(2)] == [(0, 7, 0), (0, 5, 0)]


async def test_a_request_without_its_members_is_answered_and_the_next_one_read():
    async with tracker(CellClock(0)) as connect:
        client = await connect()

        assert await client.ask(55) == 3
        assert await client.ask(7) == 0


@pytest.mark.parametrize("nonsense", [b"GET / HTTP/1.1\r\n\r\n", struct.pack("<iII", 12, 8, 1), bytes(12)])
async def test_bytes_that_are_no_request_end_the_connection_but_not_the_server(nonsense):
    async with tracker(CellClock(0)) as connect:
        client = await connect()
        client.writer.write(nonsense)

        assert await asyncio.wait_for(client.reader.read(), PATIENCE_S) == b""
        assert await (await connect()).ask(7) == 0


async def test_a_cut_stream_ends_in_the_middle_of_the_result():
    async with tracker(CellClock(0), faults=(TrackerCut(reading=1),)) as connect:
        client = await connect()
        await client.ask(7)
        await client.ask(49)

        rest = await asyncio.wait_for(client.reader.read(), PATIENCE_S)

        assert len(rest) == 156 // 2
        assert struct.unpack_from("<iI", rest) == (156, 2)


async def test_exit_application_closes_the_connection_after_its_answer():
    async with tracker(CellClock(0)) as connect:
        client = await connect()

        assert await client.ask(0) == 0
        assert await asyncio.wait_for(client.reader.read(), PATIENCE_S) == b""


async def test_settings_outlive_the_connection():
    async with tracker(CellClock(0)) as connect:
        client = await connect()
        await client.ask(26, struct.pack("<i", 7))
        await client.ask(0)

        other = await connect()
        other.send(27)

        assert (await other.receive())[3][16:] == struct.pack("<i", 7)


async def test_reflector_positions_stream_while_they_are_asked_for():
    settings = [2, 0, 0, 1, 0, 1, 0, 1, 0]
    async with tracker(CellClock(0)) as connect:
        client = await connect()
        await client.ask(7)
        await client.ask(47, struct.pack("<9i", *settings))

        streamed = [await client.receive() for _ in range(2)]
        settings[5] = 0
        await client.ask(47, struct.pack("<9i", *settings))

        assert [packet[0] for packet in streamed] == [7, 7]
        # Power-up unit is the metre; the home reflector sits 0.15 m in front.
        assert struct.unpack_from("<d", streamed[0][3], 12)[0] == pytest.approx(0.15, abs=1e-4)
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(client.reader.readexactly(4), 0.5)  # more than one period of 1/3 s


@pytest.mark.parametrize("pace", [0, 1])
async def test_a_stream_of_values_goes_on_until_it_is_stopped(pace):
    async with tracker(CellClock(pace), probe=ProbeSetup()) as connect:
        client = await connect()
        await client.ask(7)
        await client.ask(24, struct.pack("<i", 1))
        await client.ask(30, struct.pack("<4i", 20, 0, 0, 0))
        await client.ask(120, struct.pack("<2i", 400, 10))
        assert await client.ask(49) == 0

        blocks = [await client.receive() for _ in range(2)]
        client.send(52)
        rest = [await client.receive()]
        while rest[-1][0] == 3:  # sent before the request was read
            rest.append(await client.receive())

        assert [block[0] for block in blocks] == [3, 3]
        assert rest[-1][:3] == (0, 52, 0)
        assert await client.ask(2) == 0  # the next packet is this answer, not a value
