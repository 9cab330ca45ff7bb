"""Promises of tracker sessions: against simulated calibrations, and what they say of what nobody sees."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.service.planning.test_candidates import SPACE
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import FixedNest, JointRange, Nest
from truepose.identification.fit.robust import fit
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.observations.poses import position_block
from truepose.messages.catalogue import english
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.prediction.errors import Discrepancy, mean_norms
from truepose.planning.prediction.expected_covariance import (
    TYPICAL,
    ArmKnowledge,
    PriorKnowledge,
    uniform_accuracy,
)
from truepose.planning.prediction.plan import BallbarPoses, WorkVolume
from truepose.planning.prediction.tracker import ExistingReadings, promised_session, session_plan
from truepose.planning.tracker.path_repair import pool_of
from truepose.planning.tracker.plans import plan_calibration
from truepose.planning.workspace.candidates import Candidates, draw_candidates
from truepose.planning.workspace.space import cosines_to_tracker, nominal_chain

FEW = 400  # candidates: enough for the tests, a tenth of the time
TABLE = tuple(
    FixedNest(centre, 0.002) for centre in ((600.0, -500.0, 0.0), (600.0, 500.0, 0.0), (-350.0, 500.0, 0.0))
)
READING_MM, DRAWS = 0.02, 40


def planned(n=None, space=SPACE, **given):
    return promised_session(space, n, n_candidates=FEW, **given)


@pytest.fixture(scope="module")
def plan():
    return planned()


@pytest.fixture(scope="module")
def forty():
    return planned(40)


def test_the_promise_falls_with_every_ten_more(plan):
    means = [point.mean_mm for point in plan.curve]

    assert [point.n for point in plan.curve] == [11, *range(20, 101, 10)]
    assert means == sorted(means, reverse=True)
    assert all(low < mean < high for mean, (low, high) in ((p.mean_mm, p.interval_90_mm) for p in plan.curve))
    assert all(point.worst_mm > point.mean_mm for point in plan.curve)


def test_without_a_number_the_plan_has_as_many_as_the_knee_says(plan):
    assert len(plan.joints_rad) == plan.advised == plan.promised.n
    assert plan.left_open == ()


def test_what_is_chosen_is_visible_and_within_the_ranges(plan):
    low = [limit.lower_rad for limit in SPACE.ranges]
    high = [limit.upper_rad for limit in SPACE.ranges]
    cosines = cosines_to_tracker(SPACE, nominal_chain(SPACE, plan.joints_rad))

    assert np.all((plan.joints_rad >= low) & (plan.joints_rad <= high))
    seen = cosines[plan.nest - 1, np.arange(len(plan.nest))]
    assert np.all(seen >= np.cos(np.radians(30.0)))


def test_the_same_seed_gives_the_same_plan_and_another_another(plan):
    assert np.array_equal(planned().joints_rad, plan.joints_rad)
    assert not np.array_equal(planned(seed=1).joints_rad, plan.joints_rad)


def test_a_plan_of_more_begins_with_the_plan_of_fewer(plan):
    more = {tuple(joints) for joints in planned(plan.advised + 10).joints_rad}

    assert {tuple(joints) for joints in plan.joints_rad} < more


def test_a_parameter_that_nobody_can_see_is_named():
    stiff = tuple(JointRange(0.3, 0.3) if joint == 3 else limit for joint, limit in enumerate(SPACE.ranges))

    found = planned(40, replace(SPACE, ranges=stiff))

    named = {name for group in found.left_open for name in group.parameters}
    assert {"alpha_4", "theta_5"} <= named  # about the two axes before and behind the one that stands
    assert any("joint 4 never moved" in english(group.reason) for group in found.left_open)


def test_three_configurations_leave_almost_everything_open(forty):
    found = planned(3)

    assert found.left_open
    assert found.observability == dict.fromkeys(("O1", "O2", "O3", "O4", "O5"), 0.0)
    assert found.promised.mean_mm > 10.0 * forty.promised.mean_mm


@pytest.mark.parametrize("n", [0, -3])
def test_no_configuration_at_all_cannot_be_asked_for(n):
    with pytest.raises(ConfigurationError, match="must be at least 1"):
        planned(n)


def test_lengths_are_measured_by_no_tracker_session(plan):
    of_lengths = replace(plan, nest=None, poses=BallbarPoses((), np.zeros(0, dtype=int), ()))

    with pytest.raises(ConfigurationError, match="a tracker session cannot measure them"):
        session_plan(of_lengths)


def test_where_enough_was_measured_nothing_is_left_to_choose(plan):
    measured = ExistingReadings(plan.joints_rad, plan.nest, len(plan.nest))

    found = planned(measured=measured)

    assert found.joints_rad.shape == (0, 6)
    assert found.total == found.advised == found.measured == len(plan.nest)
    assert found.promised.mean_mm == pytest.approx(plan.promised.mean_mm, rel=0.02)  # other places


def test_readings_that_are_repeated_make_observability_no_less(plan):
    n = len(plan.nest)
    once = ExistingReadings(plan.joints_rad, plan.nest, n)
    thrice = ExistingReadings(np.tile(plan.joints_rad, (3, 1)), np.tile(plan.nest, 3), n)

    of_once, of_thrice = (planned(measured=measured).observability["O1"] for measured in (once, thrice))

    assert of_thrice == pytest.approx(np.sqrt(3.0) * of_once)


def test_what_was_measured_by_chance_makes_fewer_further_ones_worth_while():
    by_chance = draw_candidates(SPACE, 20, np.random.default_rng(8))
    measured = ExistingReadings(by_chance.joints_rad, by_chance.nest, 20)

    found = planned(measured=measured)

    assert 0 < len(found.joints_rad) == found.advised - 20
    assert found.curve[0].n == 20


def test_the_curve_holds_for_the_sessions_of_the_service_too(forty):
    stops = plan_calibration(SPACE, 40, seed=2, n_candidates=FEW).stops
    first = [stop for stop in stops if stop.repeat_of is None]
    chosen = ExistingReadings(
        np.array([s.joints_rad for s in first]), np.array([s.nest for s in first]), len(first)
    )

    as_planned = planned(measured=chosen).curve[0]

    assert as_planned.n == 40
    # An exchange finds sets that are some 1 % better; the volume is sampled to another 1 %.
    assert as_planned.mean_mm == pytest.approx(forty.promised.mean_mm, rel=0.05)


def test_a_discrepancy_stays_however_much_is_measured():
    found = planned(40, knowns=PriorKnowledge(discrepancy=Discrepancy(0.09)))

    assert all(point.mean_mm > 0.09 * 2.0 * np.sqrt(2.0 / np.pi) for point in found.curve)
    assert found.assumptions.discrepancy.per_axis_mm == 0.09


def test_certified_nests_of_the_table_add_what_the_world_is_uncertain_by(forty):
    outside = planned(40, knowns=PriorKnowledge(fixed_nests=TABLE))

    assert outside.promised.mean_mm > forty.promised.mean_mm


def test_accuracy_in_a_corner_differs_from_that_over_all(forty):
    box = WorkVolume(box_mm=((350.0, 500.0), (-100.0, 100.0), (300.0, 450.0)))

    assert planned(40, volume=box).promised.mean_mm < forty.promised.mean_mm


def test_a_tracker_reads_worse_across_the_beam_and_far_away():
    beams = np.array([[1000.0, 0.0, 0.0], [0.0, 5000.0, 0.0]])

    near, far = TYPICAL.covariance_mm2(beams)

    assert near[1, 1] > near[0, 0]
    assert far[0, 0] > near[1, 1]
    assert uniform_accuracy(0.03).covariance_mm2(beams) == pytest.approx(
        np.tile(0.03**2 * np.eye(3), (2, 1, 1))
    )


def test_from_nobody_knows_where_a_tracker_reads_alike_along_all_axes():
    (covariance,) = TYPICAL.covariance_mm2(np.full((1, 3), np.nan))

    assert covariance == pytest.approx(np.eye(3) * (0.008**2 + 2 * 0.010**2) / 3.0)


def simulated_error_mm(knowledge, calibration, places, rng):
    """Return the mean true error at places of an arm drawn within the priors, once it is calibrated."""
    structure = knowledge.structure
    true = structure.prior_means + 0.3 * structure.prior_widths * rng.standard_normal(len(structure.specs))
    stops, there = (Stops(np.arange(1, len(where) + 1), where.joints_rad) for where in (calibration, places))
    sigma = np.full(len(calibration), READING_MM)
    exact = evaluate(structure, true, Targets(stops, calibration.nest)).position_mm
    scatter = knowledge.repeatability_mm * rng.standard_normal(exact.shape)
    read = exact + scatter + READING_MM * rng.standard_normal(exact.shape)
    block = position_block(PointReadings(stops, calibration.nest, read, sigma), knowledge.repeatability_mm)
    found = fit(structure, (block,), structure.prior_means).values
    asked = Targets(there, places.nest)
    error = evaluate(structure, found, asked).position_mm - evaluate(structure, true, asked).position_mm
    return float(np.linalg.norm(error, axis=1).mean())


def test_the_promise_is_what_simulated_calibrations_attain():
    rng = np.random.default_rng(6)
    calibration, places = draw_candidates(SPACE, 40, rng), draw_candidates(SPACE, 200, rng)
    exact = tuple(replace(nest, standard_uncertainty_mm=0.0) for nest in SPACE.nests)
    knowledge = ArmKnowledge(
        SPACE, calibration, PriorKnowledge(accuracy=uniform_accuracy(READING_MM), nests=exact)
    )

    told = knowledge.told(calibration.joints_rad, calibration.nest)
    errors = knowledge.errors(told, knowledge.places(places.joints_rad, places.nest))
    attained = [simulated_error_mm(knowledge, calibration, places, rng) for _ in range(DRAWS)]

    # One calibration's mean scatters by some 15 %, that of 40 by 2.5 %.
    assert mean_norms(errors, 0.0).mean() == pytest.approx(np.mean(attained), rel=0.08)


def test_what_the_registration_is_off_by_cannot_be_seen_in_readings():
    one = Candidates(np.zeros((1, 6)), np.array([1]))
    knowledge = ArmKnowledge(SPACE, one, PriorKnowledge(fixed_nests=TABLE))
    many = draw_candidates(SPACE, 2000, np.random.default_rng(1))

    told = knowledge.told(many.joints_rad, many.nest)
    errors = knowledge.errors(told, knowledge.places(many.joints_rad[:50], many.nest[:50]))

    parameters = len(knowledge.structure.specs)
    readings, held = errors[:, :, :parameters], errors[:, :, parameters:]
    assert mean_norms(readings, 0.0).mean() < mean_norms(held, 0.0).mean()


def test_fixed_nests_on_a_line_place_no_frame():
    line = tuple(FixedNest((100.0 * k, 37.0 * k - 500.0, 13.7 * k), 0.002) for k in (1.0, 2.0, 5.0))

    with pytest.raises(ConfigurationError, match="reference nests lie on one line"):
        planned(4, knowns=PriorKnowledge(fixed_nests=line))


def test_a_tracker_that_stands_in_a_fixed_nest_sees_it_equally_well_along_all_axes():
    there = (replace(TABLE[0], centre_mm=SPACE.tracker_position_mm), *TABLE[1:])

    plan = planned(20, knowns=PriorKnowledge(fixed_nests=there))

    assert 0.0 < plan.promised.mean_mm < plan.promised.worst_mm < 1.0


def test_however_exact_readings_are_what_they_do_not_show_stays_as_unknown_as_it_was():
    exact = replace(SPACE, robot=replace(SPACE.robot, repeatability_mm=0.0))

    usual, *more_exact = (
        planned(4, space=exact, knowns=PriorKnowledge(accuracy=uniform_accuracy(reading_mm))).promised.mean_mm
        for reading_mm in (1e-3, 1e-6, 1e-9, 0.0)
    )

    assert more_exact == pytest.approx([usual] * 3, rel=1e-4)


def test_where_every_configuration_that_is_seen_touches_the_arm_nothing_is_planned():
    inwards = replace(SPACE, nests=(Nest((0.0, 0.0, -320.0)),), tracker_position_mm=None)
    seen = draw_candidates(inwards, 200, np.random.default_rng(1)).joints_rad
    touching = seen[~pool_of(inwards, seen).stand(np.arange(len(seen)), 0.0)][0]
    there = tuple(JointRange(angle - 1e-3, angle + 1e-3) for angle in touching.tolist())

    for n in (None, 4):
        with pytest.raises(
            TooFewCandidatesError, match=r"None of the .* leaves enough clearance for arm and tool"
        ):
            planned(n, space=replace(inwards, ranges=there))
