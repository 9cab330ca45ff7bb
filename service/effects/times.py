"""When readings were taken: what effects that run or happen in time ask of it."""

import numpy as np

from service.domain.arrays import FloatArray
from service.effects.causes import Scene, varied
from service.effects.ports import Rows

SECONDS_PER_HOUR = 3600.0


def hours_since(rows: Rows, start_s: float) -> FloatArray:
    """Return the time of each row after a moment [h], NaN where it is unknown, shape (n,)."""
    time_s = rows.stops.time_s
    if time_s is None:
        return np.full(len(rows.stops), np.nan)
    return np.asarray((time_s - start_s) / SECONDS_PER_HOUR)


def duration_s(scene: Scene) -> float:
    """Return how long after the origin of times the last reading was taken; 0 without times."""
    time_s = scene.stops.time_s
    known = np.zeros(0) if time_s is None else time_s[np.isfinite(time_s)]
    return float(known.max() - scene.origin_s) if known.size else 0.0


def without_times(scene: Scene) -> str | None:
    """Return why nothing that runs in time can be seen, None where it can."""
    if varied(scene.stops.time_s):
        return None
    return "the times of the readings are not known: record when each was taken (time_s)"


def spoken(seconds: float) -> str:
    """Return a span of time as one says it, e.g. `21 min`."""
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    if seconds < 2.0 * SECONDS_PER_HOUR:
        return f"{seconds / 60.0:.0f} min"
    return f"{seconds / SECONDS_PER_HOUR:.1f} h"
