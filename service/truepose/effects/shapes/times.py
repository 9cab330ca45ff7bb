"""When readings were taken: what effects that run or happen in time ask of it.

While a model is made, nothing runs or happens for rows that do not tell when they are. Once it is made, such
a row is about the robot as the last reading left it: what has happened is past.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.sentences import Sentence, Text, said
from truepose.effects.causes import Scene, varied
from truepose.effects.ports import Rows

SECONDS_PER_HOUR = 3600.0


def moments_s(rows: Rows) -> FloatArray:
    """Return the time of each row [s], shape (n,); where it is unknown NaN, of a made model infinity."""
    unknown = np.nan if rows.last_s is None else np.inf
    time_s = rows.stops.time_s
    if time_s is None:
        return np.full(len(rows.stops), unknown)
    return np.where(np.isfinite(time_s), time_s, unknown)


def hours_since(rows: Rows, start_s: float) -> FloatArray:
    """Return the time of each row after a moment [h], as `moments_s` where it is unknown, shape (n,)."""
    return np.asarray((moments_s(rows) - start_s) / SECONDS_PER_HOUR)


def hours_followed(rows: Rows) -> FloatArray:
    """Return the time after the origin [h] as far as readings followed it, NaN where unknown, shape (n,).

    Beyond the first and the last reading of a made model it stands still.
    """
    hours = hours_since(rows, rows.origin_s)
    if rows.last_s is None:
        return hours
    return np.clip(hours, 0.0, (rows.last_s - rows.origin_s) / SECONDS_PER_HOUR)


def duration_s(scene: Scene) -> float:
    """Return how long after the origin of times the last reading was taken; 0 without times."""
    time_s = scene.stops.time_s
    known = np.zeros(0) if time_s is None else time_s[np.isfinite(time_s)]
    return float(known.max() - scene.origin_s) if known.size else 0.0


def without_times(scene: Scene) -> Text | None:
    """Return why nothing that runs in time can be seen, None where it can."""
    if varied(scene.stops.time_s):
        return None
    return said("unseen.no_times")


def spoken(seconds: float) -> Sentence:
    """Return a span of time as one says it, e.g. `21 min`."""
    if seconds < 120.0:
        return said("span.seconds", seconds=seconds)
    if seconds < 2.0 * SECONDS_PER_HOUR:
        return said("span.minutes", minutes=seconds / 60.0)
    return said("span.hours", hours=seconds / SECONDS_PER_HOUR)
