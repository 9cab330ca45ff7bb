"""How far the clock of a cell is off the plant's: what one question and its answer leave open.

F. Cristian, Probabilistic clock synchronization, Distributed Computing 3 (1989), 146-158: an answer that
tells the time was given some time between question and answer, so the middle is off by half the round trip at
most. The quickest of several answers leaves least open. Nothing is set by it, nothing is put in order by it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timedelta
from typing import Final

from truepose.storage.plant.records import ClockSeen

_RESOLUTION_S: Final = 1e-6  # of a time as it is told


@dataclass(frozen=True, slots=True)
class Answered:
    """One question for the time, and its answer."""

    asked_at: datetime  # by the plant's clock
    took_s: float  # by a clock that nobody sets
    told: datetime  # by the cell's clock


def clock_seen(answers: Sequence[Answered]) -> ClockSeen:
    """Return how far a clock is off, by the quickest of the answers; there is one at least."""
    quickest = min(answers, key=lambda answer: answer.took_s)
    middle = quickest.asked_at + timedelta(seconds=quickest.took_s / 2)
    return ClockSeen((quickest.told - middle).total_seconds(), quickest.took_s / 2 + _RESOLUTION_S)
