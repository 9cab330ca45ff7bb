"""When a job gets a worker, and how long jobs take.

There are two cores, so two places: what is short has one of them that nothing long takes. How long a job
takes is known from what it is asked, corrected by how long earlier ones took here.

In what order jobs get a place is fair to those who ask: somebody's fifty wait behind somebody else's one
(start-time fair queueing: P. Goyal, H. M. Vin, H. Cheng, IEEE/ACM Trans. Networking 5(5), 1997, 690-704).
"""

import asyncio
import contextlib
import statistics
from collections.abc import AsyncIterator, Sequence
from dataclasses import dataclass, field
from typing import Final

from truepose.storage.records import JobKind, JobTaken

REMEMBERED: Final = 15  # earlier jobs of a kind; their median forgets one that the computer was busy at
_HARDLY_S: Final = 0.05
_NEARLY: Final = 0.95  # of the time foreseen: from there on a job that goes on is late
_LATE: Final = 0.25  # of the time it took so far is what a late job is said to need still


@dataclass(frozen=True, slots=True)
class _Usual:
    start_s: float
    each_s: float


# Seconds of one core of 2020; the worker's start, and each reading, configuration, pose or kB of a file.
_USUAL: Final = {
    JobKind.IDENTIFICATION: _Usual(2.0, 0.02),
    JobKind.VALIDATION: _Usual(1.5, 0.002),
    JobKind.DIAGNOSIS: _Usual(20.0, 0.2),
    JobKind.PLAN: _Usual(2.0, 0.1),
    JobKind.BALLBAR_PLAN: _Usual(3.0, 1.0),
    JobKind.CONTACT_PLAN: _Usual(1.5, 0.01),
    JobKind.CORRECTION: _Usual(2.0, 0.05),
}


def expected_s(kind: JobKind, work_count: int, earlier: Sequence[JobTaken]) -> float:
    """Return how long a job is expected to run [s], once it has a worker."""
    ratios = [taken.duration_s / _usual_s(kind, taken.work_count) for taken in earlier]
    return _usual_s(kind, work_count) * (statistics.median(ratios) if ratios else 1.0)


def _usual_s(kind: JobKind, work_count: int) -> float:
    usual = _USUAL[kind]
    return usual.start_s + usual.each_s * work_count


@dataclass(frozen=True, slots=True)
class Outlook:
    """How far a job is and how long it still takes."""

    fraction: float
    remaining_s: float


def outlook(expected_s: float, elapsed_s: float, told: float, told_at_s: float) -> Outlook:
    """Return how far a running job is, by what is foreseen and by what it tells of itself.

    Parameters
    ----------
    expected_s : float
        How long such a job takes [s].
    elapsed_s : float
        Since it has its worker [s].
    told : float
        Which fraction of its work it told last, 0 to 1; the more that is, the more it counts.
    told_at_s : float
        When it told that, since it has its worker [s].
    """
    # What a job tells of itself counts by the share that is done: its first percent says little of the rest.
    by_itself_s = told_at_s / told if told > 0 else expected_s
    total_s = max((1 - told) * expected_s + told * by_itself_s, _HARDLY_S)
    remaining_s = total_s - elapsed_s
    # Otherwise a job that takes longer than foreseen would be said to end in no time for as long as it runs.
    if elapsed_s > _NEARLY * total_s:
        remaining_s = max(remaining_s, _LATE * elapsed_s * (1 - told))
    return Outlook(min(max(told, elapsed_s / (elapsed_s + remaining_s)), 1.0), remaining_s)


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


class WorkerSlots:
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
        # The start tag of fair queueing: in virtual time a job begins where what its sender asked for before
        # ends, and never in the past. Fifty jobs of one sender stand one after the other; the one of another
        # begins now.
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
        # The third place is for this alone. With two long jobs in the other two, short ones would wait for
        # minutes (decision 0052).
        free = next((name for name in ("any", "misjudged") if name not in self._holders), None)
        if self._holders.get("short") is overdue and free is not None:
            self._holders[free] = self._holders.pop("short")
            self._serve()

    def _leave(self, mine: _Waiting) -> None:
        if mine in self._waiting:
            self._waiting.remove(mine)
        self._holders = {name: holder for name, holder in self._holders.items() if holder is not mine}
        # Nobody is behind anybody else now. Kept, the times of everyone who ever asked would grow for as long
        # as the service runs.
        if not self._waiting and not self._holders:
            self._ends.clear()
        self._serve()

    def _serve(self) -> None:
        # The short place first: short work that fits into it leaves the other one to what is long.
        for name in ("short", "any"):
            fit = [waiting for waiting in self._waiting if waiting.short or name == "any"]
            if name not in self._holders and fit:
                self._begin(name, min(fit, key=_order))

    def _begin(self, name: str, chosen: _Waiting) -> None:
        self._waiting.remove(chosen)
        self._holders[name] = chosen
        # Virtual time is the start tag of what was served last: it stands still while nothing is served.
        self._now = max(self._now, chosen.starts)
        chosen.turn.set()


def _order(waiting: _Waiting) -> tuple[float, int]:
    return waiting.starts, waiting.number
