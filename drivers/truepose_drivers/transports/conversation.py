"""The conversation with a device: one exchange at a time, and no answer taken for that to another question.

Answers of most instruments carry no number. An exchange that is left before its end (silence, a lost
connection, nonsense, a task that was cancelled) closes the connection, so that its late answer finds nobody.
"""

import asyncio
import contextlib
import math
from collections.abc import AsyncIterator, Callable
from typing import Generic, Protocol, TypeVar

from truepose_drivers.errors import ConnectionLostError, DriverError, NoReplyError, RemoteProtocolError
from truepose_drivers.transports.link import MOST_PIECES, Link, OverPort, Port, Source, drain, now_s, unending

Message = TypeVar("Message")
Answer = TypeVar("Answer")
Read = TypeVar("Read", covariant=True)


class Reader(Protocol[Read]):
    """What a codec offers for its side of the wire: bytes in, messages out."""

    @property
    def inside_message(self) -> bool:
        """Whether more stands here than was taken."""
        ...

    def receive_data(self, data: bytes) -> None:
        """Append what arrived."""
        ...

    def next_message(self) -> Read | None:
        """Take the oldest whole message, None until more arrives; raises RemoteProtocolError."""
        ...


class Turns(OverPort):
    """Whose turn it is on a connection; errors that are `harmless` end an exchange as an answer does."""

    def __init__(self, port: Port, *, harmless: tuple[type[DriverError], ...] = ()) -> None:
        super().__init__(port)
        self._harmless = harmless
        self._lock = asyncio.Lock()

    @property
    def taken(self) -> bool:
        """Whether an exchange is under way."""
        return self._lock.locked()

    @contextlib.asynccontextmanager
    async def turn(self) -> AsyncIterator[None]:
        """Wait for the exchange before, and have the next one wait; one that breaks off closes the port."""
        async with self._lock:
            # One exchange at a time: without numbers in its answers a protocol tells them apart by their
            # order alone.
            try:
                yield
            except self._harmless:
                # A refusal is a whole answer: nothing of this exchange is still under way.
                raise
            except BaseException:
                # BaseException, so that a cancelled task counts too: its answer is still to come, and would
                # be read as that to the next question.
                await self._port.close()
                raise


class Listener(Turns, Generic[Message]):
    """What a device says, taken apart by the reader of its codec."""

    def __init__(
        self,
        source: Source,
        new_reader: Callable[[], Reader[Message]],
        *,
        harmless: tuple[type[DriverError], ...] = (),
    ) -> None:
        super().__init__(source, harmless=harmless)
        self._source = source
        self._new_reader = new_reader
        self._reader = new_reader()
        self._give_up_s = 0.0
        self._silence = ""

    @property
    def inside_message(self) -> bool:
        """Whether more has arrived than was taken."""
        return self._reader.inside_message

    async def open(self) -> None:
        """Connect and listen afresh; raises ConnectFailedError."""
        self._reader = self._new_reader()
        await self._source.open()

    def expect(self, timeout_s: float, silence: str) -> None:
        """Allow `timeout_s` [s, wall time] from now for all that `next` returns, then raise `silence`."""
        self._give_up_s = now_s() + timeout_s
        self._silence = silence

    async def next(self) -> Message:
        """Return the next message; raises NoReplyError, also where other bytes come and end none in time."""
        while (message := await self.next_within(math.inf)) is None:
            pass
        return message

    async def next_within(self, quiet_s: float) -> Message | None:
        """Return the next message, None after `quiet_s` without a byte; raises what `next` raises."""
        while (message := self._reader.next_message()) is None:
            left_s = self._give_up_s - now_s()
            data = await self._receive(max(0.0, min(left_s, quiet_s)))
            # Also where bytes go on coming: an instrument that streams something else would otherwise keep us
            # for ever.
            if left_s < 0.0 or (data is None and left_s <= quiet_s):
                raise NoReplyError(self._silence)
            if data is None:
                return None
            self._reader.receive_data(data)
        return message

    async def arrived(self) -> AsyncIterator[Message]:
        """Yield the messages that are here; raises RemoteProtocolError where they do not end."""
        for _ in range(MOST_PIECES):
            # Bounded: whoever sends faster than we read is at a wrong address, and would hold the loop.
            while (message := self._reader.next_message()) is not None:
                yield message
            if not await self._take_piece():
                return
        raise unending(self._source)

    async def is_quiet(self) -> bool:
        """Whether nothing stands behind the message taken last; what does is kept."""
        await self._take_piece()
        return not self._reader.inside_message

    async def _take_piece(self) -> bool:
        data = await self._receive(0.0)
        self._reader.receive_data(data or b"")
        return data is not None

    async def _receive(self, timeout_s: float) -> bytes | None:
        try:
            return await self._source.receive(timeout_s)
        except ConnectionLostError as error:
            if self._reader.inside_message:
                raise ConnectionLostError(f"{error} (it ended in the middle of a message)") from error
            raise


class Conversation(Listener[Message]):
    """Questions on a link and their answers."""

    def __init__(
        self,
        link: Link,
        new_reader: Callable[[], Reader[Message]],
        *,
        harmless: tuple[type[DriverError], ...] = (),
    ) -> None:
        super().__init__(link, new_reader, harmless=harmless)
        self._link = link

    async def drain(self) -> None:
        """Forget what arrived unasked, and what began; raises RemoteProtocolError where it does not end."""
        self._reader = self._new_reader()
        await drain(self._link)

    async def send(self, question: bytes, *, timeout_s: float, silence: str) -> None:
        """Send a question and expect what it is answered with."""
        await self._link.send(question)
        self.expect(timeout_s, silence)

    async def add(self, question: bytes) -> None:
        """Send something besides, while an answer is awaited; the time allowed for that stays."""
        await self._link.send(question)

    async def ask(
        self, question: bytes, decode: Callable[[Message], Answer], *, timeout_s: float, silence: str
    ) -> Answer:
        """Have a turn: ask, and return the one answer; raises NoReplyError, RemoteProtocolError."""
        async with self.turn():
            # What came unasked (an event, a late answer) is not the answer to what is asked now.
            await self.drain()
            await self.send(question, timeout_s=timeout_s, silence=silence)
            answer = decode(await self.next())
            # Bytes behind the answer mean that two answers came: which of them is ours nobody can say any
            # more.
            if not await self.is_quiet():
                raise RemoteProtocolError(
                    f"the device at {self.address} sent more data than requested: connect again"
                )
            return answer
