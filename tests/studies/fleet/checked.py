"""Quick checks held against what they promise: growths that they tell, and those that they tell of nothing.

`python -m tests.studies.fleet.checked --fleets 5 --out out/checked`: of each fleet the check of one robot is
planned for every spring and gear line, and measured in the simulated cell of that robot: with each of the
causes grown by what was asked, in turn and in a phase drawn by chance, and with nothing grown. It is judged
by what the robot is known to be after its last campaign, every other cause being free to have grown as well.
"""

import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from tests.studies.fleet.simulated import FleetTruth, RobotTruth, draw_fleet, identified_fleet
from tests.studies.promise.tracker import recorded_stops
from tests.studies.running import leave, study_options
from truepose.domain.arrays import FloatArray
from truepose.exchange.cells.file import simulated_cell
from truepose.fleet.campaigns import effects_of_robot, fleet_of, information_of
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import Account, account_of
from truepose.fleet.interim_check import LEVEL, InterimCheck, checked_causes, grown, quick_check
from truepose.fleet.predicted_accuracy import of_robot_now
from truepose.identification.problem.build import JointPrior
from truepose.planning.prediction.expected_covariance import ArmKnowledge, PriorKnowledge
from truepose.planning.prediction.robots_and_cells import APPROACH_RAD
from truepose.planning.workspace.candidates import draw_candidates
from truepose.planning.workspace.space import space_to_measure
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.physics.effects import PlantedChange

_CANDIDATES: Final = 300


@dataclass(frozen=True, slots=True)
class Checked:
    """One check, measured once."""

    fleet: int
    configurations: int
    grown: str  # cause; empty: nothing
    chance: dict[str, float]  # of each cause: of so much where it has not grown


@dataclass(frozen=True)
class Planned:
    """The check of one robot."""

    fleet: FleetTruth
    robot: RobotTruth
    account: Account
    belief: JointPrior
    causes: tuple[AgeingCause, ...]
    check: InterimCheck
    size_mm: tuple[FloatArray, ...]  # of each cause (q,): what a stated width of each direction moves

    def planted(self, cause: AgeingCause, size_mm: FloatArray, by_mm: float, phase: float) -> PlantedChange:
        """Return a cause that has grown."""
        place = [int(np.argmax(column)) for column in cause.directions.T]
        amount = by_mm / size_mm * np.array([self.belief.specs[k].prior_width for k in place])
        if not cause.order:
            return PlantedChange(cause.effect, cause.subject, float(amount[0]))
        parts = np.degrees(amount) * np.array([np.cos(phase), np.sin(phase)])
        details = {"order": cause.order, "phase_deg": float(np.degrees(np.arctan2(parts[1], parts[0])))}
        return PlantedChange(cause.effect, cause.subject, float(np.hypot(*parts)), details=details)


def main() -> int:
    """Measure, print and write."""
    options = study_options(
        __doc__,
        out=Path,
        fleets=5,
        first=1,
        robots=12,
        growth=(0.05, "mm"),
        each=(6, "times that each cause grows"),
    )
    found: list[Checked] = []
    for seed in range(options.first, options.first + options.fleets):
        plan = _planned(seed, options.robots, options.growth)
        rng = np.random.default_rng([seed, 19])
        found += _measured(plan, rng, options.growth, options.each)
        sys.stderr.write(f"fleet {seed}: {len(plan.check.nest)} configurations, {len(found)} checks\n")
        leave(options.out, "checked", found)
    sys.stdout.write(_told(found))
    return 0


def _planned(seed: int, robots: int, grown_mm: float) -> Planned:
    truth = draw_fleet(seed, robots, ageing=0, drifting=False)
    account = account_of(fleet_of(identified_fleet(truth, 40)))
    described = simulated_cell("irb120-clean", seed)
    space, knowns = (
        space_to_measure(described, APPROACH_RAD),
        PriorKnowledge(fixed_nests=described.fixed_nests),
    )
    candidates = draw_candidates(space, _CANDIDATES, np.random.default_rng([seed, 3]))
    belief, causes = of_robot_now(account, account.fleet.robots[0]), checked_causes(account)
    check = quick_check(space, candidates, belief, causes, grown_mm, knowns)
    knowledge = ArmKnowledge(space, candidates, knowns.believing(belief))
    moved = knowledge.places(candidates.joints_rad, candidates.nest).motion
    each = np.sqrt((moved**2).sum(axis=1).mean(axis=0))
    place = np.array([knowledge.structure.index_of(name) for name in belief.names])
    sizes = tuple(each[place[np.argmax(cause.directions, axis=0)]] for cause in causes)
    return Planned(truth, truth.robots[0], account, belief, causes, check, sizes)


def _measured(plan: Planned, rng: np.random.Generator, by_mm: float, each: int) -> Iterator[Checked]:
    for number in range(each):
        for cause, size_mm in zip(plan.causes, plan.size_mm, strict=True):
            change = plan.planted(cause, size_mm, by_mm, float(rng.uniform(-np.pi, np.pi)))
            yield _judged(plan, by_mm, rng, (change,), _name(cause))
        for _ in range(3):
            yield _judged(plan, by_mm, rng, (), "")
        sys.stderr.write(f"  round {number + 1}\n")


def _judged(
    plan: Planned, by_mm: float, rng: np.random.Generator, changes: tuple[PlantedChange, ...], of: str
) -> Checked:
    scenario = plan.robot.scenario(1.0, 0.0)
    cell = Cell(
        replace(scenario, effects=(*scenario.effects, *changes)), int(rng.integers(2**31)), CellClock(0)
    )
    campaign = recorded_stops(cell, plan.check.joints_rad, plan.check.nest)
    told = information_of(campaign, effects_of_robot(campaign))
    found = grown(plan.account, plan.account.fleet.robots[0], told, by_mm)
    chances = {_name(one.cause): one.chance for one in found}
    return Checked(plan.fleet.seed, len(plan.check.nest), of, chances)


def _name(cause: AgeingCause) -> str:
    return f"{cause.effect} {cause.subject} {cause.order:g}".removesuffix(" 0")


def _told(found: list[Checked]) -> str:
    causes = list(found[0].chance)
    lines = [f"configurations: {np.mean([one.configurations for one in found]):.1f}"]
    for what, level in (("each cause", LEVEL), ("all together", LEVEL / len(causes))):
        lines += _told_at(found, causes, what, level)
    return "\n".join(lines) + "\n"


def _told_at(found: list[Checked], causes: list[str], what: str, level: float) -> Iterator[str]:
    grown, nothing = ([one for one in found if bool(one.grown) is way] for way in (True, False))
    told = [one.chance[one.grown] <= level for one in grown]
    false = np.array([[one.chance[cause] <= level for cause in causes] for one in nothing])
    yield f"level {LEVEL:g} of {what}: {sum(told)} of {len(told)} growths told"
    least = min(causes, key=lambda cause: _share(grown, cause, level))
    yield f"  least well {least}: {_share(grown, least, level):.2f}"
    some = int(false.any(axis=1).sum())
    yield f"  nothing grown: {false.mean():.4f} of causes told, in {some} of {len(nothing)} checks"


def _share(grown: list[Checked], cause: str, level: float) -> float:
    return float(np.mean([one.chance[cause] <= level for one in grown if one.grown == cause]))


if __name__ == "__main__":
    sys.exit(main())
