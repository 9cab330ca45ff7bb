"""Rounded joint angles: told where their steps explain the noise, and only there."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.diagnosis.selections import PRESENT, left_of, make_selected, make_start, planted, started
from tests.helpers.identification.synthetic import NOISE_MM, configurations, leg_campaign, with_joints
from truepose.diagnosis.angle_steps import step_of
from truepose.diagnosis.sentences import remaining_sentence
from truepose.messages.catalogue import english

N = 100


def in_steps(joints_rad, step_deg):
    return np.deg2rad(np.round(np.round(np.rad2deg(joints_rad) / step_deg) * step_deg, 9))


def written_in_steps(campaign, step_deg):
    """The campaign as a file tells it that has few digits: the arm stood elsewhere."""
    return with_joints(campaign, in_steps(campaign.calibration.stops.joints_rad, step_deg))


def left_beside(campaign, effects=PRESENT):
    start = started(campaign, effects)
    return left_of(start, make_selected(start, ()))


@pytest.mark.parametrize(
    ("step_deg", "written_deg"), [(0.1, 0.1), (0.02, 0.02), (0.001, 0.001), (0.05, 0.05), (1.0, 1.0)]
)
def test_the_coarsest_step_of_all_angles_is_found(step_deg, written_deg):
    joints_deg = np.rad2deg(in_steps(configurations(20), step_deg))

    assert step_of(joints_deg) == written_deg


def test_angles_with_all_their_digits_have_no_step():
    assert step_of(np.rad2deg(configurations(20))) is None


def test_one_angle_between_the_steps_is_enough():
    joints_deg = np.round(np.rad2deg(configurations(20)), 1)
    joints_deg[3, 2] += 0.01

    assert step_of(joints_deg) == 0.01


def test_a_few_whole_angles_are_no_step():
    assert step_of(np.zeros((50, 6)) + np.arange(50)[:, None] % 4) is None


@pytest.mark.parametrize("step_deg", [0.1, 0.02])
def test_angles_that_were_rounded_scatter_the_tool_as_far_as_it_is_said(step_deg):
    exact = planted({}, campaign=telling_campaign(N), n=N)

    left = left_beside(written_in_steps(exact, step_deg))

    assert left.steps.step_deg == step_deg
    # Uniform within a step about six joints; levers are the arm's.
    moved = planted({}, campaign=written_in_steps(telling_campaign(N), step_deg), n=N, noise_mm=0.0)
    still = planted({}, campaign=telling_campaign(N), n=N, noise_mm=0.0)
    off_mm = np.linalg.norm(moved.calibration.position_mm - still.calibration.position_mm, axis=1)
    assert left.steps.scatter_mm == pytest.approx(np.sqrt(np.mean(off_mm**2)), rel=0.2)
    assert not left.structure
    sentence = english(remaining_sentence(left, full=False))
    assert f"rounded to steps of {step_deg:g} deg, which alone scatters the tool by " in sentence


def test_points_weigh_by_what_the_steps_do_to_them():
    exact = planted({}, campaign=telling_campaign(N), n=N)
    campaign = replace(exact, validation=exact.calibration)

    start = started(written_in_steps(campaign, 0.1))

    left = left_of(start, make_selected(start, ()))
    assert left.noise_scale == pytest.approx(1.0, abs=0.2)  # of 100 medians, four standard deviations
    variance = np.trace(start.campaign.calibration.covariance_mm2, axis1=1, axis2=2)
    added = variance - 3.0 * NOISE_MM**2
    assert np.sqrt(added.mean()) == pytest.approx(start.steps.scatter_mm, rel=1e-2)
    assert start.campaign.validation is campaign.validation  # written with all its digits


def test_points_that_are_as_stated_keep_their_weights():
    planned = planted({}, campaign=telling_campaign(N, joints_rad=in_steps(configurations(N), 0.1)), n=N)

    start = started(planned)

    assert start.steps is None
    assert start.campaign is planned


def test_lengths_are_scattered_too():
    exact = leg_campaign(150)
    stops = exact.legs.stops
    written = replace(stops, joints_rad=in_steps(stops.joints_rad, 0.1))

    left = left_beside(replace(exact, legs=replace(exact.legs, stops=written)), ("tool", "joint_offset"))

    assert left.steps.step_deg == 0.1
    assert "which alone scatters the lengths by " in english(remaining_sentence(left, full=False))


@pytest.mark.parametrize("noise", [1.0, 2.0, 4.0])
@pytest.mark.parametrize("step_deg", [1.0, 0.01])
def test_a_plan_in_whole_steps_to_which_the_arm_goes_exactly_is_not_blamed(step_deg, noise):
    planned = telling_campaign(N, joints_rad=in_steps(configurations(N), step_deg))

    left = left_of(
        start := make_start({}, campaign=planned, noise_mm=noise * NOISE_MM), make_selected(start, ())
    )

    assert left.more_than_stated == (noise > 1.0)
    assert left.steps is None


def test_steps_too_fine_to_matter_are_not_blamed_for_noise():
    noisy = planted({}, campaign=telling_campaign(N), n=N, noise_mm=2.0 * NOISE_MM)

    left = left_beside(written_in_steps(noisy, 0.001))

    assert left.more_than_stated
    assert left.steps is None
    assert left.structure


def test_errors_far_beyond_what_steps_scatter_stay_errors():
    exact = planted({}, campaign=telling_campaign(N), n=N)
    left = left_beside(written_in_steps(exact, 0.1))

    assert not replace(left, worse_unseen=left.noise_scale).structure
    assert replace(left, worse_unseen=2.0 * left.noise_scale).structure
