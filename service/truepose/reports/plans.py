"""A plan with its promise, in sentences and as a table."""

from collections.abc import Iterator
from typing import Final

from truepose.domain.identification import NotIdentifiable
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, message
from truepose.messages.units import ConvertibleNumber, length_form
from truepose.planning.prediction.errors import STEP, gains_mm
from truepose.planning.prediction.plan import PromisedPlan
from truepose.reports.rounding import format_fixed, millimetres
from truepose.reports.tables import Table, heads_of

_MOST_SAID: Final = 3  # combinations that are left open; a plan of a few configurations leaves dozens
_MOST_NAMED: Final = 8  # parameters of one of them; documents have all
# Readings and keep-out volumes, by whether lengths of a ballbar, and contacts of a closed loop, are read.
_KEYS: Final = {
    (False, False): ("plans.readings", "plans.kept_out"),
    (True, False): ("plans.lengths", "plans.kept_out.poses"),
    (False, True): ("plans.contacts", "plans.kept_out.loops"),
}
_HEADS: Final = (
    "plans.head.n",
    "plans.head.mean",
    "plans.head.interval",
    "plans.head.worst",
    "plans.head.gain",
)


def plan_sentences(plan: PromisedPlan, minutes: float) -> Iterator[Message]:
    """Yield what a plan promises, what more would bring, what it leaves open, what it rests on."""
    yield promise_sentence(plan)
    if plan.measured:
        yield message("plans.measured", measured=plan.measured, new=len(plan.joints_rad))
    yield from _worth_of_more(plan)
    yield from _left_open(plan)
    if len(plan.joints_rad):
        yield message("plans.minutes", minutes=minutes)
    yield from _assumptions(plan)


def promise_sentence(plan: PromisedPlan) -> Message:
    """Return what a plan promises."""
    promised = plan.promised
    low, high = promised.interval_90_mm
    return message(
        "plans.promise",
        n=promised.n,
        mean_mm=promised.mean_mm,
        low_mm=low,
        high_mm=high,
        worst_mm=promised.worst_mm,
        visit_mm=promised.visit_mean_mm,
    )


def _worth_of_more(plan: PromisedPlan) -> Iterator[Message]:
    after = next((point for point in plan.curve if point.n >= plan.total + STEP), None)
    if after is None:
        yield message("plans.all", n=plan.curve[-1].n)
        return
    gain_um = 1e3 * (plan.promised.mean_mm - after.mean_mm) * STEP / (after.n - plan.total)
    if plan.total >= plan.advised:
        enough = plan.measured == plan.total
        yield message("plans.enough" if enough else "plans.knee", n=plan.advised, gain_um=gain_um)
    else:
        yield message("plans.more", n=plan.advised, gain_um=gain_um)


def _left_open(plan: PromisedPlan) -> Iterator[Message]:
    for group in plan.left_open[:_MOST_SAID]:
        yield _open(group)
    more = len(plan.left_open) - _MOST_SAID
    if more > 0:
        yield message("plans.open.more", more=more)


def _open(group: NotIdentifiable) -> Message:
    first, more = ", ".join(group.parameters[:_MOST_NAMED]), len(group.parameters) - _MOST_NAMED
    if more > 0:
        return message("plans.open.many", parameters=first, more=more, reason=group.reason)
    return message("plans.open", parameters=first, reason=group.reason)


def _assumptions(plan: PromisedPlan) -> Iterator[Message]:
    assumed = plan.assumptions
    key, kept_out = _KEYS[plan.poses is not None, plan.targets is not None]
    yield message(key, reading_um=1e3 * assumed.reading_mm, repeatability_um=1e3 * assumed.repeatability_mm)
    if assumed.kept_out:
        yield message(kept_out, volumes=", ".join(assumed.kept_out))
    lack = assumed.discrepancy
    if lack.per_axis_mm > 0.0:
        yield message("plans.discrepancy", discrepancy_mm=lack.per_axis_mm, percent=100.0 * lack.known_to)
    else:
        yield message("plans.complete")


def curve_table(plan: PromisedPlan, words: Catalogue) -> Table:
    """Return the curve, one row for each number of configurations; a star marks the one planned."""
    gained = ("", *(format_fixed(1e3 * gain, 1, "um") for gain in gains_mm(plan.curve)))
    rows = [
        (
            f"{'*' if point.n == plan.total else ''}{point.n}",
            millimetres(point.mean_mm),
            _between(*point.interval_90_mm),
            millimetres(point.worst_mm),
            gain,
        )
        for point, gain in zip(plan.curve, gained, strict=True)
    ]
    return Table(heads_of(words, *_HEADS), rows)


def _between(low_mm: float, high_mm: float) -> str:
    ends = [(end, length_form(end)) for end in (low_mm, high_mm)]
    return ConvertibleNumber(lambda shown: " - ".join(shown.formatted(*end) for end in ends), "mm")
