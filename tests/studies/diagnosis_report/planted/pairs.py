"""Two effects at once: both named, and no third."""

from collections.abc import Sequence
from types import MappingProxyType
from typing import Final

from tests.studies.diagnosis_report import tallies
from tests.studies.diagnosis_report.judging import Outcome
from tests.studies.diagnosis_report.planted.cases import REALISTIC, pairs_alike, pairs_of
from tests.studies.diagnosis_report.rows import at_least, no_faults
from tests.studies.diagnosis_report.study import Extent, Rows, Study, trial_of
from tests.studies.report_command import informing

_NO_THIRD: Final = MappingProxyType({100: 0.85, 200: 0.92})


def pairs(extent: Extent) -> Study:
    """Pairs of effects that can be told apart; those that cannot are listed apart."""
    every = pairs_of(REALISTIC)
    # Spread over the list, so that few of them still meet every effect.
    chosen = [every[(k * len(every)) // extent.pairs % len(every)] for k in range(extent.pairs)]
    apart = pairs_alike(REALISTIC)
    trials = [
        trial_of(pair, size, extent.first_seed + number)
        for number, pair in enumerate((*chosen, *apart))
        for size in extent.sizes
        if size in _NO_THIRD
    ]
    alike = {" and ".join(case.label for case in pair) for pair in apart}
    return Study(
        key="pairs",
        title=f"Pairs of effects, {extent.pairs} of {len(every)}",
        trials=tuple(trials),
        rows=lambda outcomes: _pair_rows(outcomes, alike),
    )


def _pair_rows(outcomes: Sequence[Outcome], alike: set[str]) -> Rows:
    judged = [one for one in outcomes if one.label not in alike]
    missed = [one for one in judged if not one.all_named]
    return (
        at_least("both named", 0.93, judged, tallies.all_named),
        *(
            at_least(f"no third at {size} readings", _NO_THIRD[size], rows, tallies.no_third)
            for size, rows in tallies.by_size(judged).items()
        ),
        no_faults(outcomes),
        *(
            informing(f"{one.label} ({one.readings})", f"named {', '.join(one.found) or 'nothing'}")
            for one in [*missed, *(one for one in outcomes if one.label in alike)]
        ),
    )
