"""Places for workers: two cores, so two; what is short has one of them that nothing long takes.

In what order jobs get a place is fair to those who ask: somebody's fifty wait behind somebody else's one
(start-time fair queueing: P. Goyal, H. M. Vin, H. Cheng, IEEE/ACM Trans. Networking 5(5), 1997, 690-704).
"""

import asyncio
import contextlib
from collections.abc import AsyncIterator
from dataclasses import dataclass, field
from typing import Final

SHORT_S: Final = 20.0  # a job that is foreseen to take no longer is short
_OVERDUE: Final = 3.0  # times that: what takes so long was no short one, and leaves the place to others


@dataclass(eq=False)
class _Waiting:
    number: int
    sender: str
    expected_s: float
    starts: float  # in the virtual time of fair queueing
    turn: asyncio.Event = field(default_factory=asyncio.Event)

    @property
    def short(self) -> bool:
        return self.expected_s <= SHORT_S


class Places:
    """Hands out places: one for anything, one for short work, and one that a misjudged short one moves to."""

    def __init__(self, short_s: float = SHORT_S) -> None:
        self._overdue_s = _OVERDUE * short_s
        self._waiting: list[_Waiting] = []
        self._holders: dict[str, _Waiting] = {}  # by the name of the place
        self._now = 0.0
        self._ends: dict[str, float] = {}  # of what each sender asked for last, in the virtual time

    def ahead(self, number: int) -> int:
        """Return how many jobs are given a place before a waiting one, as things stand."""
        order = sorted(self._waiting, key=_order)
        mine = next((waiting for waiting in order if waiting.number == number), None)
        if mine is None:
            return 0
        return sum(1 for waiting in order[: order.index(mine)] if waiting.short or not mine.short)

    @contextlib.asynccontextmanager
    async def place(self, number: int, expected_s: float, sender: str = "") -> AsyncIterator[None]:
        """Wait for a place and hold it within the context."""
        mine = self._queued(number, expected_s, sender)
        try:
            await mine.turn.wait()
            async with self._watched(mine):
                yield
        finally:
            self._leave(mine)

    def _queued(self, number: int, expected_s: float, sender: str) -> _Waiting:
        starts = max(self._now, self._ends.get(sender, 0.0))
        self._ends[sender] = starts + expected_s
        mine = _Waiting(number, sender, expected_s, starts)
        self._waiting.append(mine)
        self._serve()
        return mine

    @contextlib.asynccontextmanager
    async def _watched(self, mine: _Waiting) -> AsyncIterator[None]:
        alarm = asyncio.get_running_loop().call_later(self._overdue_s, self._move, mine)
        try:
            yield
        finally:
            alarm.cancel()

    def _move(self, overdue: _Waiting) -> None:
        """Let work that proves to be long leave the place of short ones, if there is another."""
        free = next((name for name in ("any", "misjudged") if name not in self._holders), None)
        if self._holders.get("short") is overdue and free is not None:
            self._holders[free] = self._holders.pop("short")
            self._serve()

    def _leave(self, mine: _Waiting) -> None:
        if mine in self._waiting:
            self._waiting.remove(mine)
        self._holders = {name: holder for name, holder in self._holders.items() if holder is not mine}
        if not self._waiting and not self._holders:
            self._ends.clear()
        self._serve()

    def _serve(self) -> None:
        for name in ("short", "any"):
            fit = [waiting for waiting in self._waiting if waiting.short or name == "any"]
            if name not in self._holders and fit:
                self._begin(name, min(fit, key=_order))

    def _begin(self, name: str, chosen: _Waiting) -> None:
        self._waiting.remove(chosen)
        self._holders[name] = chosen
        self._now = max(self._now, chosen.starts)
        chosen.turn.set()


def _order(waiting: _Waiting) -> tuple[float, int]:
    return waiting.starts, waiting.number
