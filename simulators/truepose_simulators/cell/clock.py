"""The cell's own clock: everyone in the cell sees the same time."""

import asyncio
import time
from collections.abc import Awaitable, Callable
from typing import Literal

Pace = Literal[0, 1]


class CellClock:
    """Cell time [s] since the start, at pace 1 (real time) or 0 (waiting costs no wall time).

    At pace 0 time stands still until somebody waits, moves or measures; each of these moves it on.
    """

    def __init__(
        self,
        pace: Pace = 0,
        *,
        wall_s: Callable[[], float] = time.monotonic,
        wall_sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._pace = pace
        self._wall_s = wall_s
        self._wall_sleep = wall_sleep
        self._start_s = wall_s()
        self._virtual_s = 0.0

    @property
    def waits(self) -> bool:
        """Whether sleeping takes wall time, so that others may act meanwhile."""
        return self._pace == 1

    @property
    def now_s(self) -> float:
        """Present cell time [s]."""
        return self._wall_s() - self._start_s if self.waits else self._virtual_s

    def go_at(self, pace: Pace) -> None:
        """From now on go at this pace, from the present time on."""
        now_s = self.now_s
        self._pace = pace
        self._start_s = self._wall_s() - now_s
        self._virtual_s = now_s

    async def sleep(self, duration_s: float) -> None:
        """Let `duration_s` (0 or more) of cell time go by."""
        if self.waits:
            await self._wall_sleep(duration_s)
        else:
            self._virtual_s += duration_s
