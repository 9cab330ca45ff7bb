"""Places to measure next stay within what was measured and within the limits, and fill gaps."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.diagnosis.selections import make_selected, make_start, planted
from tests.helpers.domain.robots import IRB_120
from truepose.diagnosis.configurations import (
    draw_configurations,
    filling,
    joint_limits,
    measured_ranges,
    moved_alone,
    one_period,
)
from truepose.domain.robot import JointRange
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.gravity import gravity_torques

LIMIT_RAD = 0.5
LIMITS = tuple(JointRange(-LIMIT_RAD, LIMIT_RAD) for _ in range(6))


@pytest.fixture(scope="module")
def start():
    return make_start({})


def _limited(start):
    return replace(start, campaign=replace(start.campaign, robot=replace(IRB_120, joint_limits=LIMITS)))


def test_places_lie_within_the_measured_ranges_in_whole_hundredths(start):
    joints_deg = np.rad2deg(start.scene.stops.joints_rad)

    places = draw_configurations(
        start, make_selected(start, []), measured_ranges(start), 200, np.random.default_rng(0)
    )

    assert (places.joints_deg >= joints_deg.min(axis=0)).all()
    assert (places.joints_deg <= joints_deg.max(axis=0)).all()
    assert places.joints_deg == pytest.approx(np.round(places.joints_deg, 2), abs=1e-12)


def test_limits_narrow_the_measured_ranges(start):
    ranges = measured_ranges(_limited(start))

    assert (ranges.low_deg >= -np.rad2deg(LIMIT_RAD)).all()
    assert (ranges.high_deg <= np.rad2deg(LIMIT_RAD)).all()


def test_rounding_does_not_leave_the_limits(start):
    limits = joint_limits(_limited(start))  # 28.6479 deg: the next hundredth is outside

    rounded = limits.rounded(np.full((1, 6), 28.6479))

    assert rounded == pytest.approx(np.full((1, 6), 28.64), abs=1e-9)


def test_a_joint_that_never_moved_stays_where_it_was():
    campaign = telling_campaign(40)
    stops = campaign.calibration.stops
    joints = stops.joints_rad.copy()
    joints[:, 2] = np.deg2rad(12.3456)
    campaign = replace(
        campaign, calibration=replace(campaign.calibration, stops=replace(stops, joints_rad=joints))
    )
    start = make_start({}, campaign=campaign)

    places = draw_configurations(
        start, make_selected(start, []), measured_ranges(start), 5, np.random.default_rng(0)
    )

    assert places.joints_deg[:, 2] == pytest.approx(np.full(5, 12.3456), abs=1e-9)


def test_the_same_seed_draws_the_same_places(start):
    first, second = (moved_alone(start, 3, 10, np.random.default_rng(4)) for _ in range(2))

    assert np.array_equal(first, second)


def test_all_else_is_as_at_the_last_reading_in_whichever_order_they_are_listed():
    campaign = telling_campaign(24)
    listed = campaign.calibration.stops.taken(np.arange(24)[::-1])
    start = make_start({})
    start = replace(start, scene=replace(start.scene, stops=listed))

    stops = draw_configurations(
        start, make_selected(start, []), measured_ranges(start), 3, np.random.default_rng(4)
    ).state.targets.stops

    assert set(stops.time_s) == {campaign.calibration.stops.time_s[-1]}
    assert set(stops.temperature_c) == {campaign.calibration.stops.temperature_c[-1]}
    assert set(stops.attachment) == {campaign.calibration.stops.attachment[-1]}


def test_gaps_are_filled_the_largest_first():
    measured = np.array([[0.0], [1.0], [2.0], [9.0], [10.0], [14.0]])
    places = np.linspace(0.0, 14.0, 141)[:, None]

    chosen = places[filling(places, measured, 2), 0]

    # From 2 to 9 and from 10 to 14: the middles, 5.5 and 12.
    assert chosen == pytest.approx([5.5, 12.0], abs=0.051)


def test_a_joint_is_moved_alone(start):
    measured = np.rad2deg(start.scene.stops.joints_rad)

    alone = moved_alone(start, 3, 50, np.random.default_rng(0))

    others = [0, 1, 2, 4, 5]
    apart = np.abs(alone[:, None, others] - measured[None, :, others]).max(axis=2).min(axis=1)
    assert (apart <= 0.01).all()  # rounded to whole hundredths, inwards at the ends of a range
    assert np.ptp(alone[:, 3]) > 0.5 * np.ptp(measured[:, 3])


def test_a_fast_wave_is_stepped_through_one_period(start):
    steps = one_period(start, 5, 100.0, 5)

    # Five steps of a fifth of 3.6 deg, each rounded by 0.005 deg at most.
    assert np.diff(steps[:, 5]) == pytest.approx(np.full(4, 0.72), abs=0.011)
    assert np.ptp(steps[:, :5], axis=0) == pytest.approx(np.zeros(5), abs=1e-12)


def test_measured_torques_are_foretold_where_nothing_was_measured():
    campaign = telling_campaign(60)
    stops = campaign.calibration.stops
    chain = forward(nominal_values(IRB_120, stops.joints_rad), np.eye(3), np.zeros(3))
    zeros = np.array([300.0, -200.0, 100.0, 50.0, 0.0, 20.0])  # of the sensors [N mm]
    torque = gravity_torques(chain, IRB_120.masses, np.array([0.0, 0.0, -9.81])) + zeros
    told = replace(campaign.calibration, stops=replace(stops, torque_n_mm=torque))
    start = make_start({}, campaign=planted({}, campaign=replace(campaign, calibration=told)))

    places = draw_configurations(
        start, make_selected(start, []), measured_ranges(start), 20, np.random.default_rng(0)
    )

    there = forward(nominal_values(IRB_120, np.deg2rad(places.joints_deg)), np.eye(3), np.zeros(3))
    expected = gravity_torques(there, IRB_120.masses, np.array([0.0, 0.0, -9.81])) + zeros
    # The torques are linear in moments and zeros: only rounding, and the truncation at 1e-6, is left.
    assert start.fit.structure.torques_measured
    assert places.torque_n_mm == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())
