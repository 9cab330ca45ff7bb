"""How long commits take: what a disk is like shows there first."""

import statistics
import time
from collections import deque
from collections.abc import Callable
from typing import Final

_KEPT: Final = 100


class Commits:
    """Told by the writer's thread, asked by everybody."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self._clock = clock
        self._latest: deque[tuple[float, float]] = deque(maxlen=_KEPT)  # when, and how long it took [s]
        self.told: Callable[[float], None] = lambda seconds: None  # who counts them, on the writer's thread

    def note(self, seconds: float) -> None:
        """Keep how long a commit took."""
        self._latest.append((self._clock(), seconds))
        self.told(seconds)

    def usual_s(self, within_s: float) -> float | None:
        """Return how long the commits of the last time usually took; None where there was none."""
        since = self._clock() - within_s
        recent = [seconds for when, seconds in tuple(self._latest) if when >= since]
        return statistics.median(recent) if recent else None
