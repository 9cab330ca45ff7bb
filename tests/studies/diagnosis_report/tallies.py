"""Shares and counts of many outcomes."""

from collections import Counter
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from tests.studies.diagnosis_report.judging import Outcome

_HALF_WIDTH_95 = 1.96  # of a normal deviate


def share(hits: Iterable[float]) -> float:
    """Return the mean of ones and zeros, NaN of none."""
    values = [float(hit) for hit in hits]
    return float(np.mean(values)) if values else float("nan")


def detected(outcomes: Sequence[Outcome]) -> float:
    """Return which share says that something is there."""
    return share(outcome.detected for outcome in outcomes)


def named(outcomes: Sequence[Outcome]) -> float:
    """Return which share of what was planted is named, among the detected; a listed confusable is half."""
    return share(one.credit for outcome in outcomes if outcome.detected for one in outcome.named)


def all_named(outcomes: Sequence[Outcome]) -> float:
    """Return which share names everything that was planted."""
    return share(outcome.all_named for outcome in outcomes)


def no_third(outcomes: Sequence[Outcome]) -> float:
    """Return which share names nothing that was not planted."""
    return share(not outcome.wrong for outcome in outcomes)


def doubted(outcomes: Sequence[Outcome]) -> float:
    """Return which share of the rightly named is given a rival or said to leave structure."""
    return share(outcome.doubted for outcome in outcomes if outcome.detected and outcome.all_named)


def wrong_and_sure(outcomes: Sequence[Outcome]) -> float:
    """Return which share of the detected gives a wrong name and neither a rival nor a flag."""
    return share(bool(one.wrong) and not one.doubted for one in outcomes if one.detected)


def orders_found(outcomes: Sequence[Outcome]) -> float:
    """Return which share of the named waves has its order."""
    each = (one.order_found for outcome in outcomes for one in outcome.named)
    return share(found for found in each if found is not None)


def inside_interval(outcomes: Sequence[Outcome]) -> float:
    """Return which share of the amplitudes lies within their stated 95 % interval."""
    scores = (score for outcome in outcomes for one in outcome.named for score in one.scores)
    return share(abs(score) < _HALF_WIDTH_95 for score in scores)


def ratio_after_before(outcomes: Sequence[Outcome]) -> float:
    """Return the mean ratio of held-out mean errors, after the extension over before."""
    ratios = [one.mean_after_mm / one.mean_before_mm for one in outcomes if not one.fault]
    return float(np.mean(ratios)) if ratios else float("nan")


def wrong_names(outcomes: Sequence[Outcome]) -> str:
    """Return the wrong names and how often each was given, most frequent first."""
    return _counted(name for outcome in outcomes for name in outcome.wrong)


def all_names(outcomes: Sequence[Outcome]) -> str:
    """Return all names and how often each was given, most frequent first."""
    return _counted(name for outcome in outcomes for name in outcome.found)


def _counted(names: Iterable[str]) -> str:
    return ", ".join(f"{name} x {times}" for name, times in Counter(names).most_common())


def faults(outcomes: Sequence[Outcome]) -> list[str]:
    """Return one sentence for every diagnosis that ended with an error."""
    return [
        f"{one.label}, {one.readings} readings, seed {one.seed}: {one.fault}" for one in outcomes if one.fault
    ]


def by_size(outcomes: Sequence[Outcome]) -> dict[int, list[Outcome]]:
    """Return the outcomes by the number of readings, ascending."""
    sizes = sorted({outcome.readings for outcome in outcomes})
    return {size: [one for one in outcomes if one.readings == size] for size in sizes}


def by_label(outcomes: Sequence[Outcome]) -> dict[str, list[Outcome]]:
    """Return the outcomes by what was planted, in their order."""
    labels = dict.fromkeys(outcome.label for outcome in outcomes)
    return {label: [one for one in outcomes if one.label == label] for label in labels}


def percent_by_size(outcomes: Sequence[Outcome], tally: Callable[[Sequence[Outcome]], float]) -> str:
    """Return a share in per cent at every size, such as `83 / 100 / 100 %`."""
    shares = (tally(rows) for rows in by_size(outcomes).values())
    return " / ".join(f"{100.0 * one:.0f}" if np.isfinite(one) else "-" for one in shares) + " %"
