"""What is said of a fleet whose days are those of the calendar (`date.toordinal`): keys and values, no text.

Nothing is computed here but the least changes that would have shown; whoever renders a message has its
language.
"""

import math
from collections.abc import Iterator, Sequence
from datetime import date
from typing import Final

import numpy as np

from truepose.fleet.campaigns import Fleet
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import Account, RealChange
from truepose.fleet.interim_check import CauseGrowth
from truepose.fleet.minimum_detectable_change import least_of_instruments, least_of_robots
from truepose.fleet.predicted_accuracy import MOST, PredictedAccuracy
from truepose.fleet.trend import LimitCrossing, Priority, affected_campaigns
from truepose.fleet.trials import Change, Kind
from truepose.messages.message import Message, Text, message, together

_KINDS: Final[dict[Kind, str]] = {
    "linear": "fleet.as.linear",
    "step": "fleet.as.step",
    "day": "fleet.as.day",
}
_LAST: Final = float(date.max.toordinal())


def day_of(day: float) -> str | None:
    """Return a day of a fleet as the calendar has it, as in "2026-11-29"; None: not in its reach."""
    # A line that hardly rises passes its limit after the calendar ends.
    return date.fromordinal(int(day)).isoformat() if 1.0 <= day <= _LAST else None


def what(change: Change) -> Text:
    """Return what changed: a robot, an instrument, or the type."""
    return change.of or message("fleet.the_type")


def cause_said(cause: AgeingCause) -> Message:
    """Return a cause in words."""
    if cause.order:
        return message("fleet.wave", effect=cause.effect, subject=cause.subject, order=cause.order)
    return message("fleet.cause", effect=cause.effect, subject=cause.subject)


def headline(account: Account) -> Message:
    """Return how many changes there are; where there is none, how much was tried."""
    if account.named:
        return message("fleet.changes", n=len(account.named))
    return message("fleet.nothing", tried=account.tried)


def comparison_sentence(account: Account) -> Message:
    """Return of what a fleet is."""
    fleet = account.fleet
    return message(
        "fleet.compared",
        robots=len(fleet.robots),
        instruments=len(fleet.instruments),
        campaigns=len(fleet.day),
        first=day_of(float(fleet.day.min())) or "",
        last=day_of(float(fleet.day.max())) or "",
    )


def change_said(change: Change) -> Message:
    """Return what changes, its cause, and since when."""
    since = day_of(change.since) or ""
    return message(_KINDS[change.kind], who=what(change), cause=cause_said(change.cause), since=since)


def change_sentences(account: Account, named: RealChange, passes: LimitCrossing | None) -> Iterator[Message]:
    """Yield a change with its size, what else it may be, and when it passes the limit."""
    days = account.fleet.day[affected_campaigns(account.fleet, named)]
    yield message(
        "fleet.size",
        change=change_said(named.change),
        size_mm=named.size_mm,
        u_mm=named.size_u_mm,
        last=day_of(float(days.max())) or "",
    )
    yield from rivals_said(named)
    if not named.rivals:
        yield message("fleet.no_rival")
    if named.change.scope == "type" and named.change.kind == "day":
        yield message("fleet.on_one_day")
    elif named.change.kind == "step":
        yield message("fleet.no_forecast")
    elif passes is not None:
        yield passing_said(passes, float(days.max()))
    if named.change.scope == "instrument":
        yield message("fleet.check_instrument", instrument=named.change.of)


def rivals_said(named: RealChange) -> Iterator[Message]:
    """Yield what else explains a change as well, where anything does."""
    if named.rivals:
        rivals = tuple(change_said(one.change) for one in named.rivals)
        yield message("fleet.rivals", change=change_said(named.change), rivals=rivals)


def passing_said(passes: LimitCrossing, last: float) -> Message:
    """Return when a limit is passed, with its 5 and 95 %."""
    day, earliest, latest = (day_of(one) for one in (passes.day, passes.earliest, passes.latest))
    if earliest is None:
        return message("fleet.passes.never", limit_mm=passes.limit_mm)
    if day is None or latest is None:
        return message("fleet.passes.perhaps", limit_mm=passes.limit_mm, earliest=earliest)
    key = "fleet.passes" if passes.day > last else "fleet.passed"
    return message(key, limit_mm=passes.limit_mm, day=day, earliest=earliest, latest=latest)


def next_said(first: Priority, limit_mm: float) -> Message:
    """Return which robot is to be measured next, and why."""
    return message("fleet.next", robot=first.robot, why=why_said(first, limit_mm))


def why_said(one: Priority, limit_mm: float) -> Text:
    """Return what speaks for measuring a robot, and by what."""
    by = message("fleet.next.by", instrument=one.instrument) if one.instrument else ""
    return together(_why(one, limit_mm), by)


