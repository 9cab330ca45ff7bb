"""Everything that takes long, on several cores."""

from collections.abc import Iterable, Iterator, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tests.studies.ballbar_report.connections import SlipCounts, count_slips
from tests.studies.ballbar_report.plans import KINDS, made_plan, plan_path
from tests.studies.ballbar_report.robot_sections import SCENARIOS, TILTED
from tests.studies.ballbar_report.robots import Outcome, Robot, compare_robots
from truepose.demo.client import Told

_TOGETHER: Final = 8  # robots for one start of a recorder
_STOPS_TOGETHER: Final = 100


@dataclass(frozen=True, slots=True)
class Extent:
    """How much is measured."""

    robots: int = 24  # of each scenario, each in every kind of session
    validation: int = 3000  # tracker positions of each
    stops: int = 2000  # at which wrong connections are made
    draws: int = 20000  # of the twelve lengths of the pose device
    first_seed: int = 1


def make_plans(folder: Path, workers: Executor, told: Told) -> None:
    """Make the plans that are not there yet."""
    for done, path in enumerate(workers.map(made_plan, KINDS, [folder] * len(KINDS)), start=1):
        told(done, len(KINDS), path.name)


def robots_of(extent: Extent, plans: Path) -> tuple[Robot, ...]:
    """Return every robot in every kind of session."""
    return tuple(
        Robot(
            scenario, kind.key, plan_path(kind, plans), seed, extent.validation, coverage=scenario == TILTED
        )
        for scenario in SCENARIOS
        for kind in KINDS
        for seed in range(extent.first_seed, extent.first_seed + extent.robots)
    )


def outcomes_of(robots: Sequence[Robot], workers: Executor, told: Told) -> list[Outcome]:
    """Compare robots, some at a time, and tell how many are done."""
    outcomes: list[Outcome] = []
    parts = [tuple(robots[at : at + _TOGETHER]) for at in range(0, len(robots), _TOGETHER)]
    for done in workers.map(compare_robots, parts):
        outcomes += done
        told(len(outcomes), len(robots), done[0].scenario)
    return outcomes


def slips_of(extent: Extent, workers: Executor, told: Told) -> SlipCounts:
    """Make slips at all stops and return the counts."""
    parts = list(_parts(extent.stops))
    seeds = range(extent.first_seed, extent.first_seed + len(parts))
    return _summed(workers.map(count_slips, parts, seeds), extent.stops, told)


def _parts(stops: int) -> Iterator[int]:
    for at in range(0, stops, _STOPS_TOGETHER):
        yield min(_STOPS_TOGETHER, stops - at)


def _summed(counts: Iterable[SlipCounts], stops: int, told: Told) -> SlipCounts:
    total = SlipCounts()
    for count in counts:
        total += count
        told(total.stops, stops, "stops")
    return total
