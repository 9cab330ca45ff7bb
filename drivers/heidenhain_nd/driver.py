"""A length gauge behind a Heidenhain ND 28x counter, on a serial port or a terminal server."""

import asyncio
import contextlib
import math
import time
from collections.abc import AsyncIterator
from dataclasses import dataclass, replace

from drivers import options as option
from drivers.api import BallbarReading, Clock, DeviceIdentity, DriverPlugin, Options
from drivers.errors import ConfigurationError, ConnectFailedError, ConnectionLostError, NoReplyError
from drivers.heidenhain_nd.protocol import (
    ERROR_TEXT,
    IDENTITY,
    LAMPS,
    VALUE,
    Lamps,
    Line,
    NdProtocolError,
    Refused,
    Reply,
    ReplyReader,
    decode_count,
    decode_identity,
    decode_lamps,
    encode_request,
    reply_kind,
    to_mm,
)
from drivers.monotonic_clock import MonotonicClock
from drivers.transports.link import Link
from drivers.transports.serial import Framing, SerialLink
from drivers.transports.tcp import TcpLink

_REPLY_TIMEOUT_S = 1.0  # on top of the time on the line; a counter takes 50 ms at most
_ON_THE_LINE_BITS = 80 * 11  # of three commands and their answers
_MOST_REFUSALS = 3
_IDENTITY_LINES = 3
# Factory setting of the counters; the manual lets the operator choose the rate alone.
_FACTORY = Framing(baud=9600, data_bits=7, parity="E", stop_bits=2, xon_xoff=True)
_RATES = (110, 150, 300, 600, 1200, 2400, 4800, 9600, 19_200, 38_400, 57_600, 115_200)
_TERMINAL_SERVER_PORT = 4001  # first line of a Moxa NPort, as delivered
_CHECK_LINE = "check cable, power, and the counter's baud rate"


@dataclass(frozen=True, slots=True)
class _Answers:
    """What came back on error text, value and lamps asked in one go."""

    value: Line | None = None
    lamps: Line | None = None
    error_text: str | None = None
    refusals: int = 0


class HeidenhainCounter:
    """An ND 28x on a link. Keeps the conversation; computes nothing."""

    def __init__(self, link: Link, clock: Clock, *, reply_timeout_s: float = _REPLY_TIMEOUT_S) -> None:
        self._link = link
        self._clock = clock
        self._reply_timeout_s = reply_timeout_s
        self._lock = asyncio.Lock()
        self._reader = ReplyReader()

    @property
    def connected(self) -> bool:
        """Whether the link is up as far as known."""
        return self._link.is_open

    async def connect(self) -> None:
        """Open the link and ask who is there; raises ConnectFailedError."""
        await self._link.open()
        try:
            await self.identify()
        except (NoReplyError, ConnectionLostError) as error:
            raise ConnectFailedError(str(error)) from error

    async def close(self) -> None:
        """Close the link; never raises."""
        await self._link.close()

    async def identify(self) -> DeviceIdentity:
        """Ask for model and software number; the counter knows no serial number of its gauge."""
        async with self._turn():
            await self._link.send(encode_request(IDENTITY))
            lines = [await self._next_line() for _ in range(_IDENTITY_LINES)]
        model, software, _ = decode_identity(lines)
        return DeviceIdentity("HEIDENHAIN", model or "unknown", "unknown", software or "unknown")

    async def read(self) -> BallbarReading:
        """Return what the counter displays now; no signal where it displays an error instead."""
        answers, lamps = await self._ask_state()
        time_s = await self._clock.now_s()
        resolution_mm = to_mm(1, lamps)
        if answers.value is None or answers.error_text is not None:
            return BallbarReading(math.nan, "none", resolution_mm, time_s)
        deviation_mm = to_mm(decode_count(answers.value), lamps)
        sorted_out = lamps.below or lamps.above
        return BallbarReading(deviation_mm, "out_of_range" if sorted_out else "good", resolution_mm, time_s)

    async def _ask_state(self) -> tuple[_Answers, Lamps]:
        """Ask for error text, value and lamps at once, which the counter's buffer holds easily.

        Whether a counter without an error refuses A0301 or ignores it is not in the manual; the lamps come
        last and answer always, so that either does.
        """
        async with self._turn():
            await self._link.send(b"".join(map(encode_request, (ERROR_TEXT, VALUE, LAMPS))))
            answers = _Answers()
            while (lamps := answers.lamps) is None:
                answers = _with(answers, await self._next_reply())
                if answers.refusals == _MOST_REFUSALS - (answers.value is not None):
                    raise NdProtocolError(
                        f"the counter at {self._link.address} does not tell its status indicators (A0800):"
                        " it is none of the ND 2xx B or ND 287"
                    )
        return answers, decode_lamps(lamps)

    @contextlib.asynccontextmanager
    async def _turn(self) -> AsyncIterator[None]:
        """Take the floor; a conversation that broke off closes the link, as a late reply would be misread."""
        async with self._lock:
            try:
                self._reader = ReplyReader()
                while await self._link.receive(0.0) is not None:
                    pass  # prints that somebody asked for at the counter's keys
                yield
            except BaseException:
                await self._link.close()
                raise

    async def _next_line(self) -> Line:
        reply = await self._next_reply()
        if not isinstance(reply, Line):
            raise NdProtocolError(f"the counter at {self._link.address} refuses to say what it is (A0000)")
        return reply

    async def _next_reply(self) -> Reply:
        give_up_s = time.monotonic() + self._reply_timeout_s
        while (reply := self._reader.next_reply()) is None:
            data = await self._link.receive(max(0.0, give_up_s - time.monotonic()))
            if data is None:
                raise NoReplyError(
                    f"the counter at {self._link.address} says nothing for {self._reply_timeout_s:.1f} s:"
                    f" {_CHECK_LINE}"
                )
            self._reader.receive_data(data)
        return reply


