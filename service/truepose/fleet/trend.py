r"""The trend of a cause over the months, when it passes a limit, and which robot is measured next.

A line that has come to the size s, known to u, after the days from its beginning to the last campaign, comes
to a limit l after l / s times as long. As s is normal about what was found, the day has passed with
probability

    P(T <= t) = P(s (t - t_0) / (t_n - t_0) >= l) = Phi((s - l (t_n - t_0) / (t - t_0)) / u)

which is exact for a line. A step does not go on, and has no such day.

Robots that are due: first those whose change has passed the limit or will, by the day on which that has
happened with 5 %; then those that changed at once by less, the largest first; then those whose newest
campaign is none of theirs; then the others, the one measured longest ago first.

References
----------
C. J. Lu, W. Q. Meeker, Technometrics 35, 1993, 161-174 (time to a degradation level).
"""

import math
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.fleet.campaigns import Fleet
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import Account, RealChange
from truepose.fleet.instrument_scales import InstrumentDays
from truepose.fleet.mixed_model import Equations, NamedChange, Posterior, estimate

_SPANS: Final = 12  # of time, into which the days of a whole type are gathered where there are more


@dataclass(frozen=True, slots=True)
class Trend:
    """A cause at the n later campaigns of a robot, in stated widths from what it was at the first.

    Attributes
    ----------
    day : ndarray, shape (n,)
        Ascending.
    amount : ndarray, shape (n, q)
        Along the directions of the cause.
    covariance : ndarray, shape (n, q, q)
    """

    day: FloatArray
    amount: FloatArray
    covariance: FloatArray


@dataclass(frozen=True, slots=True)
class ChangeSeries:
    """How far a named change had come on n days after the first, along itself; negative: the other way.

    Attributes
    ----------
    day : ndarray, shape (n,)
        Ascending.
    size_mm : ndarray, shape (n,)
    u_mm : ndarray, shape (n,)
        Standard uncertainties.
    """

    day: FloatArray
    size_mm: FloatArray
    u_mm: FloatArray


def course(
    account: Account, robot: str, cause: AgeingCause, excess: float = 1.0, variance: float = 1.0
) -> Trend:
    """Return by how much each later campaign of a robot sees a cause differ from the first.

    Parameters
    ----------
    account : Account
    robot : str
        Of the fleet.
    cause : AgeingCause
        Whatever of it was named in this robot is taken out of the model first.
    excess : float
        By which variances of this cause exceed what readings state, as of its trial.
    variance : float
        Of what each campaign may differ by, before any reading, in squared stated widths.

    Returns
    -------
    Trend
    """
    fleet = account.fleet
    own = np.flatnonzero(fleet.robot == fleet.robots.index(robot))
    later = own[np.argsort(fleet.day[own], kind="stable")][1:]
    # A step of its own for each campaign: no line is put through what is to show whether there is one.
    alone = np.eye(len(fleet.day))[later]
    return _course(account, robot, cause, fleet.day[later], alone, (excess, variance))


def along(account: Account, named: RealChange) -> ChangeSeries:
    """Return how a named change went: each campaign of a robot, day of an instrument, span of the type.

    Along a = `amount`, what was found on a day is s (x . a) / (a . a) with s the size of the change.

    Parameters
    ----------
    account : Account
    named : RealChange
        Of that account.

    Returns
    -------
    ChangeSeries
    """
    if named.change.scope == "instrument":
        return _of_instrument(account, named)
    if named.change.scope == "robot":
        found = course(account, named.change.of, named.change.cause, named.trial.excess, named.trial.variance)
    else:
        found = _of_type(account, named)
    way = named.amount / float(named.amount @ named.amount)
    u = np.sqrt(np.einsum("p,npq,q->n", way, found.covariance, way))
    return ChangeSeries(found.day, named.size_mm * found.amount @ way, named.size_mm * u)


def _of_type(account: Account, named: RealChange) -> Trend:
    """Return how all robots together went, from one span of days to the next.

    Days are gathered into twelve spans at most; the campaigns of each span but the first share a step.
    """
    day = account.fleet.day
    known = np.unique(day)
    if len(known) > _SPANS:
        ends = np.linspace(known[0], known[-1], _SPANS + 1)[1:-1]
        of = np.searchsorted(ends, day)
    else:
        of = np.searchsorted(known, day)
    numbers = np.unique(of)[1:]
    shapes = np.array([(of == number).astype(float) for number in numbers])
    days = np.array([day[of == number].mean() for number in numbers])
    allowed = named.trial.excess, named.trial.variance
    return _course(account, "", named.change.cause, days, shapes, allowed)


def _of_instrument(account: Account, named: RealChange) -> ChangeSeries:
    """Return how the lengths of an instrument differ from those of its first day.

    Scales s of the days, with the change itself out of the model: differences B s of covariance B C B'.
    """
    fleet = account.fleet
    others = [one.trial.named for one in account.named if not one.change.same_as(named.change)]
    posterior = estimate(Equations(fleet, others), account.estimated.variances).posterior
    # Free on every day, so that the course shows scatter and bends and not the line that was named.
    days = InstrumentDays(posterior)
    number = fleet.instruments.index(named.change.of)
    own = [k for k, visit in enumerate(fleet.visits) if visit[0] == number and days.told[k]]
    less = np.eye(len(days.scale))[own[1:]] - np.eye(len(days.scale))[own[0]]
    unit_mm = float(np.sqrt(fleet.motion_mm2[-1, -1])) * float(np.sign(named.amount[0]))
    spread = np.einsum("nd,de,ne->n", less, days.covariance, less)
    return ChangeSeries(
        np.array([fleet.visits[k][1] for k in own[1:]]),
        unit_mm * less @ days.scale,
        abs(unit_mm) * np.sqrt(spread),
    )


