"""Campaigns whose rows tell everything that an effect may depend on, and what a diagnosis sees of them."""

from dataclasses import replace
from functools import cache

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import nominal_campaign
from truepose.diagnosis.baseline_fit import scene_at
from truepose.domain.campaign import FixedNestReadings
from truepose.domain.robot import FixedNest
from truepose.effects.causes import FittedCause
from truepose.identification.model.evaluation import evaluate, rows_of
from truepose.identification.problem.build import build

TRACKER_MM = (2600.0, -700.0, 500.0)
FIXED_MM = ((600.0, 500.0, 0.0), (600.0, -500.0, 0.0), (-350.0, 500.0, 0.0))
START = ("base", "geometry", "compliance")
# Of causes that the usual start has as parameters already.
_ANOTHER_START = {
    "axis_parallelism": ("base", "geometry_dhm", "compliance"),
    "compliance": ("base", "geometry"),
}
ORIGIN_S = 1000.0
_CADENCE_S = 30.0


def telling_campaign(n=24, robot=IRB_120, seed=5, joints_rad=None, **changes):
    """Positions of three nests, with directions, times, temperatures, mountings and looks at fixed nests."""
    rng = np.random.default_rng(seed)
    campaign = nominal_campaign(
        n, robot=robot, joints_rad=joints_rad, tracker_position_mm=TRACKER_MM,
        fixed_nests=tuple(FixedNest(centre, 0.002) for centre in FIXED_MM),
    )  # fmt: skip
    stops = replace(
        campaign.calibration.stops,
        direction=rng.choice([-1, 1], (n, robot.n_joints)),
        time_s=ORIGIN_S + _CADENCE_S * np.arange(n),
        temperature_c=23.0 + 3.0 * np.sin(0.3 * np.arange(n)),
        attachment=1 + np.arange(n) * 4 // n,
        move_rad=np.diff(campaign.calibration.stops.joints_rad, axis=0, prepend=np.nan),
    )
    looks = np.arange(6 * 3)
    reference = FixedNestReadings(
        time_s=ORIGIN_S - 10.0 + _CADENCE_S * n / 6.0 * (looks // 3),
        fixed_nest=1 + looks % 3,
        position_mm=np.array(FIXED_MM)[looks % 3],
        standard_uncertainty_mm=np.full(len(looks), 0.015),
    )
    readings = replace(campaign.calibration, stops=stops)
    return replace(campaign, calibration=readings, reference=reference, **changes)


def without_masses(robot=IRB_120):
    """The robot of somebody who does not know what its links weigh."""
    return replace(robot, masses=())


def fitted(*names_and_values, spread=0.0):
    """A cause as it was fitted: (name, value) of each parameter, all with one standard uncertainty."""
    names, values = zip(*names_and_values, strict=True)
    return FittedCause(names, np.array(values), spread**2 * np.eye(len(names)))


def start_for(cause):
    """Effects of a model that lacks a cause."""
    return _ANOTHER_START.get(cause, START)


@cache
def telling_problem(effects=START):
    """The problem of the telling campaign with some effects, placed once."""
    return build(telling_campaign(), effects)


def rows_at_start(problem):
    """What effects are told of the readings of a problem where its fit starts."""
    return rows_of(evaluate(problem.structure, problem.start, problem.blocks[0].targets))


def scene_of(problem, values=None, campaign=None, **changes):
    """What a diagnosis would look at after a fit that ended at `values`."""
    values = problem.start if values is None else values
    state = evaluate(problem.structure, values, problem.blocks[0].targets)
    reference = None if campaign is None else campaign.reference
    read_s = np.zeros(0) if reference is None else reference.time_s
    return replace(scene_at(problem, state, read_s), **changes)


def telling_scene(effects=START, campaign=None, **changes):
    """The scene of a telling campaign that was fitted with some effects."""
    if campaign is None:
        return replace(_usual_scene(effects), **changes)
    return scene_of(build(campaign, effects), campaign=campaign, **changes)


@cache
def _usual_scene(effects):
    return scene_of(telling_problem(effects), campaign=telling_campaign())