def _with(answers: _Answers, reply: Reply) -> _Answers:
    """Put a reply where it belongs; error text, value and lamps are told apart by their form."""
    if isinstance(reply, Refused):
        return replace(answers, refusals=answers.refusals + 1)
    if not isinstance(reply, Line) or not reply.opened:
        return answers  # an operator pressed PRINT meanwhile
    match reply_kind(reply):
        case "value":
            return replace(answers, value=reply)
        case "lamps":
            return replace(answers, lamps=reply)
        case "text":
            return replace(answers, error_text=reply.text.strip())


def _open(options: Options, clock: Clock | None) -> HeidenhainCounter:
    port = option.text(options, "serial")
    if port is None:
        tcp = TcpLink(option.host(options), option.port(options, _TERMINAL_SERVER_PORT))
        return HeidenhainCounter(tcp, clock or MonotonicClock())
    if "host" in options or "port" in options:
        raise ConfigurationError("serial and host are two ways to the same counter: give one of them")
    baud = _baud(options)
    return HeidenhainCounter(
        SerialLink(port, replace(_FACTORY, baud=baud)),
        clock or MonotonicClock(),
        reply_timeout_s=_REPLY_TIMEOUT_S + _ON_THE_LINE_BITS / baud,
    )


def _baud(options: Options) -> int:
    baud = options.get("baud", _FACTORY.baud)
    if isinstance(baud, bool) or not isinstance(baud, int) or baud not in _RATES:
        raise ConfigurationError(f"option baud is {baud!r}: give one of {', '.join(map(str, _RATES))}")
    return baud


PLUGIN = DriverPlugin(
    name="heidenhain_nd",
    kind="ballbar",
    protocol="nd28x",
    options={
        "serial": "name of the serial port, such as /dev/ttyUSB0 or COM3, or a URL of pyserial",
        "baud": f"rate set at the counter, {_FACTORY.baud} unless changed; always 7E2",
        "host": "instead of serial: address of a terminal server in raw mode",
        "port": f"TCP port of the terminal server's line, {_TERMINAL_SERVER_PORT} unless changed",
    },
    open=_open,
)
