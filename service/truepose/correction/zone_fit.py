"""The arm of other programs and controllers that comes nearest to the full model over the measured zone.

The full model says where the nests are in configurations of the zone; the nominal robot is fitted to these
with the parameters that the other side has, least squares without weights. What the other side lacks, such as
springs, goes into these parameters as far as it can.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from truepose.correction.zone_errors import placed
from truepose.domain.measurement.campaign import Campaign, PointReadings
from truepose.domain.results.identification import Model
from truepose.domain.robot import Nest
from truepose.identification.fit.robust import RobustFit, fit
from truepose.identification.model.evaluation import Targets
from truepose.identification.model.rigid import RigidArm, rigid_arm
from truepose.identification.model_of_fit import Fits, model_of
from truepose.identification.problem.build import Problem, build

# The same for all, and far below what the priors allow: they hold only what no configuration shows.
_STATED_MM: Final = 0.01


def nearest_arm(model: Model, targets: Targets, effects: tuple[str, ...]) -> RigidArm:
    """Return the nominal robot with the effects' parameters that come nearest to a model.

    Parameters
    ----------
    model : Model
    targets : Targets
        Configurations of the zone, each with every nest.
    effects : tuple of str
        Rigid ones: base, tool, geometry, joint_offset.

    Returns
    -------
    RigidArm
        `left_out` names what the model has beside its own rigid part.
    """
    campaign = _as_readings(model, targets)
    problem = build(campaign, effects)
    fitted = model_of(Fits(campaign, *_evenly(problem)), discrepancy_mm=0.0, program_version="")
    return replace(rigid_arm(fitted), left_out=rigid_arm(model).left_out, uncertainty=_unknown(model))


def _as_readings(model: Model, targets: Targets) -> Campaign:
    stops = replace(targets.stops, direction=None)
    stated = np.full(len(targets), _STATED_MM)
    readings = PointReadings(stops, targets.nest, placed(model, targets), stated)
    robot = replace(model.robot, repeatability_mm=0.0)
    return Campaign(robot, None, tuple(Nest(None) for _ in model.nests), calibration=readings)


def _evenly(problem: Problem) -> tuple[RobustFit, RobustFit, np.ndarray]:
    """Return the fit in which every place counts the same, twice, and a covariance that says nothing."""
    solution = fit(problem.structure, problem.blocks, problem.start)
    none = (np.zeros(len(problem.blocks[0].weights), dtype=bool),)
    even = RobustFit(problem.structure, problem.blocks, solution, none, float("nan"))
    return even, even, np.zeros((len(problem.structure.specs),) * 2)


def _unknown(model: Model) -> tuple[dict[str, float], ...]:
    return tuple({} for _ in model.robot.joints)
