from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.ballbar.pose_device import (
    ALL_LEGS,
    CUPS,
    FOUR_CUPS,
    MEASURABLE,
    NESTS,
    SIGMA_MM,
    lengths,
)
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.kinematics.frames import rotation_from_vector, vector_from_rotation
from truepose.kinematics.pose_device import (
    Fixtures,
    Pose,
    assemblies,
    fitting_poses,
    least_squares_pose,
    measurable,
)

FIXTURES = Fixtures(CUPS, NESTS)
OCTAHEDRON = ((1, 1), (1, 2), (2, 2), (2, 3), (3, 3), (3, 1))
TWELVE_LEGS = tuple((cup, nest) for cup in (1, 2, 3, 4) for nest in (1, 2, 3))


def covariance(legs, sigma=SIGMA_MM):
    return sigma**2 * np.eye(len(legs))


def off(pose, rng, shift_mm=1.0, turn_rad=0.003):
    turn = rotation_from_vector(turn_rad * rng.normal(size=3))
    return Pose(turn @ pose.rotation, pose.origin_mm + shift_mm * rng.normal(size=3))


def error(found, true):
    turn = vector_from_rotation(found.rotation @ true.rotation.T)
    return np.concatenate([found.origin_mm - true.origin_mm, turn])


@settings(max_examples=30, deadline=None)
@given(st.sampled_from(MEASURABLE), st.integers(0, 2**32 - 1))
def test_six_exact_legs_give_the_pose_next_to_the_commanded_one(assembly, seed):
    rng = np.random.default_rng(seed)
    attained = off(assembly.pose, rng)

    length_mm = lengths(attained, assembly.legs)
    found = least_squares_pose(
        FIXTURES, assembly.legs, length_mm, covariance(assembly.legs), commanded=assembly.pose
    )

    assert found.pose.matrix == pytest.approx(attained.matrix, abs=1e-8)
    assert found.degrees_of_freedom == 0
    assert found.residual_mm == pytest.approx(np.zeros(6), abs=1e-9)


def test_all_nine_legs_need_no_commanded_pose():
    true = MEASURABLE[20].pose

    found = least_squares_pose(FIXTURES, ALL_LEGS, lengths(true, ALL_LEGS), covariance(ALL_LEGS))

    assert found.pose.matrix == pytest.approx(true.matrix, abs=1e-8)


def test_twelve_legs_from_four_cups_have_one_solution_only():
    fixtures = Fixtures(FOUR_CUPS, NESTS)
    for assembly in measurable(assemblies(FOUR_CUPS, NESTS), FOUR_CUPS, NESTS)[::24]:
        length_mm = lengths(assembly.pose, TWELVE_LEGS, FOUR_CUPS)

        found = least_squares_pose(fixtures, TWELVE_LEGS, length_mm, covariance(TWELVE_LEGS))

        assert found.pose.matrix == pytest.approx(assembly.pose.matrix, abs=1e-8)


def test_six_legs_on_any_three_of_four_cups_are_solved():
    fixtures = Fixtures(FOUR_CUPS, NESTS)
    for assembly in assemblies(FOUR_CUPS, NESTS)[::7]:
        length_mm = lengths(assembly.pose, assembly.legs, FOUR_CUPS)

        found = least_squares_pose(
            fixtures, assembly.legs, length_mm, covariance(assembly.legs), commanded=assembly.pose
        )

        assert found.pose.matrix == pytest.approx(assembly.pose.matrix, abs=1e-8)


@pytest.mark.parametrize(
    "legs",
    [
        OCTAHEDRON,
        ((1, 1), (1, 2), (1, 3), (2, 1), (2, 2), (3, 3)),
        ((1, 1), (2, 1), (2, 2), (3, 2), (3, 3), (2, 3)),
    ],
    ids=["two legs at each cup and nest", "three at one cup", "two at each nest"],
)
def test_legs_that_form_no_design_are_solved_too(legs):
    rng = np.random.default_rng(5)
    for assembly in MEASURABLE[::9]:
        attained = off(assembly.pose, rng, 5.0, 0.05)
        length_mm = lengths(attained, legs)

        found = fitting_poses(FIXTURES, legs, length_mm, covariance(legs))

        nearest = min(np.abs(one.pose.matrix - attained.matrix).max() for one in found)
        assert nearest < 1e-7


def test_the_solutions_of_six_legs_are_those_of_the_cascade_above_and_mirrored_below():
    assembly = MEASURABLE[3]
    same = [one for one in assemblies(CUPS, NESTS) if one.design == assembly.design]

    found = fitting_poses(FIXTURES, assembly.legs, np.full(6, 300.0), covariance(assembly.legs))

    heights = sorted(one.pose.points(NESTS)[:, 2].mean() for one in found)
    above = sorted(one.points_mm[:, 2].mean() for one in same)
    assert len(found) == 8
    assert heights[4:] == pytest.approx(above, abs=2e-3)  # the nests are given to 1 um
    assert heights[3::-1] == pytest.approx([-height for height in above], abs=2e-3)


