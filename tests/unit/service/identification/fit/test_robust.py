"""The robust fit: what it leaves alone, what it adds, what it refuses."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from scipy.special import gammaincinv

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.closed_loops import contact_campaign
from tests.helpers.identification.synthetic import drawn, measured, nominal_campaign, shifted
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.contacts import TargetKind
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification import identify
from truepose.identification.distributions import chi2_median
from truepose.identification.fit.robust import _softly, robust_fit, settled_fit
from truepose.identification.fit.solver import absorbed, posterior_covariance
from truepose.identification.model.evaluation import evaluate
from truepose.identification.observations.poses import position_block
from truepose.identification.problem.build import JointPrior, build, with_belief
from truepose.kinematics.frames import rotation_from_vector
from truepose.messages.catalogue import english

EFFECTS = ("base", "geometry")
HELD = ("alpha_2", "a_2", "theta_3")
# Neither springs nor scatter of the arm: the noise of the readings is all there is.
ARM = replace(IRB_120, masses=(), repeatability_mm=0.0)
N = 60
CAMPAIGNS = 10


def campaign_of(seed=0, noise_mm=0.015, share=0.2, **changes):
    campaign = nominal_campaign(N, seed=3, robot=ARM, **changes)
    values = drawn(build(campaign, EFFECTS), seed, share)
    return measured(campaign, values, noise_mm, seed, EFFECTS)[0]


def fitted(campaign):
    problem = build(campaign, EFFECTS)
    return robust_fit(problem.structure, problem.blocks, problem.start), problem


@cache
def quiet(seed):
    """The fit of a campaign with nothing but the stated noise."""
    return fitted(campaign_of(seed))[0]


def with_orientations(campaign, rng, sigma_rad):
    """Orientations of the flange frame turned by a fixed tool and by noise."""
    problem = build(campaign, EFFECTS)
    seen = evaluate(problem.structure, problem.start, problem.blocks[0].targets).orientation
    tool = rotation_from_vector(np.array([0.4, -0.2, 1.1]))
    turned = rotation_from_vector(sigma_rad * rng.standard_normal((N, 3))) @ seen @ tool
    return replace(campaign, calibration=replace(campaign.calibration, quaternion=quaternions(turned)))


def quaternions(rotations):
    return Rotation.from_matrix(rotations).as_quat()[:, [3, 0, 1, 2]]


def test_where_nothing_is_wrong_nothing_is_flagged_and_nothing_added():
    flagged, added = 0, 0
    for seed in range(CAMPAIGNS):
        fit = quiet(seed)
        flagged += int(fit.gross[0].sum())
        added += fit.blocks[0].discrepancy > 0.0

    # one campaign in a hundred may lose a reading, one in a thousand be found too noisy
    assert flagged <= 1
    assert added == 0


def test_a_parameter_that_its_prior_holds_absorbs_no_reading():
    fit = quiet(0)
    jacobian = fit.solution.final.jacobian
    free, held = np.full(len(jacobian), 1e-12), np.full(len(jacobian), 1e-12)
    held[:5] = 1e16  # in 1/mm2 or 1/rad2: known far better than from readings

    every = absorbed(jacobian, posterior_covariance(jacobian, free))
    rest = absorbed(jacobian, posterior_covariance(jacobian, held))

    assert every == pytest.approx(len(jacobian), abs=1e-4)
    assert rest == pytest.approx(len(jacobian) - 5, abs=0.02)


def test_chi_square_per_degree_of_freedom_is_one_where_the_noise_is_as_stated():
    ratios = [quiet(seed).chi2_per_dof for seed in range(CAMPAIGNS)]

    degrees = CAMPAIGNS * (3 * N - 26)
    # the mean of all campaigns, four standard deviations of its chi-square distribution
    assert np.mean(ratios) == pytest.approx(1.0, abs=4.0 * np.sqrt(2.0 / degrees))


@pytest.mark.parametrize("times", [2.0, 5.0])
def test_noise_beyond_what_is_stated_comes_back_as_discrepancy(times):
    fit, _ = fitted(campaign_of(noise_mm=times * 0.015))

    degrees = 3 * N - 26
    low, high = np.sqrt(gammaincinv(degrees / 2.0, [1e-4, 1.0 - 1e-4]) / (degrees / 2.0))
    found = np.hypot(fit.blocks[0].discrepancy, 0.015)
    assert times * 0.015 * low < found < times * 0.015 * high
    assert not fit.gross[0].any()


def test_uncertainties_grow_with_the_discrepancy():
    stated = quiet(0)
    loud, _ = fitted(campaign_of(noise_mm=0.075))

    ratio = np.sqrt(np.diag(loud.solution.covariance) / np.diag(stated.solution.covariance))
    # five times the noise; what priors hold grows less
    assert np.median(ratio) == pytest.approx(5.0, rel=0.25)


def test_priors_are_as_stated_where_the_errors_are_usual():
    fit, problem = fitted(campaign_of(share=0.3))

    assert fit.structure.prior_widths == pytest.approx(problem.structure.prior_widths)


def test_priors_of_the_geometry_widen_together_where_the_data_ask_for_it():
    fit, problem = fitted(campaign_of(share=4.0))

    ratio = fit.structure.prior_widths / problem.structure.prior_widths
    geometric = np.array([owner in effects_with(Trait.GEOMETRY) for owner in fit.structure.owners])
    assert np.ptp(ratio[geometric]) < 1e-9
    # 19 draws of width 4 know their own width to 16 %, three times that
    assert ratio[geometric][0] == pytest.approx(4.0, rel=0.5)
    assert ratio[~geometric] == pytest.approx(1.0)


def test_widths_that_a_belief_counts_on_stay_as_stated_and_others_widen():
    problem = build(campaign_of(share=4.0), EFFECTS)
    known = [at for at, name in enumerate(problem.structure.names) if name in HELD]
    specs = tuple(problem.structure.specs[at] for at in known)
    widths = np.array([spec.prior_width for spec in specs])
    belief = JointPrior(specs, ("geometry",) * len(specs), np.zeros(len(specs)), np.diag((0.7 * widths) ** 2))
    told = with_belief(problem, belief)

    fit = robust_fit(told.structure, told.blocks, told.start)

    ratio = fit.structure.prior_widths / problem.structure.prior_widths
    geometric = np.array([owner in effects_with(Trait.GEOMETRY) for owner in fit.structure.owners])
    others = geometric & ~np.isin(np.arange(len(ratio)), known)
    assert ratio[known] == pytest.approx(1.0)
    assert ratio[others] == pytest.approx(ratio[others][0])
    assert ratio[others][0] > 2.0


def test_gross_readings_are_flagged_and_no_others():
    fit, _ = fitted(shifted(campaign_of(), [4, 31], np.array([0.0, 0.3, 0.1])))

    assert np.flatnonzero(fit.gross[0]).tolist() == [4, 31]
    assert fit.blocks[0].discrepancy == 0.0


def test_noise_along_one_axis_alone_is_no_reason_to_flag():
    """A needle of an uncertainty has a heavier tail than a ball of the same size: 1 % of its readings lie
    beyond what one ball in five thousand does."""
    flagged = 0
    for seed in range(8):
        campaign = campaign_of(seed, noise_mm=0.0)
        points, rng = campaign.calibration, np.random.default_rng(50 + seed)
        axis = np.linalg.qr(rng.standard_normal((N, 3, 3)))[0][:, :, 0]
        noise = axis * 0.2 * rng.standard_normal((N, 1)) + 0.002 * rng.standard_normal((N, 3))
        covariance = 0.04 * axis[:, :, None] * axis[:, None, :] + 0.002**2 * np.eye(3)
        needles = replace(points, position_mm=points.position_mm + noise, covariance_mm2=covariance)
        fit, _ = fitted(replace(campaign, calibration=needles))
        flagged += int(fit.gross[0].sum())

    assert flagged <= 1  # one campaign in a hundred may lose one; 480 readings would lose five otherwise


def test_orientations_that_state_no_uncertainty_are_weighed_by_their_own_scatter():
    oriented = with_orientations(campaign_of(share=0.0), np.random.default_rng(2), 2e-3)

    problem = build(oriented, ("base", "tool", "geometry"))
    fit = robust_fit(problem.structure, problem.blocks, problem.start)

    # 180 components know it to 5 %, three times that and the parameters' share
    assert fit.blocks[1].discrepancy == pytest.approx(2e-3, rel=0.2)


def test_orientations_of_which_some_state_no_uncertainty_are_all_used():
    oriented = with_orientations(campaign_of(share=0.0), np.random.default_rng(2), 1e-3)
    stated = np.where(np.arange(N) % 2, 1e-3, np.nan)
    mixed = replace(oriented, calibration=replace(oriented.calibration, rotation_uncertainty_rad=stated))

    problem = build(mixed, ("base", "tool", "geometry"))
    fit = robust_fit(problem.structure, problem.blocks, problem.start)

    assert fit.solution.converged
    assert fit.blocks[1].component_variance() == pytest.approx(1e-6, rel=0.2)


def test_a_reading_off_in_place_and_turn_is_one_reading_wherever_it_is_counted():
    oriented = with_orientations(campaign_of(share=0.0), np.random.default_rng(2), 1e-3)
    points = oriented.calibration
    place, quaternion = points.position_mm.copy(), points.quaternion.copy()
    place[7] += 5.0
    quaternion[[7, 21]] = quaternion[[21, 7]]
    spoilt = replace(oriented, calibration=replace(points, position_mm=place, quaternion=quaternion))

    answer = identify(spoilt, ("base", "tool", "geometry"))

    assert len(answer.outliers) == 3
    assert answer.counts.outliers == answer.model.identified_from["readings_without_weight"] == 2
    assert "2 readings without weight" in english(answer.message)


def test_a_model_without_parameters_is_judged_as_it_stands():
    problem = build(campaign_of(), EFFECTS)
    structure = problem.structure.without(problem.structure.effects)
    exact = evaluate(structure, np.zeros(0), problem.blocks[0].targets).position_mm
    block = replace(problem.blocks[0], measured_mm=exact + np.array([0.0, 0.0, 5.0]))

    near = robust_fit(structure, (replace(block, measured_mm=exact),), np.zeros(0))
    off = robust_fit(structure, (block,), np.zeros(0))

    assert near.values.shape == (0,)
    assert near.blocks[0].discrepancy == 0.0
    assert not off.gross[0].any()  # all are off alike: it is the model
    assert off.blocks[0].discrepancy == pytest.approx(5.0 / np.sqrt(3.0), rel=0.01)


def test_a_reading_that_was_once_left_out_comes_back_where_the_others_hardly_foretell_it():
    """35 parameters from 39 readings: each reading alone decides on something."""
    problem = build(contact_campaign(TargetKind.SPHERE, n=13, noise_mm=0.01), ("geometry",))
    (block,) = problem.blocks

    for row in range(0, 39, 6):
        without = block.weighted(np.where(np.arange(39) == row, 0.0, 1.0), 0.0)
        fit = settled_fit(problem.structure, (without,), problem.start)
        assert not fit.gross[0].any(), row


def test_a_reading_that_the_others_foretell_stays_out():
    campaign = contact_campaign(TargetKind.SPHERE, n=60, noise_mm=0.01)
    spoilt = campaign.contacts.reading_mm.copy()
    spoilt[7] += 0.3
    campaign = replace(campaign, contacts=replace(campaign.contacts, reading_mm=spoilt))
    problem = build(campaign, ("geometry",))

    fit = robust_fit(problem.structure, problem.blocks, problem.start)

    assert np.flatnonzero(fit.gross[0]).tolist() == [7]


@pytest.mark.parametrize(("stated_mm", "excess_mm"), [(0.03, 0.04), (0.05, 0.0), (0.08, 0.0)])
def test_what_readings_scatter_beyond_what_they_state_is_searched_with(stated_mm, excess_mm):
    n = 9
    points = PointReadings(
        Stops(np.arange(n), np.zeros((n, 6))), np.ones(n, int), np.zeros((n, 3)), np.full(n, stated_mm)
    )
    length = 0.05 * np.sqrt(chi2_median(3))
    residual = np.tile([0.0, 0.0, length], (n, 1))
    residual[0] *= 1000.0  # one gross reading does not count among nine

    soft = _softly(position_block(points, 0.0), SimpleNamespace(residual=residual))

    assert soft.discrepancy == pytest.approx(excess_mm, abs=1e-9)
    assert soft.weights[0] < 1e-4 < 0.1 < soft.weights[1:].min()
