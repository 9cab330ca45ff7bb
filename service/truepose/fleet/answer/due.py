"""Which robot is to be measured next, and why.

First those whose change has passed the limit or will, by the day on which that has happened with 5 %; then
those that changed at once by less, the largest first; then those whose newest campaign is none of theirs;
then the others, the one measured longest ago first.
"""

import math
from dataclasses import dataclass
from typing import Final, Literal

from truepose.fleet.campaigns import Fleet
from truepose.fleet.changes import Account, Named
from truepose.fleet.forecast import Passing, passing

Why = Literal["passes", "changed", "unlike", "longest_ago"]
_ORDER: Final[dict[Why, int]] = {"passes": 0, "changed": 1, "unlike": 2, "longest_ago": 3}


@dataclass(frozen=True, slots=True)
class Due:
    """A robot, and what speaks for measuring it."""

    robot: str
    why: Why
    last_day: float  # on which it was measured
    named: Named | None = None
    passing: Passing | None = None  # of a line; a step that is beyond the limit has none
    instrument: str = ""  # that tells the change from its rivals; empty: any

    @property
    def urgency(self) -> tuple[int, float]:
        """What they are ordered by, the smallest first."""
        first = self.last_day
        if self.why == "changed" and self.named is not None:
            first = -self.named.size_mm
        elif self.passing is not None:
            first = self.passing.earliest
        elif self.named is not None:
            first = self.named.change.since
        return _ORDER[self.why], first


def due(account: Account, limit_mm: float) -> tuple[Due, ...]:
    """Return every robot once, the one to be measured next first.

    Parameters
    ----------
    account : Account
    limit_mm : float
        Size of a change (root mean square at the measured configurations) that is not to be passed.
    """
    return tuple(sorted((_of(account, robot, limit_mm) for robot in account.fleet.robots), key=_urgency))


def _urgency(one: Due) -> tuple[int, float]:
    return one.urgency


def _of(account: Account, robot: str, limit_mm: float) -> Due:
    fleet = account.fleet
    last = float(fleet.day[fleet.robot == fleet.robots.index(robot)].max())
    own = [one for one in account.named if one.change.of == robot and _stays(one)]
    each = (_of_change(fleet, one, last, limit_mm) for one in own)
    left_out = max((one.day for one in account.unlike if one.robot == robot), default=last)
    without = Due(robot, "unlike", left_out) if left_out > last else Due(robot, "longest_ago", last)
    return min(each, key=_urgency, default=without)


def _stays(named: Named) -> bool:
    """Return whether a robot has changed to this day: what was so on one day only is over."""
    return named.change.scope == "robot" and named.change.kind != "day"


def _of_change(fleet: Fleet, named: Named, last: float, limit_mm: float) -> Due:
    found = passing(fleet, named, limit_mm)
    instrument = _telling(fleet, named)
    if found is not None and math.isfinite(found.earliest):
        return Due(named.change.of, "passes", last, named, found, instrument)
    beyond = named.size_mm >= limit_mm
    return Due(named.change.of, "passes" if beyond else "changed", last, named, None, instrument)


def _telling(fleet: Fleet, named: Named) -> str:
    """Return an instrument that is none of the rivals, where one is among them."""
    doubtful = {one.change.of for one in named.rivals if one.change.scope == "instrument"}
    if not doubtful:
        return ""
    return next((name for name in fleet.instruments if name not in doubtful), "")