def test_uncertain_cups_weigh_as_if_they_were_fitted_with_their_priors():
    # the same problem with all 9 cup coordinates as parameters, by another library
    from scipy.optimize import least_squares

    rng = np.random.default_rng(2)
    cups_u = 0.05
    true = MEASURABLE[0].pose
    length_mm = lengths(true, ALL_LEGS, CUPS + cups_u * rng.normal(size=(3, 3)))

    def misfit(values):
        pose = Pose(rotation_from_vector(values[3:6]) @ true.rotation, true.origin_mm + values[:3])
        cups = CUPS + values[6:].reshape(3, 3)
        return np.append((length_mm - lengths(pose, ALL_LEGS, cups)) / SIGMA_MM, values[6:] / cups_u)

    together = least_squares(misfit, np.zeros(15), x_scale="jac", xtol=1e-14, ftol=1e-14, gtol=1e-14)
    found = least_squares_pose(
        Fixtures(CUPS, NESTS, cups_u**2 * np.eye(9)),
        ALL_LEGS,
        length_mm,
        covariance(ALL_LEGS),
        commanded=true,
    )

    # second order in 0.05 mm over 300 mm is 1e-5 mm: a thousandth of the uncertainty
    assert error(found.pose, true) == pytest.approx(together.x[:6], abs=5e-5)
    assert found.chi2 == pytest.approx(2.0 * together.cost, rel=1e-2)
    spread = np.sqrt(np.diag(np.linalg.inv(together.jac.T @ together.jac))[:6])
    assert np.sqrt(np.diag(found.covariance)) == pytest.approx(spread, rel=1e-2)


def test_a_wrong_leg_among_nine_shows_in_chi2():
    true = MEASURABLE[10].pose
    length_mm = lengths(true, ALL_LEGS)
    length_mm[4] += 0.1

    found = least_squares_pose(FIXTURES, ALL_LEGS, length_mm, covariance(ALL_LEGS), commanded=true)

    assert found.chi2 > 1000.0  # a tenth of a millimetre is 200 standard uncertainties
    assert found.pose.origin_mm == pytest.approx(true.origin_mm, abs=0.5)


def test_a_leg_that_was_read_twice_counts_twice():
    true, legs = MEASURABLE[10].pose, (*MEASURABLE[10].legs, MEASURABLE[10].legs[0])
    once = least_squares_pose(
        FIXTURES, legs[:6], lengths(true, legs[:6]), covariance(legs[:6]), commanded=true
    )

    twice = least_squares_pose(FIXTURES, legs, lengths(true, legs), covariance(legs), commanded=true)

    assert twice.degrees_of_freedom == 1
    assert np.trace(twice.covariance) < np.trace(once.covariance)


def test_the_frame_of_the_cups_is_free():
    turn, shift = rotation_from_vector(np.array([0.4, -1.0, 2.0])), np.array([500.0, -200.0, 700.0])
    assembly = MEASURABLE[7]
    moved = Pose(turn @ assembly.pose.rotation, turn @ assembly.pose.origin_mm + shift)
    cups = CUPS @ turn.T + shift

    found = least_squares_pose(
        Fixtures(cups, NESTS), ALL_LEGS, lengths(moved, ALL_LEGS, cups), covariance(ALL_LEGS)
    )

    assert found.pose.matrix == pytest.approx(moved.matrix, abs=1e-8)


def test_six_legs_without_a_commanded_pose_are_refused_since_several_poses_have_them():
    legs = MEASURABLE[0].legs

    with pytest.raises(ConfigurationError, match="consistent with 4 poses"):
        least_squares_pose(FIXTURES, legs, np.full(6, 300.0), covariance(legs))


def test_five_legs_are_refused_even_if_one_was_read_twice():
    legs = (*MEASURABLE[0].legs[:5], MEASURABLE[0].legs[0])

    with pytest.raises(UnderdeterminedError, match="5 different legs"):
        least_squares_pose(FIXTURES, legs, np.full(6, 300.0), covariance(legs))


def test_legs_that_do_not_meet_are_refused():
    legs = MEASURABLE[0].legs
    length_mm = np.array([300.0, 300.0, 300.0, 20.0, 300.0, 300.0])

    with pytest.raises(ConfigurationError, match="No pose"):
        least_squares_pose(FIXTURES, legs, length_mm, covariance(legs))


@pytest.mark.parametrize("exchanged", [False, True], ids=["two nests", "two cups"])
def test_legs_at_two_points_leave_the_tool_turning_and_are_refused(exchanged):
    legs = tuple((j, i) if exchanged else (i, j) for i in (1, 2, 3) for j in (1, 2))
    pose = MEASURABLE[0].pose

    with pytest.raises(UnderdeterminedError, match="do not fully constrain the tool"):
        least_squares_pose(FIXTURES, legs, lengths(pose, legs), covariance(legs), commanded=pose)


