"""New robots of the type of a fleet: few readings and the type against many alone, at unseen places."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from tests.studies.fleet.simulated import FleetTruth, RobotTruth, draw_new, new_cell, record_robot
from tests.studies.promise.tracker import predicted_mm, recorded, true_mm
from truepose.domain.campaign import Campaign
from truepose.exchange.cells.file import simulated_cell
from truepose.fleet.causes import robot_causes
from truepose.fleet.changes import Account
from truepose.fleet.interim_check import quick_check
from truepose.fleet.predicted_accuracy import (
    PredictedAccuracy,
    as_stated,
    lacking_mm,
    of_a_new_robot,
    of_robot_now,
    promise,
)
from truepose.identification import identify
from truepose.identification.problem.build import JointPrior
from truepose.planning.prediction.expected_covariance import PriorKnowledge
from truepose.planning.prediction.plan import VolumeSample, WorkVolume, sample
from truepose.planning.prediction.robots_and_cells import APPROACH_RAD
from truepose.planning.workspace.candidates import draw_candidates
from truepose.planning.workspace.space import space_to_measure

_PLACES: Final = 300
_GROWN_MM: Final = 0.05
_GEAR_LINES: Final = 10.0  # periods per turn from which a wave is a gear's


@dataclass(frozen=True, slots=True)
class Promises:
    """What is promised before a robot of one fleet's type is measured."""

    seed: int
    pooled_mm: float  # with 15 readings and the type
    alone_mm: float  # with 50 alone
    quick_check: int  # configurations; 0: not enough of them
    lacking_mm: float


@dataclass(frozen=True, slots=True)
class Beforehand:
    """What is known before a new robot of a fleet's type is measured."""

    belief: JointPrior
    promise: PredictedAccuracy
    figures: Promises
    places: VolumeSample


@dataclass(frozen=True, slots=True)
class NewRobot:
    """Mean errors of one new robot over its work volume."""

    seed: int
    pooled_mm: float  # 15 readings with what the type says
    alone_mm: float  # 50 with the usual effects
    same_mm: float  # 50 with the effects of the fleet, from stated priors


def promised(account: Account, truth: FleetTruth) -> Beforehand:
    """Say what a new robot will come to."""
    described = simulated_cell("irb120-clean", truth.seed)
    space, knowns = (
        space_to_measure(described, APPROACH_RAD),
        PriorKnowledge(fixed_nests=described.fixed_nests),
    )
    belief = of_a_new_robot(account)
    steady = next(one for one in truth.robots if one.ageing is None)
    typical = record_robot(steady, 0, "tracker A", truth, 60).campaign
    said = promise(space, belief, typical, knowns=knowns, seed=truth.seed)
    rng = np.random.default_rng([truth.seed, 3])
    every = robot_causes(account.fleet)
    causes = [one for one in every if one.effect == "compliance" or one.order > _GEAR_LINES]
    candidates = draw_candidates(space, 300, rng)
    now = of_robot_now(account, account.fleet.robots[0])
    check = quick_check(space, candidates, now, causes, _GROWN_MM, knowns)
    needed = len(check.nest) if check.enough else 0
    lacking = lacking_mm(belief, typical)
    figures = Promises(truth.seed, said.pooled.mean_mm, said.alone.mean_mm, needed, lacking)
    return Beforehand(belief, said, figures, sample(space, WorkVolume(), _PLACES, rng))


def newcomers(account: Account, truth: FleetTruth, said: Beforehand, count: int) -> list[NewRobot]:
    """Measure and identify new robots of the type."""
    return [_newcomer(robot, truth.seed, said) for robot in draw_new(truth.seed, count)]


def _newcomer(robot: RobotTruth, seed: int, said: Beforehand) -> NewRobot:
    cell = new_cell(robot, seed)
    few, many = (recorded(cell, plan) for plan in (said.promise.pooled, said.promise.alone))
    true = true_mm(cell, said.places)

    def mean_error(campaign: Campaign, believed: JointPrior | None) -> float:
        model = identify(campaign, believed=believed).model
        if model is None:
            raise AssertionError("nothing could be identified of a new robot")
        return float(np.linalg.norm(predicted_mm(model, said.places) - true, axis=1).mean())

    return NewRobot(
        robot.number,
        mean_error(few, said.belief),
        mean_error(many, None),
        mean_error(many, as_stated(said.belief)),
    )
