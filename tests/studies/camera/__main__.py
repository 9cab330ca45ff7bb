"""Three setups of the thesis (A. Nubiola, 2014, chapter 2): tracker, camera with flat or spatial artefact.

`python -m tests.studies.camera --out out/camera` calibrates each arm with each of them from 36
configurations, a second a seed, and says: true errors where the instrument sees the arm and all over the work
space, what the best estimator would be left with, what orientations are worth, and the order of the three.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.camera.errors import bound_mean_mm, true_mean_mm
from tests.studies.camera.setups import (
    FLAT,
    SPATIAL,
    TRACKER,
    anywhere,
    drawn,
    measured,
    planned,
    positions_only,
    setup,
)
from tests.studies.report_command import informing, report, target_row
from tests.studies.running import study_options
from truepose.identification import identify
from truepose.reports.table_report import Row, Section

_TARGET_MM: Final = 0.045
_JUDGED: Final = 300  # configurations, three nests each
_NAMES: Final = {TRACKER: "tracker", FLAT: "camera, flat artefact", SPATIAL: "camera, spatial artefact"}


@dataclass(frozen=True, slots=True)
class Calibrated:
    """One arm, calibrated in one setup: mean errors [mm]."""

    seen: float  # where the instrument sees the arm
    everywhere: float
    bound_seen: float
    bound_everywhere: float
    random_plan: float  # seen, from random configurations
    positions_only: float  # seen; of a tracker the same
    chi2: float


def main() -> int:
    """Measure everything, print it, write it; status 1 where a target is missed."""
    options = study_options(__doc__, out=Path("out/camera"), seeds=12, configurations=36)
    sections = _sections(options.seeds, options.configurations)
    return report(sections, options.out / "camera.html", "Three setups")


def _sections(seeds: int, n: int) -> Iterator[Section]:
    found: dict[str, list[Calibrated]] = {}
    for scenario in _NAMES:
        found[scenario] = [calibrated(scenario, seed, n) for seed in range(1, seeds + 1)]
        yield _section(scenario, found[scenario])
    yield _order(found)


def calibrated(scenario: str, seed: int, n: int) -> Calibrated:
    """Calibrate one arm in one setup."""
    here = setup(scenario, seed)
    at, random = planned(here, n), drawn(here, n + _JUDGED)
    seen, everywhere = random.joints_rad[n:], anywhere(here, _JUDGED)
    campaign = measured(here, at)
    found, plain = identify(campaign), identify(measured(here, random.subset(np.arange(n))))
    alone = found if here.camera is None else identify(positions_only(campaign))
    return Calibrated(
        seen=true_mean_mm(here, found.model, seen),
        everywhere=true_mean_mm(here, found.model, everywhere),
        bound_seen=bound_mean_mm(here, at, seen),
        bound_everywhere=bound_mean_mm(here, at, everywhere),
        random_plan=true_mean_mm(here, plain.model, seen),
        positions_only=true_mean_mm(here, alone.model, seen),
        chi2=found.chi2_per_dof,
    )


def _section(scenario: str, each: list[Calibrated]) -> Section:
    target = None if scenario == TRACKER else _TARGET_MM
    rows = [
        _row("true mean error where it is seen", [c.seen for c in each], target),
        _row("the same all over the work space", [c.everywhere for c in each]),
        _row("bound where it is seen", [c.bound_seen for c in each]),
        _row("bound all over the work space", [c.bound_everywhere for c in each]),
        _row("from random configurations, seen", [c.random_plan for c in each]),
        _row("chi2 per degree of freedom", [c.chi2 for c in each], unit=""),
    ]
    if scenario != TRACKER:
        ratio = float(np.mean([c.seen for c in each]) / np.mean([c.positions_only for c in each]))
        rows += [
            _row("positions only, seen", [c.positions_only for c in each]),
            informing("orientations used / positions only", f"{ratio:.2f}"),
        ]
    return Section(f"{_NAMES[scenario]}, {len(each)} seeds: mean (median, least to largest)", tuple(rows))


def _row(figure: str, values: list[float], target: float | None = None, unit: str = " mm") -> Row:
    mean = float(np.mean(values))
    said = f"{mean:.4f}{unit} ({np.median(values):.4f}, {min(values):.4f} to {max(values):.4f})"
    if target is None:
        return informing(figure, said)
    return target_row(figure, f"<= {target:g} mm", said, good=mean <= target)


def _order(found: dict[str, list[Calibrated]]) -> Section:
    means = {name: float(np.mean([c.everywhere for c in each])) for name, each in found.items()}
    ordered = sorted(means, key=means.__getitem__)
    said = " < ".join(f"{_NAMES[name]} {means[name]:.3f}" for name in ordered)
    target = "tracker 0.146 < spatial 0.149 < flat 0.176"
    row = target_row("mean", target, said, good=ordered == [TRACKER, SPATIAL, FLAT])
    return Section("Order of the setups all over the work space", (row,))


if __name__ == "__main__":
    sys.exit(main())
