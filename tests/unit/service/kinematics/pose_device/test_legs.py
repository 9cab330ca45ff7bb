import numpy as np
import pytest

from tests.helpers.ballbar.pose_device import ALL_LEGS, CUPS, FOUR_CUPS, MEASURABLE, NESTS, lengths
from truepose.kinematics.frames import rotation_from_vector
from truepose.kinematics.pose_device import Fixtures, Pose, foreseen, linear_legs
from truepose.validation.connection_check import judge_pose

READINGS = {"reading_u_mm": 0.00051, "zero_u_mm": 0.0015, "range_mm": 1.0}


def moved(pose, step):
    return Pose(rotation_from_vector(step[3:]) @ pose.rotation, pose.origin_mm + step[:3])


@pytest.mark.parametrize("assembly", MEASURABLE[::8])
def test_the_gradient_of_the_legs_agrees_with_central_differences(assembly):
    steps = np.diag([1e-3] * 3 + [1e-5] * 3)

    linear = linear_legs(Fixtures(CUPS, NESTS), ALL_LEGS, assembly.pose)

    differences = [
        (lengths(moved(assembly.pose, step), ALL_LEGS) - lengths(moved(assembly.pose, -step), ALL_LEGS))
        / (2.0 * step.max())
        for step in steps
    ]
    assert linear.length_mm == pytest.approx(lengths(assembly.pose, ALL_LEGS))
    # rounding of 1e-13 over a step of 2e-5 rad
    assert linear.gradient == pytest.approx(np.transpose(differences), abs=1e-6)


def test_exact_fixtures_add_no_uncertainty():
    linear = linear_legs(Fixtures(CUPS, NESTS), ALL_LEGS, MEASURABLE[0].pose)

    assert not linear.fixtures_covariance_mm2.any()


def test_a_nest_in_its_cup_has_a_leg_of_no_length_and_spoils_no_other():
    pose = Pose(np.eye(3), CUPS[0] - NESTS[0])
    uncertain = Fixtures(CUPS, NESTS, 1e-4 * np.eye(9), 1e-4 * np.eye(9))

    linear = linear_legs(uncertain, ((1, 1), (2, 1)), pose)

    assert linear.length_mm == pytest.approx([0.0, np.linalg.norm(CUPS[1] - CUPS[0])])
    assert not linear.gradient[0].any()
    assert linear.fixtures_covariance_mm2 == pytest.approx(np.diag([0.0, 2e-4]))


def test_the_stated_covariance_is_how_lengths_scatter_when_pose_and_fixtures_do():
    rng = np.random.default_rng(3)
    pose = MEASURABLE[4].pose
    pose_u = np.array([0.05, 0.02, 0.04, 2e-4, 1e-4, 3e-4])
    cups_u, nests_u = 0.03, 0.02

    stated = foreseen(
        3, Fixtures(CUPS, NESTS, cups_u**2 * np.eye(9), nests_u**2 * np.eye(9)), pose, np.diag(pose_u**2)
    )

    drawn = [
        lengths(
            moved(pose, pose_u * rng.normal(size=6)),
            ALL_LEGS,
            CUPS + cups_u * rng.normal(size=(3, 3)),
            NESTS + nests_u * rng.normal(size=(3, 3)),
        )
        for _ in range(3000)
    ]
    covariance = np.array(stated.covariance_mm2)
    white = np.linalg.solve(np.linalg.cholesky(covariance), (np.array(drawn) - stated.length_mm).T)
    assert (stated.config, stated.legs) == (3, ALL_LEGS)
    # 3,000 draws: a variance to 2.6 %, a correlation to 0.018
    assert np.cov(white) == pytest.approx(np.eye(9), abs=0.1)


def test_every_pair_of_four_cups_is_foreseen():
    stated = foreseen(1, Fixtures(FOUR_CUPS, NESTS), MEASURABLE[0].pose, np.eye(6))

    assert len(stated.legs) == len(set(stated.legs)) == 12


def test_nine_legs_tell_exchanged_ones_without_any_model_of_the_robot():
    # commanded to 2 mm and 10 mrad only: six unknowns, nine lengths, three of them check the others
    commanded = MEASURABLE[4].pose
    attained = moved(commanded, np.array([1.5, -2.0, 1.0, 0.004, -0.008, 0.006]))
    stated = foreseen(1, Fixtures(CUPS, NESTS), commanded, np.diag([4.0] * 3 + [1e-4] * 3))
    right = dict(zip(ALL_LEGS, lengths(attained, ALL_LEGS), strict=True))
    first, second = sorted(right, key=right.get)[3:5]  # in the middle, tenths of a millimetre apart

    suspicions = judge_pose(right | {first: right[second], second: right[first]}, stated, **READINGS)

    assert abs(right[first] - right[second]) < 3.0
    assert judge_pose(right, stated, **READINGS) == ()
    assert {(one.asked, one.suspected) for one in suspicions} == {(first, second), (second, first)}


def test_six_legs_at_a_pose_that_is_commanded_to_2_mm_only_cannot_tell():
    assembly = MEASURABLE[4]
    stated = foreseen(1, Fixtures(CUPS, NESTS), assembly.pose, np.diag([4.0] * 3 + [1e-4] * 3))
    exchanged = dict(zip(assembly.legs, (300.5, 299.5, 300.1, 300.2, 299.9, 299.7), strict=True))

    assert judge_pose(exchanged, stated, **READINGS) == ()
