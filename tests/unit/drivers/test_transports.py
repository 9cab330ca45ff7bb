"""Links: what a driver may rely on, over a loopback socket and in memory."""

import asyncio
import contextlib
import shutil
import socket
import sys
from pathlib import Path

import pytest

from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from tests.helpers.machine import HANGS_S, OWN_NETWORK
from truepose_drivers.errors import ConnectFailedError, ConnectionLostError
from truepose_drivers.transports.tcp import TcpLink


async def echo_then_hang_up(end) -> None:
    """Echo until the word "bye"."""
    while data := await end.receive():
        if data == b"bye":
            return
        await end.send(data)


class _SocketEnd:
    def __init__(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        self._reader, self._writer = reader, writer

    async def receive(self) -> bytes:
        return await self._reader.read(4096)

    async def send(self, data: bytes) -> None:
        self._writer.write(data)


@contextlib.asynccontextmanager
async def tcp_link():
    async def serve(reader, writer):
        await echo_then_hang_up(_SocketEnd(reader, writer))
        writer.close()

    server = await asyncio.start_server(serve, "127.0.0.1", 0)
    link = TcpLink("127.0.0.1", server.sockets[0].getsockname()[1])
    yield link
    await link.close()
    server.close()


@contextlib.asynccontextmanager
async def memory_link():
    link = MemoryLink(echo_then_hang_up)
    yield link
    await link.close()


@pytest.fixture(params=[tcp_link, memory_link])
async def link(request):
    async with request.param() as made:
        await made.open()
        yield made


async def test_bytes_go_there_and_back(link):
    await link.send(b"hello")

    assert await link.receive(5.0) == b"hello"
    assert link.is_open


@pytest.mark.parametrize("timeout_s", [0.0, 0.01])
async def test_silence_is_none_and_leaves_the_link_open(link, timeout_s):

    assert await link.receive(timeout_s) is None
    assert link.is_open


async def test_the_end_of_the_stream_is_a_lost_connection(link):
    await link.send(b"bye")

    with pytest.raises(ConnectionLostError, match="was lost"):
        await link.receive(5.0)

    assert not link.is_open
    with pytest.raises(ConnectionLostError, match="connect first"):
        await link.send(b"hello")


async def test_a_lost_link_can_be_opened_again(link):
    await link.send(b"bye")
    with pytest.raises(ConnectionLostError):
        await link.receive(5.0)

    await link.open()
    await link.send(b"again")

    assert await link.receive(5.0) == b"again"


@pytest.mark.parametrize("made", [tcp_link, memory_link])
async def test_a_link_that_was_never_opened_says_so_and_closes_quietly(made):
    async with made() as link:
        with pytest.raises(ConnectionLostError, match="connect first"):
            await link.receive(0.0)

        await link.close()

        assert not link.is_open


async def test_what_arrived_is_there_without_waiting():
    async with tcp_link() as link:
        await link.open()
        await link.send(b"hello")
        while (data := await link.receive(0.0)) is None:
            await asyncio.sleep(0.001)

        assert data == b"hello"


async def test_what_came_while_the_loop_was_busy_is_there_without_waiting():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = TcpLink(*server.getsockname())
        await link.open()
        peer, _ = server.accept()
        with peer:
            peer.sendall(b"unasked")  # the loop has had no turn since

            assert await link.receive(0.0) == b"unasked"
            assert await link.receive(0.0) is None
        await link.close()


async def pushed(peer: socket.socket) -> int:
    """Send until nobody takes any more; return how many bytes that were."""
    peer.setblocking(False)
    total = 0
    for _ in range(1000):
        with contextlib.suppress(BlockingIOError):
            total += peer.send(bytes(65_536))
        await asyncio.sleep(0)
    return total


async def test_what_nobody_takes_is_left_to_the_system_and_not_lost():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = TcpLink(*server.getsockname())
        await link.open()
        peer, _ = server.accept()
        with peer:
            sent = await pushed(peer)
            assert sent < 1000 * 65_536  # what the system holds is a few megabytes, and we hold no more

            taken = 0
            while taken < sent:
                data = await link.receive(10.0)
                assert data is not None
                taken += len(data)
            assert await link.receive(0.0) is None
        await link.close()

    assert taken == sent


async def test_a_peer_that_takes_nothing_has_lost_the_connection_by_the_time_out():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = TcpLink(*server.getsockname(), send_timeout_s=0.05)
        await link.open()

        with pytest.raises(ConnectionLostError):
            await link.send(bytes(30_000_000))  # several times what the system holds

        assert not link.is_open


async def test_what_came_before_the_end_is_taken_before_the_end_is_told():
    with socket.create_server(("127.0.0.1", 0)) as server:
        link = TcpLink(*server.getsockname())
        await link.open()
        peer, _ = server.accept()
        peer.sendall(b"last words")
        peer.close()

        assert await link.receive(5.0) == b"last words"
        with pytest.raises(ConnectionLostError):
            await link.receive(5.0)


async def test_a_peer_that_hung_up_is_noticed_without_asking():
    async with tcp_link() as link:
        await link.open()
        await link.send(b"bye")

        async with asyncio.timeout(HANGS_S):
            while link.is_open:
                await asyncio.sleep(0.001)

        assert not link.is_open


async def test_a_refused_connection_names_address_and_remedy():
    with socket.socket() as reserved:
        reserved.bind(("127.0.0.1", 0))  # bound and not listening: nobody answers, nobody else takes it
        link = TcpLink("127.0.0.1", reserved.getsockname()[1])

        with pytest.raises(ConnectFailedError, match=r"127\.0\.0\.1:\d+ .*check power, cable and address"):
            await link.open()


@pytest.mark.parametrize("host", ["robot..cell", "a" * 70, "\udcff"])
async def test_a_name_that_is_none_of_a_host_is_told_like_one_that_nobody_has(host):
    with pytest.raises(ConnectFailedError, match="check power, cable and address"):
        await TcpLink(host, 5000).open()


async def test_a_host_that_accepts_nothing_runs_into_the_time_out():
    with socket.socket() as full:
        full.bind(("127.0.0.1", 0))
        full.listen(0)
        port = full.getsockname()[1]
        waiting = [socket.socket() for _ in range(4)]
        for client in waiting:  # fill the queue, so that the kernel leaves the next one unanswered
            client.setblocking(False)
            client.connect_ex(("127.0.0.1", port))
        link = TcpLink("127.0.0.1", port, connect_timeout_s=0.05)

        with pytest.raises(ConnectFailedError, match=r"within 0\.05 s"):
            await link.open()

        for client in waiting:
            client.close()


async def test_memory_splits_what_is_sent():
    async def serve(end: MemoryEnd) -> None:
        await end.send(await end.receive())

    link = MemoryLink(serve, chunk_bytes=2)
    await link.open()
    await link.send(b"abcd")

    assert await link.receive(1.0) == b"ab"


async def test_without_a_server_nobody_answers():
    with pytest.raises(ConnectFailedError):
        await MemoryLink(None).open()


OWN = ("unshare", "--map-root-user", "--net")  # a network for one process


async def output_of(*command):
    process = await asyncio.create_subprocess_exec(
        *command, stdout=asyncio.subprocess.PIPE, stderr=asyncio.subprocess.PIPE
    )
    said, complaint = await process.communicate()
    return process.returncode, said.decode(), complaint.decode()


async def test_a_line_that_goes_dead_is_told_whether_anything_is_sent_or_not():
    if not (shutil.which("unshare") and shutil.which("ip")) or (await output_of(*OWN, "true"))[0] != 0:
        pytest.skip(OWN_NETWORK.reason)

    code, said, complaint = await output_of(
        *OWN, sys.executable, str(Path(__file__).with_name("dead_line.py"))
    )

    assert code == 0, complaint
    # two seconds, and what a busy machine adds; without the system's question nothing is told in twenty
    assert [float(word) < 10.0 for word in said.split()] == [True, True]
