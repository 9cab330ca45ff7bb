"""Campaigns whose truth is a model of the service itself: they test the identification, not the model.

That the model is right is shown against the simulator, in `tests/system`.
"""

from dataclasses import dataclass, replace

import numpy as np

from tests.helpers.domain.robots import IRB_120
from truepose.domain.campaign import Campaign, LegReadings, PointReadings, Stops
from truepose.domain.robot import FramePlacement, Nest
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import Problem, automatic_effects, build
from truepose.kinematics.chain import forward, nominal_values

NESTS = ((0.0, 0.0, 125.0), (75.0, 93.675, 215.0), (150.0, 0.0, 125.0))
NOISE_MM = 0.015
_AT_THE_WORLD = FramePlacement()


def configurations(n, seed=0, robot=IRB_120):
    rng = np.random.default_rng(seed)
    low = [limit.lower_rad for limit in robot.calibration_ranges]
    high = [limit.upper_rad for limit in robot.calibration_ranges]
    return rng.uniform(low, high, (n, robot.n_joints))


def nominal_campaign(
    n=60, seed=0, robot=IRB_120, base=_AT_THE_WORLD, nests=NESTS, joints_rad=None, **changes
):
    """What a robot without errors and an instrument without noise would give."""
    joints = configurations(n, seed, robot) if joints_rad is None else joints_rad
    nest = 1 + np.arange(len(joints)) % len(nests)
    chain = forward(nominal_values(robot, joints), np.eye(3), np.zeros(3))
    places = chain.points(np.array(nests)[nest - 1])
    readings = PointReadings(
        Stops(np.arange(1, len(joints) + 1), joints), nest, places, np.full(len(joints), NOISE_MM)
    )
    values = {
        "robot": robot,
        "base_nominal": base,
        "nests": tuple(Nest(centre, 0.002) for centre in nests),
        "calibration": readings,
    }
    return Campaign(**(values | changes))


@dataclass
class Truth:
    """True parameter values by name."""

    values: dict[str, float]


def drawn(problem: Problem, seed=0, share=0.2):
    """True values: the prior mean plus a share of each prior width."""
    rng = np.random.default_rng(seed)
    widths = np.minimum(problem.structure.prior_widths, 1.0)
    return problem.structure.prior_means + share * widths * rng.standard_normal(len(widths))


def measured(campaign, values=None, noise_mm=NOISE_MM, seed=0, effects=None):
    """The campaign as a robot with these parameter values would give it, and the values by name."""
    problem = build(campaign, effects or automatic_effects(campaign))
    values = drawn(problem, seed) if values is None else values
    points = campaign.calibration
    state = evaluate(problem.structure, values, Targets(points.stops, points.nest))
    noise = noise_mm * np.random.default_rng(seed + 1).standard_normal((len(points), 3))
    readings = replace(points, position_mm=state.position_mm + noise)
    return replace(campaign, calibration=readings), Truth(
        dict(zip(problem.structure.names, values, strict=True))
    )


def shifted(campaign, rows, shift_mm):
    """The campaign with some readings off by a shift."""
    points = campaign.calibration
    position = points.position_mm.copy()
    position[rows] += shift_mm
    return replace(campaign, calibration=replace(points, position_mm=position))


def with_joints(campaign, joints_rad):
    """The campaign with other joint angles written beside the same positions."""
    points = campaign.calibration
    return replace(campaign, calibration=replace(points, stops=replace(points.stops, joints_rad=joints_rad)))


def leg_campaign(n=200, seed=0, noise_mm=0.005, offset_mm=0.0):
    """Lengths of a wire from an unknown anchor to an unknown nest of a robot without errors."""
    joints = configurations(n, seed)
    chain = forward(nominal_values(IRB_120, joints), np.eye(3), np.zeros(3))
    places = chain.points(np.array([10.0, -20.0, 90.0]))
    anchor = np.array([250.0, -450.0, -80.0])
    length = np.linalg.norm(places - anchor, axis=1) + offset_mm
    length += noise_mm * np.random.default_rng(seed + 1).standard_normal(n)
    ones = np.ones(n, dtype=np.int64)
    stops = Stops(np.arange(n), joints)
    legs = LegReadings(stops, ones, ones, ones, length, np.full(n, noise_mm))
    return Campaign(robot=replace(IRB_120, masses=()), base_nominal=None, nests=(Nest(None),), legs=legs)