def _course(
    account: Account,
    of: str,
    cause: AgeingCause,
    days: FloatArray,
    shapes: FloatArray,
    allowed: tuple[float, float],
) -> Trend:
    """Return what is seen where each of n shapes over the campaigns, (n, C), is free.

    Each is a change of its own in the model, in place of what was named of that cause. `allowed` are the
    excess of its variances, and the variance of each before any reading.
    """
    excess, variance = allowed
    others = [one.trial.named for one in account.named if not one.change.is_of(of, cause)]
    free = [NamedChange(cause.directions, shape, variance) for shape in shapes]
    equations = Equations(account.fleet, [*others, *free])
    posterior = Posterior(equations, account.estimated.variances)
    places = [equations.of_change(len(others) + number) for number in range(len(free))]
    return Trend(
        days,
        np.array([posterior.shared[place] for place in places]),
        excess * np.array([posterior.covariance[place, place] for place in places]),
    )


BAND: Final = 0.90
_WITHIN: Final = 1.6448536269514722  # standard deviations either way that hold 90 %


@dataclass(frozen=True, slots=True)
class LimitCrossing:
    """When a limit is passed if the change goes on as it did; days of the fleet, infinite: perhaps never."""

    limit_mm: float
    day: float  # half of the probability before it
    earliest: float  # 5 %
    latest: float  # 95 %


def passing(fleet: Fleet, named: RealChange, limit_mm: float) -> LimitCrossing | None:
    """Return when a change passes a limit; None of a change that does not go on.

    Parameters
    ----------
    fleet : Fleet
    named : RealChange
    limit_mm : float
        Of its root mean square at the measured configurations.

    Returns
    -------
    LimitCrossing or None
        None of a change that does not go on.
    """
    if named.change.kind != "linear":
        return None
    first, last = _span(fleet, named)

    def at(size_mm: float) -> float:
        return first + limit_mm * (last - first) / size_mm if size_mm > 0.0 else math.inf

    # The fastest that the line may be passes first: its 95 % of size are the 5 % of the day.
    low, high = (named.size_mm + way * _WITHIN * named.size_u_mm for way in (-1.0, 1.0))
    return LimitCrossing(limit_mm, at(named.size_mm), at(high), at(low))


def _span(fleet: Fleet, named: RealChange) -> tuple[float, float]:
    """Return the day since which a line goes on, and the last that saw it."""
    return named.change.since, float(fleet.day[affected_campaigns(fleet, named)].max())


def affected_campaigns(fleet: Fleet, named: RealChange) -> BoolArray:
    """Return which campaigns a change concerns.

    Parameters
    ----------
    fleet : Fleet
    named : RealChange

    Returns
    -------
    ndarray of bool, shape (C,)
    """
    change = named.change
    if change.scope == "robot":
        return np.asarray(fleet.robot == fleet.robots.index(change.of))
    if change.scope == "instrument":
        return np.asarray(fleet.instrument == fleet.instruments.index(change.of))
    return np.ones(len(fleet.day), dtype=bool)


Why = Literal["passes", "changed", "unlike", "longest_ago"]
_ORDER: Final[dict[Why, int]] = {"passes": 0, "changed": 1, "unlike": 2, "longest_ago": 3}


@dataclass(frozen=True, slots=True)
class Priority:
    """A robot, and what speaks for measuring it."""

    robot: str
    why: Why
    last_day: float  # on which it was measured
    named: RealChange | None = None
    passing: LimitCrossing | None = None  # of a line; a step that is beyond the limit has none
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


def due(account: Account, limit_mm: float) -> tuple[Priority, ...]:
    """Return every robot once, the one to be measured next first.

    Parameters
    ----------
    account : Account
    limit_mm : float
        Size of a change (root mean square at the measured configurations) that is not to be passed.

    Returns
    -------
    tuple of Priority
        One a robot.
    """
    return tuple(sorted((_of(account, robot, limit_mm) for robot in account.fleet.robots), key=_urgency))


def _urgency(one: Priority) -> tuple[int, float]:
    return one.urgency


def _of(account: Account, robot: str, limit_mm: float) -> Priority:
    fleet = account.fleet
    last = float(fleet.day[fleet.robot == fleet.robots.index(robot)].max())
    own = [one for one in account.named if one.change.of == robot and _stays(one)]
    each = (_of_change(fleet, one, last, limit_mm) for one in own)
    left_out = max((one.day for one in account.unlike if one.robot == robot), default=last)
    # A campaign that was left out counts only where none of this robot came after it.
    without = Priority(robot, "unlike", left_out) if left_out > last else Priority(robot, "longest_ago", last)
    return min(each, key=_urgency, default=without)


def _stays(named: RealChange) -> bool:
    """Return whether a robot has changed to this day: what was so on one day only is over."""
    return named.change.scope == "robot" and named.change.kind != "day"


def _of_change(fleet: Fleet, named: RealChange, last: float, limit_mm: float) -> Priority:
    found = passing(fleet, named, limit_mm)
    instrument = _telling(fleet, named)
    if found is not None and math.isfinite(found.earliest):
        return Priority(named.change.of, "passes", last, named, found, instrument)
    # A step does not go on, but one that is beyond the limit has passed it.
    beyond = named.size_mm >= limit_mm
    return Priority(named.change.of, "passes" if beyond else "changed", last, named, None, instrument)


def _telling(fleet: Fleet, named: RealChange) -> str:
    """Return an instrument that is none of the rivals, where one is among them."""
    # Measured again by an instrument that may itself have changed, a robot is doubted as before.
    doubtful = {one.change.of for one in named.rivals if one.change.scope == "instrument"}
    if not doubtful:
        return ""
    return next((name for name in fleet.instruments if name not in doubtful), "")
