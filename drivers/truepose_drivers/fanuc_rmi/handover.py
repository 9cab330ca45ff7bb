"""The way to a session: a first port names the second one, where everything else is said."""

import contextlib
from collections.abc import Callable
from typing import Final

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError, LinkError
from truepose_drivers.fanuc_rmi.protocol.messages import Session, error_of, handed_over, session
from truepose_drivers.fanuc_rmi.protocol.packets import Packet, PacketReader, RmiProtocolError, encode
from truepose_drivers.fanuc_rmi.protocol.refusals import in_words
from truepose_drivers.transports.conversation import Conversation
from truepose_drivers.transports.link import Link, open_patiently

_CONNECT: Final = session(Session.CONNECT)
_GOODBYE: Final = encode(session(Session.DISCONNECT))
_GOODBYE_S: Final = 0.3  # that its answer is waited for


class Handover:
    """A link that is opened at one port and goes on at another; whoever leaves it says so.

    The controller lets the next client in only some seconds after the last one: it is asked for so long.
    """

    def __init__(
        self, to_port: Callable[[int], Link], first_port: int, *, reply_s: float, patience_s: float
    ) -> None:
        self._to_port = to_port
        self._first = to_port(first_port)
        self._reply_s = reply_s
        self._patience_s = patience_s
        self._second: Link | None = None
        self.version = "RMI"  # of the interface, as it said when it was connected last

    @property
    def address(self) -> str:
        """Where the session began, for error texts."""
        return self._first.address

    @property
    def is_open(self) -> bool:
        """Whether the session is up as far as known."""
        return self._second is not None and self._second.is_open

    async def open(self) -> None:
        """Begin a session, dropping the one before; raises ConnectFailedError."""
        await self.close()
        await self._first.open()  # where nobody is, patience is of no use
        await open_patiently(
            self._go_on,
            within_s=self._patience_s,
            every_s=0.25,
            advice="also check that no other program is connected to the robot",
        )

    async def send(self, data: bytes) -> None:
        """Hand `data` to the session; raises ConnectionLostError."""
        await self._opened().send(data)

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        return await self._opened().receive(timeout_s)

    async def close(self) -> None:
        """Say that the session ends, which has the controller stop what it was told to do; never raises."""
        second, self._second = self._second, None
        if second is not None:
            with contextlib.suppress(LinkError):
                await second.send(_GOODBYE)
                await second.receive(_GOODBYE_S)
            await second.close()

    async def _go_on(self) -> None:
        if not self._first.is_open:
            await self._first.open()
        port = await self._ask_for_port()
        second = self._to_port(port)
        await second.open()
        self._second = second

    async def _ask_for_port(self) -> int:
        try:
            port, self.version = await Conversation[Packet](self._first, PacketReader).ask(
                encode(_CONNECT),
                _named_port,
                timeout_s=self._reply_s,
                silence=f"whoever is at {self.address} does not answer: is this the robot's address?",
            )
        finally:
            await self._first.close()
        return port

    def _opened(self) -> Link:
        if self._second is None:
            raise ConnectionLostError(f"there is no connection to {self.address}: connect first")
        return self._second


def _named_port(answer: Packet) -> tuple[int, str]:
    if (answer.kind, answer.name) != (_CONNECT.kind, _CONNECT.name):
        raise RmiProtocolError(f"the robot answers {answer.name} to {_CONNECT.name}")
    if (error := error_of(answer)) != 0:
        raise ConnectFailedError(f"the robot begins no session: {in_words(error)}")
    return handed_over(answer)
