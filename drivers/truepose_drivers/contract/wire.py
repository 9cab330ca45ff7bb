"""Lines in memory to a device that a bench plays, on which everything may go wrong that can on real ones.

A device answers with pieces: bytes, pauses, silence until it is asked again, a hang-up. What a fault makes of
an answer is a function from pieces to pieces. Time is that of the event loop, which jumps (`simulated_time`).
"""

import asyncio
import contextlib
import math
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose_drivers.errors import ConnectFailedError, ConnectionLostError
from truepose_drivers.transports.link import now_s

STALL_S: Final = 0.05  # longer than any gap by which a driver might tell the end of a reply
_ANSWERS_AFTER_S: Final = 0.001
_KEPT: Final = 100  # questions and answers, the last ones
_INSTANT_S: Final = 1e-9  # below it two times are one, whatever doubles make of them


@dataclass(frozen=True, slots=True)
class Pause:
    """Nothing comes for a while."""

    duration_s: float = STALL_S


class Silence:
    """Nothing comes any more before somebody asks again."""


class HangUp:
    """The device closes the connection."""


Piece: TypeAlias = bytes | Pause | Silence | HangUp
Answer: TypeAlias = Callable[[bytes], Sequence[Piece]]
Speech: TypeAlias = Callable[[], Sequence[Piece]]
Spoil: TypeAlias = Callable[[Sequence[Piece]], Sequence[Piece]]


class LoopClock:
    """The clock of a bench's cell: that of the event loop."""

    async def now_s(self) -> float:
        """Return the present time [s]."""
        return now_s()

    async def sleep(self, duration_s: float) -> None:
        """Let time pass."""
        await asyncio.sleep(duration_s)


class Wiring:
    """All lines to one device, and what has become of them."""

    def __init__(self) -> None:
        self.clock = LoopClock()
        self.spoil: Spoil | None = None  # of the next answer
        self.piece_bytes: int | None = None  # what arrives comes in pieces of so many at most
        self.deaf = False  # half-open: what is sent gets lost, and nothing comes
        self.unreachable = False
        self.sent: deque[bytes] = deque(maxlen=_KEPT)
        self.said: deque[bytes] = deque(maxlen=_KEPT)  # what the device answered, before any fault
        self.open_lines: list[Wire] = []

    def line(
        self,
        answer: Answer | None = None,
        *,
        greets: Speech | None = None,
        speaks: Speech | None = None,
        every_s: float = 0.01,
        remembers: bool = False,
    ) -> "Wire":
        """Lay a line to a device.

        It answers, greets whoever connects, speaks by itself, or does several of these. One that `remembers`
        delivers what was late even after it was opened anew, as a terminal server does.
        """
        return Wire(self, answer, greets, speaks, every_s, remembers)

    def say(self, *pieces: Piece) -> None:
        """Let the device say something that nobody asked for, on the line that was opened first."""
        for wire in self.open_lines[:1]:
            wire.arrive(pieces)

    def hang_up(self) -> None:
        """Let the device drop all connections, as one that is switched off and on again."""
        for wire in self.open_lines:
            wire.arrive([HangUp()])

    def spoiled(self, said: Sequence[Piece]) -> Sequence[Piece]:
        """Return what becomes of an answer."""
        spoken = [piece for piece in said if isinstance(piece, bytes)]
        self.said.extend(spoken)
        if self.spoil is None or not spoken:
            return said
        spoil, self.spoil = self.spoil, None
        return spoil(said)


class Wire:
    """One line, as a driver's link sees it."""

    address = "the bench"

    def __init__(
        self,
        wiring: Wiring,
        answer: Answer | None,
        greets: Speech | None,
        speaks: Speech | None,
        every_s: float,
        remembers: bool,
    ) -> None:
        self._wiring = wiring
        self._answer = answer
        self._greets = greets
        self._speaks = speaks
        self._every_s = every_s
        self._remembers = remembers
        self._arriving: deque[tuple[float, bytes | HangUp]] = deque()
        self._late: list[Piece] = []
        self._news = asyncio.Event()

    @property
    def is_open(self) -> bool:
        """Whether the line is up as far as known."""
        return self in self._wiring.open_lines

    async def open(self) -> None:
        """Connect, dropping what was open before; raises ConnectFailedError."""
        await self.close()
        if self._wiring.unreachable:
            raise ConnectFailedError("no response from the bench: check power, cable and address")
        self._wiring.open_lines.append(self)
        self._arriving.clear()
        if not self._remembers:
            self._late.clear()
        if self._greets is not None:
            self.arrive(self._wiring.spoiled(self._greets()))

    async def close(self) -> None:
        """End the connection; never raises."""
        if self.is_open:
            self._wiring.open_lines.remove(self)
        self._news.set()

    async def send(self, data: bytes) -> None:
        """Hand `data` to the device; raises ConnectionLostError."""
        self._require_open()
        self._wiring.sent.append(data)
        if self._wiring.deaf:
            return
        late, self._late = self._late, []  # comes when nobody drains any more
        said = self._answer(data) if self._answer is not None else ()
        self.arrive([Pause(_ANSWERS_AFTER_S), *late, *self._wiring.spoiled(said)])

    async def receive(self, timeout_s: float) -> bytes | None:
        """Return what has arrived, None after `timeout_s` of silence; raises ConnectionLostError."""
        give_up_s = now_s() + timeout_s
        while True:
            self._require_open()
            if self._arriving and self._arriving[0][0] <= now_s() + _INSTANT_S:
                return await self._take()
            if now_s() >= give_up_s - _INSTANT_S:
                return None
            await self._wait(give_up_s)

    def arrive(self, pieces: Sequence[Piece]) -> None:
        """Let pieces follow what is under way; behind silence they wait for the next question."""
        if self._wiring.deaf:
            return
        due_s = max(now_s(), self._arriving[-1][0] if self._arriving else -math.inf)
        for place, piece in enumerate(pieces):
            match piece:
                case Pause(duration_s):
                    due_s += duration_s
                case Silence():
                    self._late.extend(pieces[place + 1 :])
                    break
                case _:
                    self._arriving.extend((due_s, part) for part in self._parts(piece))
        self._news.set()

    def _parts(self, piece: bytes | HangUp) -> Sequence[bytes | HangUp]:
        most = self._wiring.piece_bytes
        if not piece or most is None or isinstance(piece, HangUp):
            return [piece] if piece else []
        return [piece[start : start + most] for start in range(0, len(piece), most)]

    async def _take(self) -> bytes:
        _, piece = self._arriving.popleft()
        if isinstance(piece, HangUp):
            await self.close()
            raise ConnectionLostError("the connection to the bench was lost: check it, then connect again")
        return piece

    async def _wait(self, give_up_s: float) -> None:
        """Wait for what is due, for what the device says by itself, or in vain."""
        until_s, speaks = give_up_s, False
        if self._arriving:
            until_s = min(until_s, self._arriving[0][0])
        elif self._speaks is not None and not self._wiring.deaf:
            until_s = min(until_s, now_s() + self._every_s)
            speaks = True
        self._news.clear()
        with contextlib.suppress(TimeoutError):
            async with asyncio.timeout_at(until_s):
                await self._news.wait()
            return
        if speaks and self.is_open and self._speaks is not None and until_s < give_up_s:
            self.arrive(self._wiring.spoiled(self._speaks()))

    def _require_open(self) -> None:
        if not self.is_open:
            raise ConnectionLostError("not connected to the bench: connect first")
