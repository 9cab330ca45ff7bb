r"""On which day a change that goes on evenly passes a limit, with its probability.

A line that has come to the size s, known to u, after the days from its beginning to the last campaign, comes
to a limit l after l / s times as long. As s is normal about what was found, the day has passed with
probability

    P(T <= t) = P(s (t - t_0) / (t_n - t_0) >= l) = Phi((s - l (t_n - t_0) / (t - t_0)) / u)

which is exact for a line. A step does not go on, and has no such day.

References
----------
C. J. Lu, W. Q. Meeker, Technometrics 35, 1993, 161-174 (time to a degradation level).
"""

import math
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray
from truepose.fleet.campaigns import Fleet
from truepose.fleet.changes import Named

BAND: Final = 0.90
_WITHIN: Final = 1.6448536269514722  # standard deviations either way that hold 90 %


@dataclass(frozen=True, slots=True)
class Passing:
    """When a limit is passed if the change goes on as it did; days of the fleet, infinite: perhaps never."""

    limit_mm: float
    day: float  # half of the probability before it
    earliest: float  # 5 %
    latest: float  # 95 %


def passing(fleet: Fleet, named: Named, limit_mm: float) -> Passing | None:
    """Return when a change passes a limit; None of a change that does not go on.

    Parameters
    ----------
    fleet : Fleet
    named : Named
    limit_mm : float
        Of its root mean square at the measured configurations.
    """
    if named.change.kind != "linear":
        return None
    first, last = _span(fleet, named)

    def at(size_mm: float) -> float:
        return first + limit_mm * (last - first) / size_mm if size_mm > 0.0 else math.inf

    low, high = (named.size_mm + way * _WITHIN * named.size_u_mm for way in (-1.0, 1.0))
    return Passing(limit_mm, at(named.size_mm), at(high), at(low))


def _span(fleet: Fleet, named: Named) -> tuple[float, float]:
    """Return the day since which a line goes on, and the last that saw it."""
    return named.change.since, float(fleet.day[concerned(fleet, named)].max())


def concerned(fleet: Fleet, named: Named) -> BoolArray:
    """Return which campaigns a change concerns, shape (C,)."""
    change = named.change
    if change.scope == "robot":
        return np.asarray(fleet.robot == fleet.robots.index(change.of))
    if change.scope == "instrument":
        return np.asarray(fleet.instrument == fleet.instruments.index(change.of))
    return np.ones(len(fleet.day), dtype=bool)
