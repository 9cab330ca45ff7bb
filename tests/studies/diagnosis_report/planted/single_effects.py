"""One effect at a time: found, named, its amplitude; and named wrongly when the library does not hold it."""

from collections.abc import Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import Final

import numpy as np

from tests.studies.diagnosis_report import tallies
from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.diagnosis_report.planted.cases import BARELY_VISIBLE, FOR_INFORMATION, REALISTIC
from tests.studies.diagnosis_report.rows import at_least, at_most, between, no_faults
from tests.studies.diagnosis_report.study import Extent, Rows, Study, each_case, trial_of
from tests.studies.diagnosis_report.trials import Trial
from tests.studies.report_command import informing
from truepose.reports.table_report import Row

_DETECTED: Final = MappingProxyType({50: 0.80, 100: 0.97, 200: 0.99})
_FACTORS: Final = (0.5, 2.0)


def power(extent: Extent) -> Study:
    """Realistic amplitudes at every size."""
    cases = (*REALISTIC, *FOR_INFORMATION)
    trials = [
        trial_of((case,), size, seed)
        for row, case in enumerate(cases)
        for size in extent.sizes
        for seed in extent.seeds(extent.campaigns, row)
    ]
    return Study(
        key="power",
        title=f"Realistic amplitudes, {extent.campaigns} campaigns a cell",
        trials=tuple(trials),
        rows=_power_rows,
    )


def _power_rows(outcomes: Sequence[Outcome]) -> Rows:
    judged = [one for one in outcomes if one.label in {case.label for case in REALISTIC}]
    sizes = tallies.by_size(judged)
    return (
        *(
            at_least(f"detected at {size} readings", _DETECTED[size], rows, tallies.detected)
            for size, rows in sizes.items()
            if size in _DETECTED
        ),
        at_least("named correctly among detected", 0.95, judged, tallies.named),
        at_most("named rightly, yet given a rival or a flag", 0.10, judged, tallies.doubted),
        between("amplitudes within their stated 95 % interval", 0.90, 0.98, judged, tallies.inside_interval),
        informing("named waves whose order is right", tallies.percent_by_size(judged, tallies.orders_found)),
        informing("time of one diagnosis, one core", _times(judged)),
        no_faults(outcomes),
        *each_case(outcomes),
    )


def amplitudes(extent: Extent) -> Study:
    """Half and twice the realistic amplitudes."""
    trials = [
        replace(trial_of((case,), size, seed, factor), label=f"{case.label}, times {factor:g}")
        for row, case in enumerate(REALISTIC)
        for factor in _FACTORS
        for size in extent.sizes
        for seed in extent.seeds(max(extent.campaigns // 3, 1), row)
    ]
    return Study(
        key="amplitudes",
        title="Half and twice the realistic amplitudes",
        trials=tuple(trials),
        rows=lambda outcomes: (
            informing("named correctly among detected", tallies.percent_by_size(outcomes, tallies.named)),
            informing(
                "amplitudes within their stated 95 % interval",
                tallies.percent_by_size(outcomes, tallies.inside_interval),
            ),
            no_faults(outcomes),
            *each_case(outcomes),
        ),
    )


def left_out(extent: Extent) -> Study:
    """Each effect taken out of the library in turn."""
    trials = [
        _without_itself(trial_of((case,), size, seed))
        for row, case in enumerate(REALISTIC)
        for size in _middle(extent.sizes)
        for seed in extent.seeds(max(extent.campaigns // 2, 1), row)
    ]
    return Study(
        key="left-out",
        title="Effects that the library does not hold",
        trials=tuple(trials),
        rows=lambda outcomes: (
            at_most("wrong name, neither a rival nor a flag", 0.10, outcomes, tallies.wrong_and_sure),
            informing("detected", tallies.percent_by_size(outcomes, tallies.detected)),
            no_faults(outcomes),
            *(_left_out_row(label, rows) for label, rows in tallies.by_label(outcomes).items()),
        ),
    )


def _without_itself(trial: Trial) -> Trial:
    return replace(trial, without=tuple({effect.effect for effect in trial.planted}))


def _left_out_row(label: str, outcomes: Sequence[Outcome]) -> Row:
    found = tallies.percent_by_size(outcomes, tallies.detected)
    sure = tallies.percent_by_size(outcomes, tallies.wrong_and_sure)
    names = tallies.wrong_names(outcomes)
    return informing(label, f"detected {found}; wrong and sure {sure}{'; ' if names else ''}{names}")


def barely_visible(extent: Extent) -> Study:
    """Effects that hardly show."""
    trials = [
        trial_of((case,), size, seed)
        for row, case in enumerate(BARELY_VISIBLE)
        for size in _middle(extent.sizes)
        for seed in extent.seeds(max(extent.campaigns // 2, 1), row)
    ]
    return Study(
        key="barely-visible",
        title="Effects that the fit of geometry and springs absorbs nearly whole",
        trials=tuple(trials),
        rows=lambda outcomes: (*each_case(outcomes), no_faults(outcomes)),
    )


def _middle(sizes: tuple[int, ...]) -> tuple[int, ...]:
    return (sizes[len(sizes) // 2],)


def _times(outcomes: Sequence[Outcome]) -> str:
    medians = (float(np.median([one.wall_s for one in rows])) for rows in tallies.by_size(outcomes).values())
    return " / ".join(f"{median:.1f}" for median in medians) + " s"
