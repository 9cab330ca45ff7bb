"""Pairs of configurations that shall bring a tool nest to one place: without correction, and with it.

The first configuration of a pair is one that the controller itself would answer with: the target is where
the nominal robot would then have the nest, and how it would hold the tool. The second is the corrected one.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.correction.goals import Goals
from truepose.correction.joint_targets import correct
from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import Stops
from truepose.domain.measurement.session import PlannedStop, SessionPlan
from truepose.domain.results.identification import Model
from truepose.identification.model.estimates import nominal_estimate
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.validity.same_robot import require_same_robot
from truepose.planning.tracker.session_plans import plan_validation
from truepose.planning.work_volume.candidates import have_room_to_approach
from truepose.planning.work_volume.work_space import WorkSpace


@dataclass(frozen=True, slots=True)
class Pairs(Table):
    """n targets, and how to reach them."""

    nest: IntArray  # (n,)
    target_mm: FloatArray  # (n, 3) world
    uncorrected_rad: FloatArray  # (n, J)
    corrected_rad: FloatArray  # (n, J)
    solved: BoolArray  # (n,) others have no correction

    def __len__(self) -> int:
        return len(self.nest)


def pairs_of(model: Model, stops: Stops, nest: IntArray) -> Pairs:
    """Return the pair that begins with each of n stops of the controller's own."""
    nominal = nominal_estimate(model)
    wanted = evaluate(nominal.structure, nominal.values, Targets(stops, nest))
    goals = Goals(stops, nest, wanted.unscaled_mm, wanted.chain.end_rotation)
    found = correct(model, goals)
    return Pairs(nest, wanted.unscaled_mm, stops.joints_rad, found.joints_rad, found.solved)


def plan_proof(space: WorkSpace, template: SessionPlan, model: Model, n: int, seed: int) -> SessionPlan:
    """Fill the stops of a template with pairs at random targets, corrected right after uncorrected.

    Parameters
    ----------
    space : WorkSpace
    template : SessionPlan
        Role, approach and all else.
    model : Model
        That is to be proved.
    n : int
        Number of targets; each is visited twice. Targets that the model cannot correct within the limits,
        or whose correction leaves no room to approach it, are left out.
    seed : int

    Raises
    ------
    ConfigurationError
        The model is of another robot, or not one of the targets can be corrected.
    WorkSpaceError, TooFewCandidatesError, NoWayError
        As of a validation's plan.
    """
    require_same_robot(model, space.robot)
    approached = replace(space, approach_offset_rad=template.approach_offset_rad)
    drawn = plan_validation(approached, n, seed).stops
    joints, nest = np.array([stop.joints_rad for stop in drawn]), np.array([stop.nest for stop in drawn])
    stops = Stops(np.arange(n), joints, direction=approach_directions(joints, template.approach_offset_rad))
    pairs = pairs_of(model, stops, nest)
    # A stop at the edge of its range may be corrected to where its approach begins beyond a limit.
    reached = pairs.solved.copy()
    reached[reached] = have_room_to_approach(approached, pairs.corrected_rad[reached])
    if not reached.any():
        raise ConfigurationError("Not one of the targets can be corrected: the model is not of this robot.")
    return replace(template, stops=tuple(_visits(pairs.taken(np.flatnonzero(reached)))))


def approach_directions(joints_rad: FloatArray, offset_rad: float | None) -> IntArray | None:
    """Return from which side joints come to stops, shape (n, J); None where that differs by the stop."""
    if not offset_rad:
        return None
    return np.full(joints_rad.shape, -int(np.sign(offset_rad)))


def _visits(pairs: Pairs) -> list[PlannedStop]:
    found = []
    for k in range(len(pairs)):
        for twice, joints in enumerate((pairs.uncorrected_rad[k], pairs.corrected_rad[k])):
            found.append(PlannedStop(2 * k + 1 + twice, tuple(joints.tolist()), int(pairs.nest[k])))
    return found
