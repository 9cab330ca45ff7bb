"""The clock of a simulated cell over TCP."""

import contextlib
from collections.abc import AsyncIterator, Callable

from truepose_drivers import options as option
from truepose_drivers.api import Clock, DriverPlugin, Options
from truepose_drivers.cell_clock.protocol import Now, Request, Sleep, Time, decode_answer, encode
from truepose_drivers.errors import DeviceRefusedError
from truepose_drivers.framing import LineReader, Refusal
from truepose_drivers.transports.conversation import Conversation
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
        self._idle: list[Conversation[bytes]] = []

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
        async with self._conversation() as conversation:
            where = f"the cell's clock at {conversation.address}"
            silence = f"{where} did not respond within {timeout_s:g} s"
            answer = await conversation.ask(
                encode(request), decode_answer, timeout_s=timeout_s, silence=silence
            )
        match answer:
            case Time(now_s):
                return now_s
            case Refusal(sentence):
                raise DeviceRefusedError(f"{where} refused: {sentence}")

    @contextlib.asynccontextmanager
    async def _conversation(self) -> AsyncIterator[Conversation[bytes]]:
        """Lend a connection; one that broke off is closed by now, and opened again for the next question."""
        conversation = self._idle.pop() if self._idle else Conversation(self._open_link(), LineReader)
        if not conversation.is_open:
            await conversation.open()
        try:
            yield conversation
        finally:
            if conversation.is_open:
                self._idle.append(conversation)


def _open(options: Options, clock: Clock) -> CellClock:
    host, port = option.host(options), option.port(options)
    return CellClock(lambda: TcpLink(host, port))


_OPTIONS = {
    "host": "address of the simulated cell",
    "port": "TCP port of its clock",
}
PLUGIN = DriverPlugin("cell_clock", "clock", "clock", _OPTIONS, _open)
