"""Closed loops on simulated arms: how accurate each makes them, what it promises, what it leaves open.

`python -m tests.studies.loops --out out/loops` records each loop, and a tracker beside them, in cells of
`lrmate-tilted`, calibrates, and holds each model against where the tool truly was. It takes some two minutes.
"""

import argparse
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.loops.held_out import HeldOut, Truth, held_out
from tests.studies.report_command import shown, status_of
from truepose.domain.campaign import Stops
from truepose.domain.results import NotIdentifiable
from truepose.exchange.campaigns.folder import read_campaign
from truepose.reports.table_report import Row, Section, Verdict, write_table_report
from truepose.words.catalogue import english
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import Stops as RecordedStops
from truepose_simulators.recording import Wishes, record, write_campaign
from truepose_simulators.recording.loops.campaign import LoopWishes, record_loop
from truepose_simulators.recording.loops.files import write_loop
from truepose_simulators.recording.loops.loops import LOOPS
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import Scenario

_TRACKER: Final = "tracker"  # as many points of it, to compare with
_ALL: Final = (*LOOPS, _TRACKER)
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


def calibrated(scenario: str, seed: int, kind: str, stops: int) -> HeldOut:
    """Record a loop, or a tracker, calibrate by it, and hold the model against the truth."""
    with tempfile.TemporaryDirectory() as name:
        if kind == _TRACKER:
            truth = _tracked(load_scenario(scenario), seed, stops, Path(name))
        else:
            truth = _looped(load_scenario(scenario), seed, LoopWishes(kind, stops), Path(name))
        campaign = read_campaign(Path(name))
    return held_out(campaign, truth)


def _looped(scenario: Scenario, seed: int, wishes: LoopWishes, folder: Path) -> Truth:
    recording = record_loop(scenario, seed, wishes)
    write_loop(recording, folder)
    return _truth(recording.cell, recording.points.stops)


def _tracked(scenario: Scenario, seed: int, stops: int, folder: Path) -> Truth:
    recording = record(scenario, seed, Wishes(configurations=stops, validation=300, attachments=1))
    write_campaign(recording, folder)
    return _truth(recording.cell, recording.validation.stops)


def _truth(cell: Cell, stops: RecordedStops) -> Truth:
    joints = np.radians(stops.joints_deg)
    true = cell.true_positions(cell.conditions(joints, stops.direction, stops.time_s, stops.attachment))
    n, nests, _ = true.shape
    rows = np.repeat(np.arange(n), nests)
    return Truth(
        Stops(rows, joints[rows], stops.direction.astype(np.int64)[rows]),
        np.tile(np.arange(1, nests + 1), n),
        true.reshape(-1, 3),
    )


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
