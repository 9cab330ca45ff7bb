"""The cable of an endpoint: what becomes of words on it, as the faults of the cell have it."""

import asyncio
from collections.abc import Awaitable, Callable
from typing import Any, TypeAlias

from truepose_simulators.cell.environment import CellClock
from truepose_simulators.faults.kinds import LinkCut, LinkFault, LinkHalfOpen
from truepose_simulators.faults.scripted import Faults

Ends: TypeAlias = tuple[asyncio.StreamReader, asyncio.StreamWriter]

_IN_VAIN_S = 1.0  # that a word or an attempt to connect takes at pace 0; else no waiting would end a fault


class Cable:
    """A cable that nothing happens to."""

    async def connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> Ends | None:
        """Return what the server hears and speaks to; None where nobody can be reached."""
        return reader, writer

    @property
    def passes(self) -> bool:
        """Whether a datagram gets through now."""
        return True


class FaultyCable(Cable):
    """The cable of a device in a cell; `endpoint` is the device's name, or of a further port of it."""

    def __init__(self, endpoint: str, faults: Faults, clock: CellClock) -> None:
        self._device = endpoint.partition("-")[0]
        self._faults = faults
        self._clock = clock

    async def connect(self, reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> Ends | None:
        """Return the ends with their faults, None while it is cut: at pace 0 a second of the cell later."""
        if self._holds(LinkCut):
            await self.in_vain()
            return None
        # Abort, not close: what was still to be sent is lost with the cable.
        connection = Connection(self, writer.transport.abort)
        return CableReader(reader, connection), CableWriter(writer, reader, connection)

    @property
    def passes(self) -> bool:
        """Whether a datagram gets through now."""
        return not (self.mute or self._holds(LinkCut))

    async def in_vain(self) -> None:
        """Let the time go by that somebody loses; where it is real they wait by themselves."""
        if not self._clock.waits:
            await self._clock.sleep(_IN_VAIN_S)

    @property
    def mute(self) -> bool:
        """Whether words are lost now."""
        return self._holds(LinkHalfOpen)

    @property
    def cuts(self) -> int:
        """How often it has been cut so far."""
        now_s = self._clock.now_s
        return sum(
            isinstance(given.fault, LinkCut)
            and given.fault.device == self._device
            and given.began_s() <= min(now_s, given.over_s())
            for given in self._faults.given
        )

    def _holds(self, kind: type[LinkFault]) -> bool:
        return any(fault.device == self._device for fault, _ in self._faults.holding(kind, self._clock.now_s))


class Connection:
    """One connection over a cable; it breaks at the first word after a cut, or after words were lost."""

    def __init__(self, cable: FaultyCable, hang_up: Callable[[], None]) -> None:
        self._cable = cable
        self._hang_up = hang_up
        self._cuts = cable.cuts
        self._lost = False  # some word, so that the far end does not know it any more

    def carries(self) -> bool:
        """Whether a word arrives now."""
        if self.broken:
            self._hang_up()
            return False
        self._lost = self._lost or self._cable.mute
        return not self._cable.mute

    async def lose(self) -> None:
        """Lose a word."""
        await self._cable.in_vain()

    @property
    def broken(self) -> bool:
        """Whether it will not carry a word any more."""
        return self._cable.cuts > self._cuts or (self._lost and not self._cable.mute)


class CableReader(asyncio.StreamReader):
    """What a server hears of a client over a cable."""

    def __init__(self, heard: asyncio.StreamReader, connection: Connection) -> None:
        super().__init__()
        self._heard = heard
        self._connection = connection

    async def read(self, n: int = -1) -> bytes:
        """Return what comes next and arrives."""
        return await self._arrived(lambda: self._heard.read(n))

    async def readline(self) -> bytes:
        """Return the next line that arrives."""
        return await self._arrived(self._heard.readline)

    async def readexactly(self, n: int) -> bytes:
        """Return the next so many bytes that arrive."""
        return await self._arrived(lambda: self._heard.readexactly(n))

    def at_eof(self) -> bool:
        """Whether the client is gone."""
        return self._heard.at_eof()

    def exception(self) -> Exception | None:
        """Return why nothing can be read any more."""
        return self._heard.exception()

    async def _arrived(self, read: Callable[[], Awaitable[bytes]]) -> bytes:
        while data := await read():
            if self._connection.carries():
                return data
            if self._connection.broken:
                raise ConnectionResetError("the cable was cut")
            await self._connection.lose()
        return data


class CableWriter(asyncio.StreamWriter):
    """What a server says to a client over a cable."""

    def __init__(
        self, writer: asyncio.StreamWriter, heard: asyncio.StreamReader, connection: Connection
    ) -> None:
        protocol: Any = writer.transport.get_protocol()
        super().__init__(writer.transport, protocol, heard, asyncio.get_running_loop())
        self._connection = connection

    def write(self, data: bytes | bytearray | memoryview) -> None:
        """Say something; it may not arrive."""
        if self._connection.carries():
            super().write(data)
