"""Whether a robot has warmed up: ISO 9283:1998 lets a test of drift end before its eight hours then.

Compared are two rates, each the slope of the barycentres over an hour: that of the first hour and that of the
last. A slope, since the change between two groups ten minutes apart is mostly the scatter of the instrument.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray

SETTLED: Final = 0.1  # of the rate of the first hour
_HOUR_S: Final = 3600.0
_EARLY: Final = 0.05  # of an hour; groups are a little late, and never all by the same


def has_settled(time_s: FloatArray, barycentre_mm: FloatArray) -> bool:
    """Return whether the rate of change over the last hour is below a tenth of that over the first.

    Parameters
    ----------
    time_s : ndarray, shape (k,)
        Of groups, ascending.
    barycentre_mm : ndarray, shape (k, 3)

    Returns
    -------
    bool
        False also where the two hours overlap, or one of them holds a single group.
    """
    first = time_s <= time_s[0] + (1.0 + _EARLY) * _HOUR_S
    last = time_s >= time_s[-1] - (1.0 + _EARLY) * _HOUR_S
    overlap = time_s[-1] - time_s[0] < (2.0 - _EARLY) * _HOUR_S
    if overlap or first.sum() < 2 or last.sum() < 2:
        return False
    return _rate(time_s, barycentre_mm, last) < SETTLED * _rate(time_s, barycentre_mm, first)


def _rate(time_s: FloatArray, places_mm: FloatArray, rows: BoolArray) -> float:
    """Return the size of the slope of places over time [mm/s]."""
    away_s = time_s[rows] - time_s[rows].mean()
    return float(np.linalg.norm(away_s @ places_mm[rows]) / (away_s @ away_s))
