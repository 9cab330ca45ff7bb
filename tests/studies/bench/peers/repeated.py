"""Times of repeated work, for the programs of the peers: nothing of truepose is in their environments."""

import time
from statistics import median

_RUNS = 3
_ENOUGH_S = 30.0  # work that takes longer is not repeated as often


def timed(work):
    """Return the median time of work [s], its runs, and its processor time in the median and at least."""
    taken, busy = [], []
    while len(taken) < _RUNS and sum(taken) < _ENOUGH_S:
        start, before = time.perf_counter(), time.process_time()
        work()
        taken.append(time.perf_counter() - start)
        busy.append(time.process_time() - before)
    return {
        "median_s": median(taken),
        "runs": len(taken),
        "cpu_s": median(busy),
        "least_cpu_s": min(busy),
    }
