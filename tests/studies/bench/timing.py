"""Medians of repeated work."""

import time
from collections.abc import Callable
from statistics import median
from typing import NamedTuple

_RUNS = 9
_ENOUGH_S = 20.0  # work that takes longer is not repeated as often


class Timing(NamedTuple):
    """Median of so many runs."""

    median_s: float
    runs: int


def timed(work: Callable[[], object], runs: int = _RUNS) -> Timing:
    """Return the median time of work, once done beforehand so that nothing is loaded in the first run."""
    work()
    taken: list[float] = []
    while len(taken) < runs and sum(taken) < _ENOUGH_S:
        start = time.perf_counter()
        work()
        taken.append(time.perf_counter() - start)
    return Timing(median(taken), len(taken))
