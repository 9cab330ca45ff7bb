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

from tests.studies.loops.held_out import HeldOut
from tests.studies.loops.planned import attained, planned
from tests.studies.loops.recorded import TRACKER, calibrated
from tests.studies.report_command import shown, status_of
from truepose.domain.identification import NotIdentifiable
from truepose.messages.catalogue import english
from truepose.reports.table_report import Row, Section, Verdict, write_table_report
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
    options = _options()
    sections = shown(_sections(options))
    options.out.mkdir(parents=True, exist_ok=True)
    write_table_report(options.out / "loops.html", "Closed loops", sections, simulated=True)
    return status_of(sections)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/loops"))
    parser.add_argument("--scenario", default="lrmate-tilted")
    parser.add_argument("--seeds", type=int, default=20)
    parser.add_argument("--stops", type=int, default=100)
    parser.add_argument("--loops", nargs="+", choices=_ALL, default=[*_ALL])
    parser.add_argument("--planned", nargs="*", default=["two-spheres", "tilted-plane", "gauges", "wires"])
    return parser.parse_args()


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
    low, high = _KEPT
    verdict = Verdict.PASSED if low <= mean / promised <= high else Verdict.FAILED
    rows = (
        Row("mean error", f"{promised:.4f} mm promised", f"{mean:.4f} mm", Verdict.NO_TARGET),
        Row("error / promise", f"{low:g} to {high:g}", f"{mean / promised:.2f}", verdict),
    )
    return Section(f"{kind} as planned: {len(plan.joints_rad)} stops, {seeds} arms", rows)


def _figures(arms: list[HeldOut], kind: str) -> Iterator[Row]:
    nominal, mean, promised = (
        float(np.mean([getattr(arm, name) for arm in arms]))
        for name in ("nominal_mm", "mean_mm", "promised_mm")
    )
    worst, ratio = max(arm.worst_mm for arm in arms), mean / promised
    yield Row("nominal arm, mean error", "", f"{nominal:.3f} mm", Verdict.NO_TARGET)
    yield Row("calibrated, mean error", "", f"{mean:.4f} mm", Verdict.NO_TARGET)
    yield Row("calibrated, worst of all arms", "", f"{worst:.3f} mm", Verdict.NO_TARGET)
    yield Row("promised, mean error", "", f"{promised:.4f} mm", Verdict.NO_TARGET)
    low, high = _KEPT
    if kind in _HELD_BY_PRIORS:
        yield Row("error / promise", "", f"{ratio:.2f}", Verdict.NO_TARGET)
        return
    verdict = Verdict.PASSED if low <= ratio <= high else Verdict.FAILED
    yield Row("error / promise", f"{low:g} to {high:g}", f"{ratio:.2f}", verdict)


def _left_open(arms: list[HeldOut]) -> Iterator[Row]:
    """Yield what most arms leave open besides what no closed loop sees."""
    named = Counter(_said(entry) for arm in arms for entry in _own(arm))
    for sentence, times in named.most_common(6):
        yield Row("left open", "", f"{times} of {len(arms)}: {sentence}", Verdict.NO_TARGET)


def _own(arm: HeldOut) -> Iterator[NotIdentifiable]:
    yield from (entry for entry in arm.answer.not_identifiable if entry.reason.key not in _BY_CONSTRUCTION)


def _said(entry: NotIdentifiable) -> str:
    return f"{', '.join(entry.parameters)} ({english(entry.reason)})"


if __name__ == "__main__":
    sys.exit(main())
