"""A serial port as a link, on a pseudo terminal: the real pyserial, no hardware."""

import asyncio
import contextlib
import os
import time
from types import SimpleNamespace

import pytest

from tests.helpers.machine import PSEUDO_TERMINALS
from truepose_drivers.errors import ConnectFailedError, ConnectionLostError
from truepose_drivers.transports.serial import Framing, SerialLink, _check_parity

COUNTER = Framing(baud=9600, data_bits=7, parity="E", stop_bits=2, xon_xoff=True)


class Terminal:
    """A pseudo terminal whose master end plays the device."""

    def __init__(self) -> None:
        import tty  # not on Windows

        self.master, slave = os.openpty()
        tty.setraw(slave)
        self.name = os.ttyname(slave)
        self._slave = slave

    def unplug(self) -> None:
        os.close(self._slave)
        os.close(self.master)


@pytest.fixture(params=[pytest.param("pseudo", marks=PSEUDO_TERMINALS)])
def terminal():
    made = Terminal()
    yield made
    for end in (made.master, made._slave):
        with contextlib.suppress(OSError):  # unplugged by the test
            os.close(end)


@pytest.fixture
async def link(terminal):
    opened = SerialLink(terminal.name, COUNTER)
    await opened.open()
    yield opened
    await opened.close()


async def test_bytes_go_there_and_back(terminal, link):
    await link.send(b"\x1bA0200\r")
    heard = os.read(terminal.master, 100)
    os.write(terminal.master, b"\x02+000001234\r\n")
    answer = b""
    while len(answer) < 13:
        answer += await link.receive(1.0)

    assert (heard, answer) == (b"\x1bA0200\r", b"\x02+000001234\r\n")
    await link.close()
    assert not link.is_open


def test_characters_whose_parity_fails_do_not_pass_for_others(terminal):
    import termios  # not on Windows

    _check_parity(SimpleNamespace(fd=terminal._slave))

    iflag = termios.tcgetattr(terminal._slave)[0]
    assert iflag & termios.INPCK  # checked, and
    assert not iflag & (termios.IGNPAR | termios.PARMRK)  # neither dropped nor marked: NUL takes its place


async def test_a_port_can_be_opened_again_and_again(terminal):
    link = SerialLink(terminal.name, COUNTER)

    for _ in range(3):
        await link.open()
        await link.close()
    await link.open()

    assert link.is_open
    await link.close()


class CountingLink(SerialLink):
    """Counts its slices of waiting, of 50 ms each."""

    waits = 0

    async def _read_slice(self, slice_s):
        self.waits += slice_s > 0.0
        return await super()._read_slice(slice_s)


async def test_silence_is_none_after_the_time_allowed(terminal):
    link = CountingLink(terminal.name, COUNTER)
    await link.open()
    start_s = time.monotonic()

    assert await link.receive(0.12) is None

    assert time.monotonic() - start_s > 0.11
    assert link.waits <= 3  # and not much later; a busy machine lets each of them take longer
    assert await link.receive(0.0) is None
    await link.close()


async def test_a_pulled_adapter_is_a_lost_connection(terminal, link):
    terminal.unplug()

    with pytest.raises(ConnectionLostError, match="check cable"):
        await link.receive(10.0)
    assert not link.is_open
    with pytest.raises(ConnectionLostError, match="connect first"):
        await link.send(b"x")


async def test_a_pulled_adapter_is_noticed_by_sending_too(terminal, link):
    terminal.unplug()

    with pytest.raises(ConnectionLostError):
        await link.send(b"x")


@pytest.mark.parametrize("port", ["/dev/there-is-no-such-port", "nonsense://x", "socket://127.0.0.1:1"])
async def test_a_port_that_is_not_there_is_said_by_name(port):
    link = SerialLink(port, COUNTER)

    with pytest.raises(ConnectFailedError, match=r"(?s)cannot be opened.*check its name"):
        await link.open()
    assert not link.is_open


async def test_what_lay_in_the_port_from_before_is_dropped(terminal):
    link = SerialLink(terminal.name, COUNTER)
    os.write(terminal.master, b"stale")
    await link.open()

    assert await link.receive(0.0) is None
    await link.close()


async def test_a_read_that_is_given_up_leaves_the_port_usable(terminal, link):
    with pytest.raises(TimeoutError):
        async with asyncio.timeout(0.02):
            await link.receive(5.0)

    await link._in_thread(lambda: None)  # it has let go
    os.write(terminal.master, b"x")

    assert await link.receive(10.0) == b"x"


async def test_a_socket_url_is_a_port_like_any_other():
    async def echo(reader, writer):
        writer.write(await reader.read(100))
        await writer.drain()
        writer.close()

    server = await asyncio.start_server(echo, "127.0.0.1", 0)
    link = SerialLink(f"socket://127.0.0.1:{server.sockets[0].getsockname()[1]}", COUNTER)
    await link.open()

    await link.send(b"hello")
    heard = b""
    with pytest.raises(ConnectionLostError):
        while (data := await link.receive(1.0)) is not None:
            heard += data

    assert heard == b"hello"
    server.close()


async def test_a_break_and_another_speed_leave_the_port_open(terminal, link):
    await link.send_break()
    await link.set_baud(115_200)
    await link.send(b"INIT \r")

    assert os.read(terminal.master, 100) == b"INIT \r"


async def test_a_port_that_was_pulled_takes_neither(link):
    await link.close()

    with pytest.raises(ConnectionLostError):
        await link.send_break()
    with pytest.raises(ConnectionLostError):
        await link.set_baud(115_200)