def _why(one: Priority, limit_mm: float) -> Message:
    if one.named is None:
        key = "fleet.next.unlike" if one.why == "unlike" else "fleet.next.longest"
        return message(key, last=day_of(one.last_day) or "")
    cause = cause_said(one.named.change.cause)
    if one.passing is not None:
        return _passing_of(one, cause, one.passing)
    since = day_of(one.named.change.since) or ""
    if one.why == "changed":
        return message("fleet.next.changed", cause=cause, since=since)
    return message("fleet.next.beyond", cause=cause, since=since, limit_mm=limit_mm)


def _passing_of(one: Priority, cause: Message, passes: LimitCrossing) -> Message:
    day, earliest, limit_mm = day_of(passes.day), day_of(passes.earliest), passes.limit_mm
    if day is None or earliest is None:
        return message("fleet.next.someday", cause=cause, limit_mm=limit_mm)
    if passes.day <= one.last_day:
        return message("fleet.next.passed", cause=cause, limit_mm=limit_mm, day=day)
    return message("fleet.next.passes", cause=cause, limit_mm=limit_mm, day=day, earliest=earliest)


def scatter_said(account: Account) -> Iterator[Message]:
    """Yield by how much campaigns scatter more than their readings say, where they do."""
    if account.birge_ratio > 1.0:
        yield message("fleet.scatter", times=math.sqrt(account.birge_ratio))


def least_said(account: Account) -> Iterator[Message]:
    """Yield from which sizes on changes would have shown: what "nothing changes" leaves room for."""
    robots = least_of_robots(account)
    sizes: dict[str, float] = {}
    for one in robots:
        shown = one.size_mm[np.isfinite(one.size_mm)]
        sizes[one.cause.effect] = max(sizes.get(one.cause.effect, 0.0), *shown.tolist(), 0.0)
    kinds = tuple(
        message("fleet.least.kind", effect=effect, size_mm=size) for effect, size in sizes.items() if size
    )
    if kinds:
        yield message("fleet.least", kinds=kinds)
    hidden = tuple(cause_said(one.cause) for one in robots if np.isinf(one.size_mm).any())
    if hidden:
        yield message("fleet.least.hidden", causes=hidden)
    yield from _least_drifts(account)


def _least_drifts(account: Account) -> Iterator[Message]:
    found = least_of_instruments(account)
    for name, size_mm, days in zip(found.of, found.size_mm.tolist(), found.days.tolist(), strict=True):
        if math.isinf(size_mm):
            yield message("fleet.least.no_drift", instrument=name)
        else:
            um_per_m = drift_um_per_m(account.fleet, size_mm)
            yield message("fleet.least.drift", instrument=name, um_per_m=um_per_m, days=days, size_mm=size_mm)


def drift_um_per_m(fleet: Fleet, size_mm: float) -> float:
    """Return by how much of all lengths an instrument drifts that moves what it measures by a size.

    Parameters
    ----------
    fleet : Fleet
        Of which some campaign shows a scale.
    size_mm : float
        Root mean square at the measured configurations.

    Returns
    -------
    float
        [um/m].
    """
    return 1e6 * fleet.scale_width * size_mm / math.sqrt(fleet.motion_mm2[-1, -1])


def new_robot_said(found: PredictedAccuracy) -> Message:
    """Return what a further robot of the type needs with what its type says, and without it."""
    low_mm, high_mm = found.pooled.interval_90_mm
    figures = {"readings": found.pooled.n, "mean_mm": found.pooled.mean_mm, "same_mm": found.same_mm}
    if not found.is_worth:
        return message("fleet.new.nothing", **figures)
    usual = {"without": found.alone.n, "alone_mm": found.alone.mean_mm}
    figures |= {"low_mm": low_mm, "high_mm": high_mm, **usual}
    if found.needed is None:
        return message("fleet.new.more", most=MOST, **figures)
    return message("fleet.new", needed=found.needed, **figures)


def grown_said(robot: str, found: Sequence[CauseGrowth]) -> Iterator[Message]:
    """Yield what a check of a robot says: what has grown, and what it would have told."""
    told = [one for one in found if one.is_told]
    for one in told:
        cause = cause_said(one.cause)
        yield message("fleet.checked.grown", robot=robot, cause=cause, size_mm=one.size_mm, u_mm=one.u_mm)
    if not told:
        yield message("fleet.checked.nothing", robot=robot)
    least_mm = max(one.least_mm for one in found)
    if math.isinf(least_mm):
        yield message("fleet.checked.blind", causes=len(found))
    else:
        yield message("fleet.checked.least", causes=len(found), least_mm=least_mm)
