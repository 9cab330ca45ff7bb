"""The clock of a simulated cell over TCP."""

import contextlib
from collections.abc import AsyncIterator, Callable

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DriverPlugin, Options
from truepose_drivers.cell_clock.protocol import (
    Answer,
    ClockProtocolError,
    Now,
    Refusal,
    Request,
    Sleep,
    Time,
    decode_answer,
    encode,
)
from truepose_drivers.errors import DeviceRefusedError, NoReplyError
from truepose_drivers.json_lines import LineReader
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.tcp import TcpLink

_ANSWER_TIMEOUT_S = 30.0  # wall time; a paced cell needs the duration of a sleep in addition


class CellClock:
    """A clock that several tasks may ask at once: one that sleeps does not hold up one that asks the time.

    Connections are opened when needed and kept for the next question. `open_link` makes a new, closed link.
    """

    def __init__(self, open_link: Callable[[], Link], *, answer_timeout_s: float = _ANSWER_TIMEOUT_S) -> None:
        self._open_link = open_link
        self._answer_timeout_s = answer_timeout_s
        self._idle: list[Link] = []

    async def now_s(self) -> float:
        """Return the present cell time [s]."""
        return await self._ask(Now(), self._answer_timeout_s)

    async def sleep(self, duration_s: float) -> None:
        """Let the cell's time advance by `duration_s`."""
        await self._ask(Sleep(duration_s), self._answer_timeout_s + duration_s)

    async def close(self) -> None:
        """Close every connection; the next question opens one again."""
        while self._idle:
            await self._idle.pop().close()

    async def _ask(self, request: Request, timeout_s: float) -> float:
        async with self._connection() as link:
            await link.send(encode(request))
            match await _receive_answer(link, timeout_s):
                case Time(now_s):
                    return now_s
                case Refusal(sentence):
                    raise DeviceRefusedError(f"the cell's clock at {link.address} refused: {sentence}")

    @contextlib.asynccontextmanager
    async def _connection(self) -> AsyncIterator[Link]:
        """Lend a connection; one that failed or was abandoned in mid-answer is closed, not lent again."""
        link = self._idle.pop() if self._idle else self._open_link()
        try:
            if link.is_open and await link.receive(0.0) is not None:
                await link.close()  # an answer that nobody waits for must not be taken for the next one's
            if not link.is_open:
                await link.open()
            yield link
        except DeviceRefusedError:
            self._idle.append(link)
            raise
        except BaseException:
            await link.close()
            raise
        self._idle.append(link)


async def _receive_answer(link: Link, timeout_s: float) -> Answer:
    reader = LineReader()
    while (line := reader.next_line()) is None:
        data = await link.receive(timeout_s)
        if data is None:
            raise NoReplyError(f"the cell's clock at {link.address} says nothing for {timeout_s:g} s")
        reader.receive_data(data)
    if reader.inside_line or await link.receive(0.0) is not None:
        raise ClockProtocolError(f"the cell's clock at {link.address} answered more than was asked")
    return decode_answer(line)


def _open(options: Options, clock: Clock | None) -> CellClock:
    host, port = option.host(options), option.port(options)
    return CellClock(lambda: TcpLink(host, port))


PLUGIN = DriverPlugin(
    name="cell_clock",
    kind="clock",
    protocol="clock",
    options={
        "host": "address of the simulated cell",
        "port": "TCP port of its clock",
    },
    open=_open,
)
