from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.ballbar.pose_device import CUPS, FOUR_CUPS, NESTS
from tests.helpers.reference import reference
from truepose.domain.errors import ConfigurationError, UnderdeterminedError
from truepose.kinematics.frames import vector_from_rotation
from truepose.kinematics.pose_device import (
    DESIGNS,
    base_triangle,
    designs,
    fourth_cup,
    points_covariance,
    pose_covariance,
    pose_of,
    solution_gradient,
    solve,
)
from truepose.kinematics.pose_device.cascade import sides

PRINTED = reference("thesis_pose_device")
TABLE = PRINTED["table_3_1"]
PATTERN = DESIGNS[0]
TOOL = np.full(3, 150.0)
LEGS = np.full(6, 300.0)
TWELVE = np.array([300.0, 300.0, 300.0, 150.0, 150.0, 150.0, *LEGS])
UNEVEN = TWELVE + np.array([0.3, -0.5, 0.1, 0.2, -0.1, 0.4, 0.7, -0.7, 0.42, -0.42, 0.14, -0.14])


def solutions(design, twelve):
    cups = base_triangle(*twelve[:3])
    return solve(design, cups, twelve[3:6], twelve[6:])


def test_the_first_design_is_the_pattern_of_the_thesis():
    assert PATTERN.name == PRINTED["pattern"]
    assert PATTERN.legs == ((1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (2, 3))


def test_there_are_36_designs_and_four_times_as_many_with_a_fourth_cup():
    assert len(DESIGNS) == len({frozenset(design.legs) for design in DESIGNS}) == PRINTED["designs"]
    assert len(designs(4)) == len({frozenset(design.legs) for design in designs(4)}) == 144


def test_the_designs_named_in_the_thesis_are_among_them():
    named = {design.name for design in DESIGNS}

    assert set(PRINTED["named"]) <= named


def test_fewer_than_three_cups_are_refused():
    with pytest.raises(ConfigurationError, match="at least three"):
        designs(2)


def test_every_solution_of_every_design_has_the_lengths_that_went_in():
    length_mm = UNEVEN[6:]

    for design in designs(4):
        for nests in solve(design, FOUR_CUPS, UNEVEN[3:6], length_mm):
            apart = [np.linalg.norm(nests[nest - 1] - FOUR_CUPS[cup - 1]) for cup, nest in design.legs]
            assert apart == pytest.approx(length_mm, abs=1e-9), design.name
            assert sides(nests) == pytest.approx(UNEVEN[3:6], abs=1e-9), design.name


def test_the_four_solutions_of_every_design_differ_and_start_above_the_base():
    for design in DESIGNS:
        points = solutions(design, TWELVE)

        first = points[:, design.tool[0] - 1]
        assert (first[:, 2] > 200.0).all(), design.name
        assert all(np.abs(one - other).max() > 1.0 for one, other in pairwise(points)), design.name


def test_with_a_fourth_cup_no_nest_of_any_design_comes_where_a_cup_is():
    points = np.concatenate([solve(design, FOUR_CUPS, TOOL, LEGS) for design in designs(4)])

    # the nearest a nest of a nominal assembly comes to a cup without a leg; with the wrong side it is 0
    assert np.linalg.norm(points[:, :, None] - FOUR_CUPS, axis=3).min() > 100.0


def test_many_measurements_are_solved_at_once():
    rng = np.random.default_rng(3)
    many = 300.0 + rng.uniform(-1.0, 1.0, (7, 5, 6))

    at_once = solve(PATTERN, CUPS, TOOL, many)

    assert at_once.shape == (7, 5, 4, 3, 3)
    assert at_once[2, 3] == pytest.approx(solve(PATTERN, CUPS, TOOL, many[2, 3]))


def test_legs_that_do_not_meet_have_no_solution():
    assert np.isnan(solve(PATTERN, CUPS, TOOL, np.full(6, 150.0))).all()


def test_a_tool_too_large_for_its_legs_has_no_solution_but_the_first_nest():
    points = solve(PATTERN, CUPS, np.full(3, 700.0), LEGS)

    assert np.isfinite(points[:, 0]).all()
    assert np.isnan(points[:, 1:]).all()


@pytest.mark.parametrize("lengths", [np.full(5, 300.0), np.array(300.0)])
def test_a_design_without_its_six_legs_is_refused(lengths):
    with pytest.raises(ConfigurationError, match="six leg lengths"):
        solve(PATTERN, CUPS, TOOL, lengths)


def test_a_design_on_a_cup_that_is_not_there_is_refused():
    on_the_fourth = next(design for design in designs(4) if 4 in design.base)

    with pytest.raises(ConfigurationError, match="cup 4, but only 3 cups were given"):
        solve(on_the_fourth, CUPS, TOOL, LEGS)


@pytest.mark.parametrize("warped_mm", [-5.0, 0.0, 5.0])
def test_over_four_cups_in_a_plane_the_tool_is_above_whatever_the_fourth_is_out_of_flat(warped_mm):
    rhombus = np.vstack([CUPS, [450.0, 259.81, warped_mm]])

    for design in designs(4):
        first = solve(design, rhombus, TOOL, LEGS)[:, design.tool[0] - 1]
        assert np.isnan(first).any() or (first[:, 2] > 50.0).all()


def test_cups_on_a_line_are_refused():
    with pytest.raises(ConfigurationError, match="on a line"):
        solve(PATTERN, np.array([[0.0, 0.0, 0.0], [150.0, 0.0, 0.0], [300.0, 0.0, 0.0]]), TOOL, LEGS)


def test_sides_that_form_no_triangle_are_refused():
    with pytest.raises(ConfigurationError, match="No triangle"):
        base_triangle(300.0, 100.0, 150.0)
    with pytest.raises(ConfigurationError, match="No triangle"):
        base_triangle(0.0, 300.0, 300.0)


def test_a_base_triangle_has_the_sides_it_was_made_from():
    cups = base_triangle(300.3, 299.5, 300.1)

    assert sides(cups) == pytest.approx([300.3, 299.5, 300.1])
    assert cups[[0, 1, 2], [0, 1, 2]] == pytest.approx([0.0, 0.0, 0.0])
    assert cups[2, 1] > 0.0


def test_the_fourth_cup_is_the_lower_apex_of_the_tetrahedron():
    assert FOUR_CUPS[3] == pytest.approx([150.0, 86.6025, -244.9490], abs=1e-4)


def test_a_fourth_cup_that_cannot_be_there_is_refused():
    with pytest.raises(ConfigurationError, match="cups 1, 2 and 3"):
        fourth_cup(CUPS, 100.0, 100.0, 100.0)


def test_the_derivatives_by_all_twelve_lengths_agree_with_complex_steps():
    steps = UNEVEN + 1e-30j * np.eye(12)

    for design in DESIGNS:
        analytic = solution_gradient(design, base_triangle(*UNEVEN[:3]), solutions(design, UNEVEN))

        by_steps = np.stack([solutions(design, step).imag.reshape(4, 9) / 1e-30 for step in steps], axis=2)
        assert analytic == pytest.approx(by_steps, abs=1e-11), design.name


def test_the_uncertainty_of_the_pattern_is_that_of_the_thesis_for_t1_and_t2():
    norms = _norms()

    assert norms[:, 0] == pytest.approx(TABLE["T1"], abs=TABLE["tolerance"])
    assert norms[:, 1] == pytest.approx(TABLE["T2"], abs=TABLE["tolerance"])


def test_along_the_axes_of_the_base_it_is_that_of_the_thesis_too():
    axes = np.sqrt(_variances())

    assert axes[:, 0] == pytest.approx(np.array(TABLE["T1_axes"]), abs=TABLE["axes_tolerance"])
    assert axes[:, 1] == pytest.approx(np.array(TABLE["T2_axes"]), abs=TABLE["axes_tolerance"])


def test_the_uncertainty_of_t3_is_larger_than_printed_since_its_holders_are_correlated():
    in_full = PRINTED["recomputed"]

    assert _norms()[:, 2] == pytest.approx(in_full["T3"], abs=in_full["tolerance"])
    assert (_norms()[[0, 3], 2] > np.array(TABLE["T3"])[[0, 3]] + 0.1).all()


def test_the_printed_t3_comes_out_where_b2_is_exact_and_no_coordinate_correlates_with_another():
    # all four printed norms, to every digit: that is what the print leaves out, and nothing else
    points = solutions(PATTERN, TWELVE)
    own = points_covariance(PATTERN, CUPS, points, np.eye(12))
    variance = np.diagonal(own, axis1=1, axis2=2)

    printed = [
        _uncorrelated(t3, ((CUPS[1], np.zeros(3)), (t2, one[3:6]), (t1, one[:3])))
        for (t1, t2, t3), one in zip(points, variance, strict=True)
    ]

    assert printed == pytest.approx(TABLE["T3"], abs=TABLE["tolerance"])


def _uncorrelated(point, holders):
    back = np.linalg.inv(np.stack([point - holder for holder, _ in holders]))
    squares = [((point - holder) ** 2) @ (own + 1.0) for holder, own in holders]  # and the length itself
    return np.sqrt(np.trace(back @ np.diag(squares) @ back.T))


def test_the_covariance_of_the_pose_says_how_the_nests_scatter():
    points = solutions(PATTERN, TWELVE)[0]
    covariance = points_covariance(PATTERN, CUPS, points, 0.00051**2 * np.eye(12))
    rng = np.random.default_rng(8)
    drawn = rng.multivariate_normal(points.ravel(), covariance, size=2500, method="eigh").reshape(-1, 3, 3)

    middle = pose_of(NESTS, points)
    poses = [pose_of(NESTS, one) for one in drawn]  # of triangles that are off by microns: the best alignment
    turns = [vector_from_rotation(one.rotation @ middle.rotation.T) for one in poses]
    spread = np.std(np.hstack([[one.origin_mm for one in poses], turns]), axis=0)

    stated = np.sqrt(np.diag(pose_covariance(middle, NESTS, covariance)))
    assert spread == pytest.approx(stated, rel=0.05)  # 3.5 standard errors of 1.4 %


def test_nests_on_a_line_give_no_pose():
    on_a_line = np.array([[0.0, 0.0, 0.0], [75.0, 0.0, 0.0], [150.0, 0.0, 0.0]])

    with pytest.raises(UnderdeterminedError, match="on a line"):
        pose_covariance(pose_of(NESTS, NESTS), on_a_line, np.eye(9))


def test_a_nest_in_the_plane_of_what_holds_it_has_no_uncertainty_and_is_refused():
    flat = np.array([[150.0, 86.6, 0.0], [150.0, -60.0, 0.0], [270.0, 14.0, 0.0]])

    with pytest.raises(UnderdeterminedError, match="in the plane"):
        points_covariance(PATTERN, CUPS, flat, np.eye(12))


def _norms():
    return np.sqrt(_variances().sum(axis=2))


def _variances():
    """Of the coordinates of each nest in each solution, for lengths of variance 1."""
    covariance = points_covariance(PATTERN, CUPS, solutions(PATTERN, TWELVE), np.eye(12))
    return np.diagonal(covariance, axis1=1, axis2=2).reshape(4, 3, 3)
