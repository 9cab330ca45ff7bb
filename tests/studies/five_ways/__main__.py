"""The same simulated IRB 120 calibrated in every way: how accurate each makes it, and what each promised.

`python -m tests.studies.five_ways --out out/five-ways` measures arms of `irb120-tilted` by tracker, camera,
ballbar, two spheres and wires, and holds each model against where a nest of the tool truly was at 300
configurations all over the work volume, after the best rigid motion: each way has its own world.
"""

import sys
from collections.abc import Iterator
from pathlib import Path

from tests.studies.five_ways.ways import JUDGED_NEST, WAYS, judged_at
from tests.studies.loops.held_out import HeldOut, errors_of, held_out, promise_ratio
from tests.studies.report_command import informing, report
from tests.studies.running import study_options
from truepose.reports.table_report import Row, Section


def main() -> int:
    """Measure everything, print it, write it."""
    options = study_options(__doc__, out=Path("out/five-ways"), seeds=10)
    return report(_sections(options.seeds), options.out / "five-ways.html", "One arm in five ways")


def _sections(seeds: int) -> Iterator[Section]:
    truths = {seed: judged_at(seed) for seed in range(1, seeds + 1)}
    for name, measure in WAYS.items():
        arms = [held_out(measure(seed), truth, (JUDGED_NEST,)) for seed, truth in truths.items()]
        yield Section(f"{name}: {seeds} arms", tuple(_figures(arms)))


def _figures(arms: list[HeldOut]) -> Iterator[Row]:
    each = [arm.mean_mm for arm in arms]
    yield from errors_of(arms)
    yield informing("best and worst arm", f"{min(each):.4f} and {max(each):.4f} mm")
    yield informing("error / promise", f"{promise_ratio(arms):.2f}")


if __name__ == "__main__":
    sys.exit(main())