def test_a_tool_that_lies_in_the_plane_of_the_cups_is_refused():
    flat = Pose(np.eye(3), np.zeros(3))
    nests = np.array([[100.0, 80.0, 0.0], [200.0, 80.0, 0.0], [150.0, 160.0, 0.0]])
    length_mm = lengths(flat, ALL_LEGS, CUPS, nests)

    with pytest.raises((ConfigurationError, UnderdeterminedError)) as caught:
        least_squares_pose(Fixtures(CUPS, nests), ALL_LEGS, length_mm, covariance(ALL_LEGS), commanded=flat)
    assert str(caught.value).endswith(".")


def test_a_tool_whose_single_leg_is_dead_is_refused_although_another_pose_fits():
    # leg 23 through nest 3 meets the axis t1-t2: turning about it changes no length
    assembly = MEASURABLE[0]
    tool = assembly.design.tool
    points = assembly.points_mm.copy()
    t1, t2 = points[tool[0] - 1], points[tool[1] - 1]
    axis = (t2 - t1) / np.linalg.norm(t2 - t1)
    b2 = CUPS[assembly.design.base[1] - 1]
    along = (b2 - t1) - axis * ((b2 - t1) @ axis)
    third = 0.5 * (t1 + t2) + 130.0 * along / np.linalg.norm(along)
    points[tool[2] - 1] = third
    dead = Pose(np.eye(3), np.zeros(3))
    legs = assembly.legs

    with pytest.raises(UnderdeterminedError, match="do not fully constrain the tool"):
        least_squares_pose(
            Fixtures(CUPS, points), legs, lengths(dead, legs, CUPS, points), covariance(legs), commanded=dead
        )


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"legs": ((1, 1), (2, 1), (5, 1), (1, 2), (2, 2), (2, 3))}, "B5 T1"),
        ({"length_mm": np.full(5, 300.0)}, "the same number of lengths"),
        ({"length_mm": np.array([300.0, np.nan, 300.0, 300.0, 300.0, 300.0])}, "finite length"),
        ({"length_mm": np.array([300.0, -300.0, 300.0, 300.0, 300.0, 300.0])}, "length greater than 0 mm"),
        ({"covariance_mm2": np.zeros((6, 6))}, "uncertainty greater than 0 mm"),
        ({"covariance_mm2": np.eye(5)}, "covariance of that size"),
        ({"fixtures": replace(FIXTURES, cups_mm=CUPS[:2])}, "At least three cups"),
        ({"fixtures": replace(FIXTURES, nests_mm=NESTS[:2])}, "exactly three nests"),
    ],
)
def test_arguments_that_do_not_go_together_are_refused_in_a_sentence(change, sentence):
    legs = MEASURABLE[0].legs
    arguments = {
        "fixtures": FIXTURES,
        "legs": legs,
        "length_mm": np.full(6, 300.0),
        "covariance_mm2": covariance(legs),
        **change,
    }

    with pytest.raises(ConfigurationError, match=sentence):
        least_squares_pose(**arguments, commanded=MEASURABLE[0].pose)


def test_four_legs_at_one_nest_and_one_at_each_other_leave_the_tool_free():
    legs = ((1, 1), (2, 1), (3, 1), (4, 1), (1, 2), (2, 3))

    with pytest.raises(UnderdeterminedError, match="do not fully constrain the tool"):
        least_squares_pose(
            Fixtures(FOUR_CUPS, NESTS),
            legs,
            np.full(6, 300.0),
            covariance(legs),
            commanded=MEASURABLE[0].pose,
        )


def test_two_poses_that_are_both_near_the_commanded_one_are_refused():
    # nest 3 is 3 mm off the plane of cup 2 and nests 1 and 2: 3 mm off on the other side all legs are as long
    legs = ((1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (2, 3))
    t1, t2 = np.array([150.0, 86.6, 245.0]), np.array([150.0, -63.0, 252.0])
    hinge, normal = (t2 - t1) / np.linalg.norm(t2 - t1), np.cross(t1 - CUPS[1], t2 - CUPS[1])
    normal /= np.linalg.norm(normal)
    arm = np.cross(hinge, normal)
    nests = np.stack([t1, t2, 0.5 * (t1 + t2) + 130.0 * arm + 3.0 * normal])

    def turned(height_mm):
        turn = rotation_from_vector(hinge * np.arctan2(3.0 - height_mm, 130.0))
        return Pose(turn, t1 - turn @ t1)

    length_mm = lengths(turned(3.0), legs, CUPS, nests)
    fixtures, u2 = Fixtures(CUPS, nests), covariance(legs)

    with pytest.raises(ConfigurationError, match="Two poses close to the commanded one"):
        least_squares_pose(fixtures, legs, length_mm, u2, commanded=turned(4.0))
    for commanded_mm, attained_mm in ((10.0, 3.0), (-10.0, -3.0)):
        found = least_squares_pose(fixtures, legs, length_mm, u2, commanded=turned(commanded_mm))
        height_mm = normal @ (found.pose.points(nests)[2] - CUPS[1])
        assert height_mm == pytest.approx(attained_mm, abs=1e-6)
