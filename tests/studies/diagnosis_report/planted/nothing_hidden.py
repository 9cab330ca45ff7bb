"""Robots in which nothing was hidden: one without any further effect, and one with all small ones at once."""

from collections.abc import Sequence
from types import MappingProxyType
from typing import Final

from tests.studies.diagnosis_report import tallies
from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.diagnosis_report.rows import at_most, no_faults, ratio_at_most
from tests.studies.diagnosis_report.study import Extent, Study
from tests.studies.diagnosis_report.trials import Trial
from tests.studies.report_command import informing

_AFTER_BEFORE: Final = MappingProxyType({100: 0.52, 200: 0.43})
_FALSE_ALARMS: Final = 12 / 600
_FALSE_ALARMS_HEAVY: Final = 24 / 600


def false_alarms(extent: Extent, *, heavy_tails: bool) -> Study:
    """Campaigns of a robot whose model holds everything."""
    noise = "Student's noise of 4 degrees of freedom" if heavy_tails else "normal noise"
    limit = _FALSE_ALARMS_HEAVY if heavy_tails else _FALSE_ALARMS
    trials = [
        Trial(f"no effect, {noise}", (), size, seed, heavy_tails=heavy_tails)
        for size in extent.sizes
        for seed in extent.seeds(extent.undisturbed)
    ]
    return Study(
        key="false-alarms-heavy" if heavy_tails else "false-alarms",
        title=f"No effect, {noise}: {extent.undisturbed} campaigns of each size",
        trials=tuple(trials),
        rows=lambda outcomes: (
            at_most("false alarms", limit, outcomes, tallies.detected),
            informing("by size", tallies.percent_by_size(outcomes, tallies.detected)),
            no_faults(outcomes),
        ),
    )


def everyday(extent: Extent) -> Study:
    """How much of an everyday robot's error the extended model takes away."""
    trials = [
        Trial("everyday robot", (), size, seed, scenario="irb120-everyday", over_time=False)
        for size in extent.sizes
        if size in _AFTER_BEFORE
        for seed in extent.seeds(extent.campaigns)
    ]
    return Study(
        key="everyday",
        title="The everyday robot: many small effects at once, from the default start",
        trials=tuple(trials),
        rows=lambda outcomes: (
            *(
                ratio_at_most(
                    f"held-out mean error after / before, {size} readings",
                    _AFTER_BEFORE[size],
                    rows,
                    tallies.ratio_after_before,
                )
                for size, rows in tallies.by_size(outcomes).items()
            ),
            informing("worst campaign", _worst(outcomes)),
            no_faults(outcomes),
        ),
        note=lambda outcomes: f"Named: {tallies.all_names(outcomes)}.",
    )


def _worst(outcomes: Sequence[Outcome]) -> str:
    ratios = [one.mean_after_mm / one.mean_before_mm for one in outcomes if not one.fault]
    return f"{max(ratios):.3f}" if ratios else "no campaign"
