"""The conversation with a variable proxy: one variable at a time, by numbered requests.

The proxy hangs up on whoever is silent for half a minute: it is pinged meanwhile.
"""

import asyncio
import contextlib
from collections.abc import Callable
from typing import Final, TypeVar

from truepose_drivers.errors import DeviceRefusedError, DriverError
from truepose_drivers.kuka_variable_proxy.protocol.frames import (
    NUMBERS,
    Answer,
    AnswerReader,
    ProxyProtocolError,
    Request,
    encode_request,
)
from truepose_drivers.kuka_variable_proxy.protocol.variables import Variable
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link

_PING_EVERY_S: Final = 10.0  # the proxy hangs up after 30 s

Value = TypeVar("Value")


class VariableProxy:
    """Variables of a controller by their names."""

    def __init__(self, link: Link, *, reply_s: float) -> None:
        self._conversation = Conversation[Answer](link, AnswerReader, harmless=(DeviceRefusedError,))
        self._reply_s = reply_s
        self._number = 0
        self._pinging: asyncio.Task[None] | None = None

    @property
    def is_open(self) -> bool:
        """Whether the link is up as far as known."""
        return self._conversation.is_open

    async def open(self) -> None:
        """Connect; raises ConnectFailedError."""
        await self._stop_pinging()
        await self._conversation.open()
        self._pinging = asyncio.create_task(self._ping())

    async def close(self) -> None:
        """End the connection; never raises."""
        await self._stop_pinging()
        await self._conversation.close()

    async def read(self, name: str, decode: Callable[[str], Value]) -> Value:
        """Return what a variable says; raises DeviceRefusedError where there is none of that name."""
        async with self._conversation.turn():
            answer = await self._answer(name)
            if not answer.done or not answer.value:
                raise DeviceRefusedError(f"the robot has no variable {name}, or does not tell it")
            return decode(answer.value)

    async def write(self, name: str, value: str) -> None:
        """Write a variable; raises DeviceRefusedError where it cannot be written."""
        async with self._conversation.turn():
            if not (await self._answer(name, value)).done:
                raise DeviceRefusedError(f"the robot does not let its variable {name} be set to {value}")

    async def _answer(self, name: str, value: str | None = None) -> Answer:
        """Send a request and return its answer, by number and mode."""
        self._number = (self._number + 1) % NUMBERS
        request = Request(self._number, name, value)
        await self._conversation.drain()
        await self._conversation.send(
            encode_request(request),
            timeout_s=self._reply_s,
            silence=f"the proxy at {self._conversation.address} is connected and says nothing: see that its"
            " program runs on the controller, then connect again",
        )
        answer = await self._conversation.next()
        if (answer.number, answer.mode) != (request.number, request.mode):
            raise ProxyProtocolError(
                f"the proxy answers request {answer.number}, and {request.number} was asked: connect again"
            )
        if not await self._conversation.is_quiet():
            raise ProxyProtocolError("the proxy answers more than was asked: connect again")
        return answer

    async def _ping(self) -> None:
        with contextlib.suppress(DriverError):  # whoever asks next is told
            while True:
                await asyncio.sleep(_PING_EVERY_S)
                async with self._conversation.turn():
                    await self._answer(Variable.PING)

    async def _stop_pinging(self) -> None:
        pinging, self._pinging = self._pinging, None
        if pinging is not None:
            pinging.cancel()
            await asyncio.wait({pinging})
