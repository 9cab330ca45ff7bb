"""Medians of repeated work.

Beside the wall time stands the processors' time, ended children included: where others are at work on the
machine, it is what can still be compared.
"""

import resource
import time
from collections.abc import Callable
from statistics import median
from typing import NamedTuple

_RUNS = 9
_ENOUGH_S = 20.0  # work that takes longer is not repeated as often


class Timing(NamedTuple):
    """Medians of so many runs, and the least time of processors that one of them took."""

    median_s: float
    runs: int
    cpu_s: float
    least_cpu_s: float


def timed(work: Callable[[], object], runs: int = _RUNS) -> Timing:
    """Return the median time of work, once done beforehand so that nothing is loaded in the first run."""
    work()
    taken, busy = list[float](), list[float]()
    while len(taken) < runs and sum(taken) < _ENOUGH_S:
        start, before = time.perf_counter(), _processors_s()
        work()
        taken.append(time.perf_counter() - start)
        busy.append(_processors_s() - before)
    return Timing(median(taken), len(taken), median(busy), min(busy))


def _processors_s() -> float:
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime
