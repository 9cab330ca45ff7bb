"""The one sentence that a comparison of robots begins with: changes within a limit, pass or fail.

A robot is within the limit where it was measured on two days at least and no change of it, or of its type,
has come to the limit. That is a pass only where a change as large as the limit would have been detected
(`least_of_robots`); what was so on one day alone is over.
"""

import numpy as np

from truepose.fleet.changes import Account, RealChange
from truepose.fleet.minimum_detectable_change import least_of_robots
from truepose.messages.message import Message, message


def fleet_outcome(account: Account, limit_mm: float) -> Message:
    """Return how many robots changed by less than a limit, which most, and pass, fail or what is missing.

    Parameters
    ----------
    account : Account
    limit_mm : float
        Size of a change (root mean square at the measured configurations) that is not to be reached.
    """
    robots = account.fleet.robots
    beyond = {robot for robot in robots if _changed_mm(account, robot) >= limit_mm}
    once = {robot for robot in robots if _days(account, robot) < 2} - beyond
    within = len(robots) - len(beyond) - len(once)
    counts = (
        message("outcome.fleet.within", limit_mm=limit_mm, count=within, robots=len(robots)),
        _largest(account, len(beyond)),
        *([message("outcome.fleet.once", count=len(once))] if once else []),
    )
    judged = message("outcome.fails") if beyond else _judged(account, limit_mm, once)
    return message("outcome.fleet", counts=counts, judged=judged)


def _changed_mm(account: Account, robot: str) -> float:
    """Return the largest change of a robot or of its whole type; 0 where none was found."""
    own = (one for one in account.named if one.change.scope == "type" or one.change.of == robot)
    return max((one.size_mm for one in own if _stays(one)), default=0.0)


def _stays(named: RealChange) -> bool:
    return named.change.scope != "instrument" and named.change.kind != "day"


def _days(account: Account, robot: str) -> int:
    fleet = account.fleet
    return len(np.unique(fleet.day[fleet.robot == fleet.robots.index(robot)]))


def _largest(account: Account, beyond: int) -> Message:
    """Return the largest change, with the number of robots beyond the limit where there are any."""
    known = [one for one in account.named if _stays(one)]
    if not known:
        return message("outcome.fleet.none")
    largest = max(known, key=lambda one: one.size_mm)
    who, size_mm = largest.change.of or message("outcome.fleet.type"), largest.size_mm
    if beyond:
        return message("outcome.fleet.beyond", count=beyond, who=who, size_mm=size_mm)
    return message("outcome.fleet.largest", who=who, size_mm=size_mm)


def _judged(account: Account, limit_mm: float, once: set[str]) -> Message:
    """Return whether a change as large as the limit would have been detected, or what is missing."""
    if once:
        return message("outcome.fleet.again")
    least_mm = max((float(one.size_mm.max()) for one in least_of_robots(account) if one.of), default=0.0)
    if np.isinf(least_mm):
        return message("outcome.fleet.hidden")
    if least_mm > limit_mm:
        return message("outcome.fleet.undecided", least_mm=least_mm)
    return message("outcome.passes")


def fleet_missing(limit_mm: float) -> Message:
    """Return what is missing where robots cannot be compared yet."""
    return message("outcome.fleet.missing", limit_mm=limit_mm)
