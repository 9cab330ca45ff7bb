"""Closed loops on simulated arms: how accurate each makes them, what it promises, what it leaves open.

`python -m tests.studies.loops --out out/loops` records each loop, and a tracker beside them, in cells of
`lrmate-tilted`, calibrates, and holds each model against where the tool truly was. It takes some two minutes.
"""

import argparse
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.loops.held_out import HeldOut, errors_of, promise_ratio
from tests.studies.loops.planned import attained, planned
from tests.studies.loops.recorded import TRACKER, calibrated
from tests.studies.report_command import informing, report, target_row
from tests.studies.running import study_parser
from truepose.domain.identification import NotIdentifiable
from truepose.messages.catalogue import english
from truepose.reports.table_report import Row, Section, Verdict
from truepose_simulators.recording.closed_loops import LOOPS

_ALL: Final = (*LOOPS, TRACKER)
_KEPT: Final = (0.8, 1.2)  # of the promise, over all arms
_HELD_BY_PRIORS: Final = frozenset({"plane"})  # what it promises is what the priors let any arm be
_BY_CONSTRUCTION: Final = frozenset({
    "open.base_of_targets",
    "open.parallel_axes",
    "open.spring_upright",
    "open.row_1",
})


def main() -> int:
    """Measure everything, print it, write it; status 1 where a promise is not kept."""
    parser = study_parser(__doc__, out=Path("out/loops"), scenario="lrmate-tilted", seeds=20, stops=100)
    parser.add_argument("--loops", nargs="+", choices=_ALL, default=[*_ALL])
    parser.add_argument("--planned", nargs="*", default=["two-spheres", "tilted-plane", "gauges", "wires"])
    options = parser.parse_args()
    return report(_sections(options), options.out / "loops.html", "Closed loops")


def _sections(options: argparse.Namespace) -> Iterator[Section]:
    for kind in options.loops:
        arms = [
            calibrated(options.scenario, seed, kind, options.stops) for seed in range(1, options.seeds + 1)
        ]
        yield Section(
            f"{kind}: {options.seeds} arms of {options.scenario}, {options.stops} stops",
            (*_figures(arms, kind), *_left_open(arms)),
        )
    for kind in options.planned:
        yield _kept(options.scenario, kind, options.seeds)


def _kept(scenario: str, kind: str, seeds: int) -> Section:
    """Return whether the knee of a plan is what arms attain."""
    plan = planned(scenario, kind, None)
    arms = [attained(scenario, seed, kind, plan) for seed in range(1, seeds + 1)]
    mean, promised = float(np.mean([arm.mean_mm for arm in arms])), plan.promised.mean_mm
    rows = (
        Row("mean error", f"{promised:.4f} mm promised", f"{mean:.4f} mm", Verdict.NO_TARGET),
        _promise_kept(mean / promised),
    )
    return Section(f"{kind} as planned: {len(plan.joints_rad)} stops, {seeds} arms", rows)


def _promise_kept(ratio: float) -> Row:
    low, high = _KEPT
    return target_row("error / promise", f"{low:g} to {high:g}", f"{ratio:.2f}", good=low <= ratio <= high)


def _figures(arms: list[HeldOut], kind: str) -> Iterator[Row]:
    yield from errors_of(arms)
    ratio = promise_ratio(arms)
    held = kind in _HELD_BY_PRIORS
    yield informing("error / promise", f"{ratio:.2f}") if held else _promise_kept(ratio)


def _left_open(arms: list[HeldOut]) -> Iterator[Row]:
    """Yield what most arms leave open besides what no closed loop sees."""
    named = Counter(_said(entry) for arm in arms for entry in _own(arm))
    for sentence, times in named.most_common(6):
        yield informing("left open", f"{times} of {len(arms)}: {sentence}")


def _own(arm: HeldOut) -> Iterator[NotIdentifiable]:
    yield from (entry for entry in arm.answer.not_identifiable if entry.reason.key not in _BY_CONSTRUCTION)


def _said(entry: NotIdentifiable) -> str:
    return f"{', '.join(entry.parameters)} ({english(entry.reason)})"


if __name__ == "__main__":
    sys.exit(main())
