"""Sphere tests: a nest of an arm that is known, held a bar's length from a ball that it was taught."""

from dataclasses import replace

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, parameters_of
from truepose.domain.campaign import Campaign, CupSetups, LegReadings, Stops
from truepose.domain.identification import NestCentre
from truepose.domain.robot import FramePlacement, Nest
from truepose.kinematics.chain import nominal_chain

NESTS_MM = ((0.0, 0.0, 125.0), (115.0, 0.0, 215.0))
BAR_MM = 300.0
TAUGHT_RAD = np.radians([10.0, 50.0, -10.0, 20.0, 40.0, 30.0])
LENGTH_U_MM = 0.0017
SCATTER_MM = 0.0035
SETUP_U_MM = 0.002


def places_of(robot, joints_rad, nest):
    """Where the nests of a robot are whose base is the world, shape (n, 3)."""
    return nominal_chain(robot, joints_rad).points(np.array(NESTS_MM)[nest - 1])


def stops_on_sphere(per_nest=40, nests=(1, 2), seed=1, arm=IRB_120, reach_rad=0.9):
    """Configurations in which a nest of an arm is a bar's length from where it held the ball, and the nests.

    Newton's way along the bar leads there from configurations `reach_rad` about one.
    """
    rng = np.random.default_rng(seed)
    centre = places_of(arm, TAUGHT_RAD[None], np.ones(1, dtype=int))[0]
    found = [_stops_of(nest, per_nest, centre, arm, rng, reach_rad) for nest in nests]
    return np.vstack(found), np.repeat(nests, per_nest)


def _stops_of(nest, count, centre, arm, rng, reach_rad):
    kept = []
    while len(kept) < count:
        joints = TAUGHT_RAD - np.radians([0, 40, 0, 0, 0, 0]) + rng.uniform(-reach_rad, reach_rad, 6)
        for _ in range(30):
            length, slope = _length(joints, nest, centre, arm)
            joints = joints + slope * (BAR_MM - length) / (slope @ slope)
        length, _ = _length(joints, nest, centre, arm)
        if abs(length - BAR_MM) < 1e-9 and np.abs(joints).max() < np.pi:
            kept.append(joints)
    return np.array(kept)


def _length(joints, nest, centre, arm):
    near = joints + np.vstack([np.zeros(6), 1e-6 * np.eye(6)])
    lengths = np.linalg.norm(places_of(arm, near, np.full(7, nest)) - centre, axis=1)
    return lengths[0], (lengths[1:] - lengths[0]) / 1e-6


def sphere_campaign(true=IRB_120, *, joints_rad=None, nest=None, noise=0.0, seed=2, taught=True, **stops):
    """The campaign of a sphere test of a true arm, whose targets its nominal table put on the sphere.

    `noise` is in stated standard uncertainties: 1 scatters lengths and arm as the campaign says, and has the
    instrument read all lengths wrong by one draw.
    """
    if joints_rad is None:
        joints_rad, nest = stops_on_sphere(**stops)
    rng = np.random.default_rng(seed)
    arm_mm = noise * SCATTER_MM * rng.standard_normal((len(joints_rad) + 1, 3))
    ball = places_of(true, TAUGHT_RAD[None], np.ones(1, dtype=int))[0] + arm_mm[0]
    ball = ball + noise * SETUP_U_MM * rng.standard_normal(3)
    length = np.linalg.norm(places_of(true, joints_rad, nest) + arm_mm[1:] - ball, axis=1)
    length = length + noise * LENGTH_U_MM * (rng.standard_normal(len(length)) + rng.standard_normal())
    setup = CupSetups(np.ones(1, dtype=int), np.ones(1, dtype=int), TAUGHT_RAD[None])
    return Campaign(
        robot=replace(IRB_120, repeatability_mm=SCATTER_MM),
        base_nominal=FramePlacement(),
        nests=tuple(Nest(centre, 0.002) for centre in NESTS_MM),
        legs=legs_of(joints_rad, nest, length),
        setup=setup if taught else None,
        ballbar_nominal_mm=BAR_MM,
        ballbar_range_mm=1.0,
        setup_uncertainty_mm=SETUP_U_MM,
    )


def legs_of(joints_rad, nest, length_mm):
    """Lengths from the one ball, as a table."""
    n, one = len(nest), np.ones(len(nest), dtype=int)
    stops = Stops(np.arange(1, n + 1), joints_rad)
    return LegReadings(stops, one, one, nest, length_mm, np.full(n, LENGTH_U_MM))


def longer(joint=2, by_mm=0.2):
    """An IRB 120 of which one link is longer than its table says; by default the upper arm."""
    rows = list(IRB_120.joints)
    rows[joint] = replace(rows[joint], a_mm=rows[joint].a_mm + by_mm)
    return replace(IRB_120, joints=tuple(rows))


def knowing(by_mm=0.2):
    """The model of such an upper arm."""
    nests = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS_MM, start=1))
    return model_of(IRB_120, *parameters_of("geometry", [("a_3", by_mm, "mm")]), nests=nests)
