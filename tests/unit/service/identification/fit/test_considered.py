"""What certificates add to the covariance, against campaigns whose certificates are drawn anew."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS, nominal_campaign
from truepose.domain.campaign import FixedNestReadings
from truepose.domain.robot import FixedNest, Nest, WorldRegistration
from truepose.identification.fit.assessment import propagate_certificates, world_registration
from truepose.identification.fit.robust import RobustFit, fit
from truepose.identification.model.evaluation import evaluate
from truepose.identification.problem.build import build
from truepose.kinematics.frames import rotation_from_vector

ARM = replace(IRB_120, masses=())
EFFECTS = ("base", "geometry")
NEST_MM = 0.05
DRAWS = 200


def plain_fit(problem, start=None):
    """One fit with all weights one: what certificates add is linear and has nothing to do with robustness."""
    solution = fit(problem.structure, problem.blocks, problem.start if start is None else start)
    flags = tuple(np.zeros(len(block.weights), dtype=bool) for block in problem.blocks)
    return RobustFit(problem.structure, problem.blocks, solution, flags, float("nan"))


def with_nests(problem, nests_mm):
    return replace(problem, structure=replace(problem.structure, nests_mm=nests_mm))


def moved(problem, motion):
    block = problem.blocks[0]
    seen = block.measured_mm @ rotation_from_vector(motion[3:]).T + motion[:3]
    return replace(problem, blocks=(replace(block, measured_mm=seen),))


def scores(values, truth, covariance):
    return (values - truth) / np.sqrt(np.diag(covariance))


def assert_scatter_is_as_stated(found):
    """Variances of `DRAWS` scores are known to sqrt(2 / DRAWS) = 10 % each; up to 26 must hold at once."""
    assert np.mean(np.square(found), axis=0) == pytest.approx(1.0, abs=5 * np.sqrt(2.0 / DRAWS))
    assert np.mean(np.square(found)) == pytest.approx(1.0, abs=0.25)


def test_drawn_nest_errors_scatter_the_parameters_as_stated():
    rng = np.random.default_rng(0)
    campaign = replace(
        nominal_campaign(40, robot=ARM), nests=tuple(Nest(centre, NEST_MM) for centre in NESTS)
    )
    problem = build(campaign, EFFECTS)
    base = plain_fit(problem)
    stated = propagate_certificates(campaign, base)
    found = []
    for _ in range(DRAWS):
        wrong = np.array(NESTS) + NEST_MM * rng.standard_normal((3, 3))
        found.append(
            scores(plain_fit(with_nests(problem, wrong), base.values).values, base.values, stated.nests)
        )

    # what nests hardly move is below the step at which the solver stops
    moves = np.sqrt(np.diag(stated.nests)) > 0.05 * np.sqrt(np.diag(stated.readings))
    assert moves.sum() > 10
    assert_scatter_is_as_stated(np.array(found)[:, moves])
    assert not stated.registration.any()


def test_a_turned_and_shifted_world_scatters_the_base_and_nothing_else():
    rng = np.random.default_rng(1)
    covariance = np.diag([0.02**2] * 3 + [2e-5**2] * 3)
    covariance[0, 4] = covariance[4, 0] = 0.5 * 0.02 * 2e-5
    world = WorldRegistration(covariance)
    exact = tuple(Nest(centre) for centre in NESTS)
    campaign = replace(nominal_campaign(40, robot=ARM), registration=world, nests=exact)
    problem = build(campaign, EFFECTS)
    base = plain_fit(problem)
    stated = propagate_certificates(campaign, base)
    factor, found = np.linalg.cholesky(covariance), []
    for _ in range(DRAWS):
        again = plain_fit(moved(problem, factor @ rng.standard_normal(6)), base.values)
        found.append(scores(again.values, base.values, stated.registration)[:6])

    assert_scatter_is_as_stated(np.array(found))
    geometry = np.sqrt(np.diag(stated.registration) / np.diag(stated.readings))[6:]
    assert geometry.max() < 0.02
    assert stated.total == pytest.approx(stated.readings + stated.registration)


def test_where_orientations_are_measured_a_turned_world_still_turns_the_base_by_as_much():
    campaign = nominal_campaign(40, robot=ARM)
    problem = build(campaign, EFFECTS)
    seen = evaluate(problem.structure, problem.start, problem.blocks[0].targets).orientation
    quaternion = Rotation.from_matrix(seen).as_quat()[:, [3, 0, 1, 2]]
    points = replace(campaign.calibration, quaternion=quaternion, rotation_uncertainty_rad=np.full(40, 1e-5))
    world = WorldRegistration(np.diag([1e-12] * 3 + [1e-4**2] * 3))
    oriented = replace(campaign, calibration=points, registration=world)

    base = plain_fit(build(oriented, ("base", "tool", "geometry")))
    stated = propagate_certificates(oriented, base)

    turns = [base.structure.index_of(name) for name in ("base_rx", "base_ry", "base_rz")]
    # exactly the world's, but for the pull of the priors
    assert np.sqrt(np.diag(stated.registration))[turns] == pytest.approx(1e-4, rel=1e-3)


def test_looks_at_the_fixed_nests_say_how_well_the_world_is_known():
    rng = np.random.default_rng(2)
    places = np.array([[0.0, 0.0, 0.0], [1000.0, 0.0, 0.0], [0.0, 800.0, 0.0], [300.0, 300.0, 500.0]])
    fixed = tuple(FixedNest(tuple(place), 0.005) for place in places)
    number = np.tile([1, 2, 3, 4], 5)
    sigma = np.full(20, 0.03)
    looks = FixedNestReadings(np.arange(20.0), number, places[number - 1], sigma)
    campaign = replace(nominal_campaign(20), fixed_nests=fixed, reference=looks)

    stated = world_registration(campaign).covariance

    weights, motions = 1.0 / (0.03**2 / 5 + 0.005**2), []
    design = np.vstack([np.hstack([np.eye(3), -skew(place)]) for place in places])
    for _ in range(2000):
        seen = rng.standard_normal(12) / np.sqrt(weights)
        motions.append(np.linalg.lstsq(design, seen, rcond=None)[0])
    # 2,000 draws know a variance to 3.2 %, four times that
    assert np.diag(stated) == pytest.approx(np.var(motions, axis=0), rel=0.13)


def test_with_fewer_than_three_fixed_nests_nothing_is_said_of_the_world():
    assert world_registration(nominal_campaign(20)) is None


@pytest.mark.parametrize("looked_at", [(1, 2), (1, 2, 4)], ids=["two of four", "three on a line"])
def test_nests_that_were_looked_at_and_leave_a_turn_open_say_nothing_of_the_world(looked_at):
    places = np.array([[600.0, -500.0, 0.0], [600.0, 500.0, 0.0], [-350.0, 500.0, 0.0], [600.0, 0.0, 0.0]])
    fixed = tuple(FixedNest(tuple(place), 0.005) for place in places)
    number = np.repeat(looked_at, 5)
    looks = FixedNestReadings(
        np.arange(float(len(number))), number, places[number - 1], np.full(len(number), 0.03)
    )

    assert world_registration(replace(nominal_campaign(20), fixed_nests=fixed, reference=looks)) is None


def skew(vector):
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
