"""The same simulated IRB 120 calibrated in every way: how accurate each makes it, and what each promised.

`python -m tests.studies.five_ways --out out/five-ways` measures arms of `irb120-tilted` by tracker, camera,
ballbar, two spheres and wires, and holds each model against where a nest of the tool truly was at 300
configurations all over the work volume, after the best rigid motion: each way has its own world.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from tests.studies.five_ways.ways import JUDGED_NEST, WAYS, judged_at
from tests.studies.loops.held_out import HeldOut, held_out
from tests.studies.report_command import shown
from truepose.reports.table_report import Row, Section, Verdict, write_table_report


def main() -> int:
    """Measure everything, print it, write it."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, default=Path("out/five-ways"))
    parser.add_argument("--seeds", type=int, default=10)
    options = parser.parse_args()
    sections = shown(_sections(options.seeds))
    options.out.mkdir(parents=True, exist_ok=True)
    write_table_report(options.out / "five-ways.html", "One arm in five ways", sections, simulated=True)
    return 0


def _sections(seeds: int) -> Iterator[Section]:
    truths = {seed: judged_at(seed) for seed in range(1, seeds + 1)}
    for name, measure in WAYS.items():
        arms = [held_out(measure(seed), truth, (JUDGED_NEST,)) for seed, truth in truths.items()]
        yield Section(f"{name}: {seeds} arms", tuple(_figures(arms)))


def _figures(arms: list[HeldOut]) -> Iterator[Row]:
    nominal, mean, promised = (
        float(np.mean([getattr(arm, name) for arm in arms]))
        for name in ("nominal_mm", "mean_mm", "promised_mm")
    )
    worst, ratio = max(arm.worst_mm for arm in arms), mean / promised
    each = np.array([arm.mean_mm for arm in arms])
    yield Row("nominal arm, mean error", "", f"{nominal:.3f} mm", Verdict.NO_TARGET)
    yield Row("calibrated, mean error", "", f"{mean:.4f} mm", Verdict.NO_TARGET)
    yield Row("best and worst arm", "", f"{each.min():.4f} and {each.max():.4f} mm", Verdict.NO_TARGET)
    yield Row("calibrated, worst of all arms", "", f"{worst:.3f} mm", Verdict.NO_TARGET)
    yield Row("promised, mean error", "", f"{promised:.4f} mm", Verdict.NO_TARGET)
    yield Row("error / promise", "", f"{ratio:.2f}", Verdict.NO_TARGET)


if __name__ == "__main__":
    sys.exit(main())
