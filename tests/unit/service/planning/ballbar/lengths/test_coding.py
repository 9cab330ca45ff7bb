"""Coded lengths: all different, evenly spread, and moving on from pose to pose."""

import numpy as np
import pytest

from truepose.domain.errors import ConfigurationError
from truepose.planning.ballbar.length_targets import SPAN_MM, coded_lengths


def test_six_legs_have_the_levels_of_seven_tenths_in_steps_of_028():
    offsets_mm = coded_lengths(6)

    assert sorted(offsets_mm) == pytest.approx([-0.7, -0.42, -0.14, 0.14, 0.42, 0.7])


@pytest.mark.parametrize("n", range(2, 13))
def test_any_number_of_legs_has_as_many_levels_within_the_span(n):
    offsets_mm = coded_lengths(n, turn=5)

    assert sorted(offsets_mm) == pytest.approx(np.linspace(-SPAN_MM, SPAN_MM, n))


@pytest.mark.parametrize("turn", range(6))
def test_legs_that_follow_each_other_differ_by_two_steps_or_more(turn):
    offsets_mm = coded_lengths(6, turn)

    assert np.abs(np.diff(offsets_mm)).min() > 1.9 * 0.28


def test_over_six_poses_each_leg_has_every_level_once():
    codes = np.array([coded_lengths(6, turn) for turn in range(6)])

    for leg in codes.T:
        assert sorted(leg) == pytest.approx(sorted(codes[0]))


def test_a_single_leg_is_nominal():
    assert coded_lengths(1) == (0.0,)


@pytest.mark.parametrize("n", [0, -1])
def test_no_leg_cannot_be_coded(n):
    with pytest.raises(ConfigurationError, match="at least one"):
        coded_lengths(n)
