"""Distances of segments by hand, and against a search over points of both."""

import numpy as np
import pytest

from truepose.planning.workspace.capsules import (
    join_capsules,
    lowest_mm,
    segment_distances,
    smallest_gap,
    still,
)


def distance(p1, q1, p2, q2):
    return float(segment_distances(*(np.array(point, dtype=float) for point in (p1, q1, p2, q2))))


@pytest.mark.parametrize(
    ("first", "second", "expected"),
    [
        (((0, 0, 0), (10, 0, 0)), ((5, 3, -5), (5, 3, 5)), 3.0),  # crossing
        (((0, 0, 0), (10, 0, 0)), ((0, 4, 0), (10, 4, 0)), 4.0),  # parallel
        (((0, 0, 0), (10, 0, 0)), ((14, 3, 0), (20, 3, 0)), 5.0),  # parallel, apart along their line
        (((0, 0, 0), (10, 0, 0)), ((13, 4, 0), (13, 4, 9)), 5.0),  # end to end
        (((0, 0, 0), (10, 0, 0)), ((2, 0, 0), (3, 0, 0)), 0.0),  # one in the other
        (((1, 1, 1), (1, 1, 1)), ((0, 0, 1), (2, 0, 1)), 1.0),  # a point
        (((1, 1, 1), (1, 1, 1)), ((1, 4, 5), (1, 4, 5)), 5.0),  # two points
    ],
)
def test_segments_are_as_far_apart_as_one_sees(first, second, expected):
    assert distance(*first, *second) == pytest.approx(expected)
    assert distance(*second, *first) == pytest.approx(expected)


@pytest.mark.parametrize("size_mm", [1e-3, 1.0, 1e3])
def test_nearly_parallel_segments_are_as_far_apart_in_any_unit(size_mm):
    lean = 1e-4  # of the second, which crosses over the middle of the first
    ends = size_mm * np.array([[-1, 0, 0], [1, 0, 0], [-1, -lean, 0.1], [1, lean, 0.1]])

    assert segment_distances(*ends) == pytest.approx(0.1 * size_mm, rel=1e-12)


def test_no_two_points_of_segments_are_nearer_than_their_distance():
    rng = np.random.default_rng(0)
    ends = rng.normal(size=(4, 200, 3))
    share = np.linspace(0, 1, 101)[:, None, None]

    found = segment_distances(*ends)

    on_first, on_second = (a + share * (b - a) for a, b in ((ends[0], ends[1]), (ends[2], ends[3])))
    sampled = np.linalg.norm(on_first[:, None] - on_second[None], axis=3).min(axis=(0, 1))
    assert np.all(found <= sampled + 1e-12)
    # between two samples a point moves by half a hundredth of a segment, of length 7 at most
    assert np.all(sampled - found < 0.07)


def test_a_gap_is_the_distance_less_both_radii_and_negative_inside():
    first = still([(np.zeros(3), np.array([10.0, 0.0, 0.0]))], 2.0)
    apart = still([(np.array([5.0, 9.0, 0.0]), np.array([5.0, 20.0, 0.0]))], 3.0)
    inside = still([(np.array([5.0, 1.0, 0.0]), np.array([5.0, 2.0, 0.0]))], 3.0)

    assert smallest_gap(first, apart) == pytest.approx([4.0])
    assert smallest_gap(first, join_capsules([apart, inside])) == pytest.approx([-4.0])


def test_nothing_is_infinitely_far_away():
    one = still([(np.zeros(3), np.ones(3))], 1.0)

    assert smallest_gap(one, still([], 1.0)).tolist() == [np.inf]


def test_the_lowest_point_is_an_end_less_the_radius():
    one = still([(np.zeros(3), np.array([0.0, 0.0, 50.0])), (np.ones(3), -np.ones(3))], 4.0)

    assert lowest_mm(one).tolist() == [-5.0]
