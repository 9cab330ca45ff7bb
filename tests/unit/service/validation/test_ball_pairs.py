from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from tests.helpers.ballbar.coded_stops import BALLBAR, READINGS
from truepose.domain.ballbar import PoseForecast
from truepose.domain.errors import ConfigurationError
from truepose.validation.connection_check import judge_leg, judge_pose

PATTERN = ((1, 1), (2, 1), (3, 1), (1, 2), (2, 2), (2, 3))
OTHERS = ((1, 3), (3, 2), (3, 3))
CODED = dict(zip(PATTERN, (299.3, 299.58, 299.86, 300.14, 300.42, 300.7), strict=True))
FAR = dict(zip(OTHERS, (204.0, 412.0, 377.0), strict=True))  # outside the pattern, outside the range


def forecast(lengths, u_mm=0.05, shared_mm=0.0):
    """Return a forecast whose errors have a part of their own and a part that all share."""
    covariance = u_mm**2 * np.eye(len(lengths)) + shared_mm**2
    return PoseForecast(7, tuple(lengths), tuple(lengths.values()), tuple(map(tuple, covariance)))


EXACT = forecast(CODED | FAR)


def judge(asked, length_mm, earlier=None, foreseen=EXACT):
    return judge_leg(asked, length_mm, earlier or {}, foreseen, **BALLBAR)


def exchanged(lengths, first, second):
    return lengths | {first: lengths[second], second: lengths[first]}


def named(suspicions):
    return {(one.asked, one.suspected, one.kind) for one in suspicions}


@pytest.mark.parametrize("off_mm", [-0.08, -0.03, 0.0, 0.05, 0.1])
@pytest.mark.parametrize("leg", PATTERN)
def test_a_length_within_two_standard_uncertainties_of_what_was_asked_goes_with_it(leg, off_mm):
    earlier = {other: CODED[other] for other in PATTERN[: PATTERN.index(leg)]}

    assert judge(leg, CODED[leg] + off_mm, earlier) is None


@pytest.mark.parametrize(("asked", "connected"), list(combinations(PATTERN, 2)))
def test_another_pair_of_the_pattern_is_named(asked, connected):
    suspicion = judge(asked, CODED[connected])

    assert suspicion is not None
    assert (suspicion.kind, suspicion.asked, suspicion.suspected) == ("other_pair", asked, connected)
    assert suspicion.length_mm == CODED[connected]
    assert suspicion.expected_mm == CODED[asked]


def test_a_pair_outside_the_pattern_is_named_where_it_is_within_reach_of_the_ballbar():
    near = forecast(CODED | FAR | {(3, 3): 300.98})

    suspicion = judge((1, 2), 300.99, foreseen=near)

    assert (suspicion.kind, suspicion.suspected) == ("other_pair", (3, 3))


@pytest.mark.parametrize("again", PATTERN[:5])
@pytest.mark.parametrize("off_mm", [-0.004, 0.0, 0.004])
def test_a_pair_that_is_read_twice_is_named(again, off_mm):
    earlier = {leg: CODED[leg] for leg in PATTERN[:5]}

    suspicion = judge(PATTERN[5], CODED[again] + off_mm, earlier)

    assert (suspicion.kind, suspicion.suspected) == ("same_pair", again)


@pytest.mark.parametrize("foreseen", [None, EXACT], ids=["nothing foreseen", "foreseen"])
def test_a_retry_is_not_compared_with_the_reading_that_it_replaces(foreseen):
    assert judge((1, 1), 299.3, {(1, 1): 299.3}, foreseen) is None


def test_the_second_of_two_exchanged_legs_says_so_if_the_first_was_kept():
    # adjacent codes, foreseen so badly that neither alone is clear: 1.9 sigma, then 3.7 for both
    vague = forecast(CODED | FAR, u_mm=0.11)
    first, second = (1, 1), (2, 1)

    kept = judge_leg(first, 299.44, {}, vague, **BALLBAR)
    suspicion = judge(second, 299.2, {first: 299.62}, vague)

    assert kept is None
    assert (suspicion.kind, suspicion.suspected) == ("exchanged", first)


def test_a_length_that_goes_with_nothing_is_unlikely():
    suspicion = judge((1, 1), 299.0)

    assert (suspicion.kind, suspicion.suspected) == ("unlikely", None)


def test_earlier_readings_correct_what_all_forecasts_share():
    # the whole stop is 0.28 mm off, just the distance of two codes
    together = forecast(CODED | FAR, u_mm=0.02, shared_mm=0.3)
    earlier = {leg: CODED[leg] + 0.28 for leg in PATTERN[:3]}

    assert judge(PATTERN[3], CODED[PATTERN[3]] + 0.28, earlier, together) is None
    suspicion = judge(PATTERN[3], CODED[PATTERN[3]], earlier, together)
    assert suspicion is not None


def test_where_nothing_is_foreseen_only_a_pair_read_twice_is_seen():
    earlier = {(1, 1): 300.21, (2, 1): 299.874}

    assert judge((3, 1), 300.5, earlier, None) is None
    assert judge((3, 1), 300.21, {}, None) is None
    suspicion = judge((3, 1), 299.876, earlier, None)
    assert (suspicion.kind, suspicion.suspected, suspicion.expected_mm) == ("same_pair", (2, 1), None)


@pytest.mark.parametrize("off_mm", [0.02, -0.02, 0.2])
def test_a_length_that_is_clearly_not_the_earlier_one_is_no_pair_read_twice(off_mm):
    assert judge((2, 1), 300.0 + off_mm, {(1, 1): 300.0}, None) is None


@pytest.mark.parametrize("nominal_mm", [150.0, 300.0, 1000.0])
def test_where_nothing_is_foreseen_the_first_reading_is_never_suspected(nominal_mm):
    for length in nominal_mm + np.linspace(-1.0, 1.025, 9):
        taken = judge_leg((1, 1), length, {}, None, **{**BALLBAR, "nominal_mm": nominal_mm})
        assert taken is None


def test_a_forecast_that_knows_nothing_accuses_nobody():
    # all pairs alike, +-0.5 mm: to ask would lead nowhere
    blind = forecast(dict.fromkeys((*PATTERN, *OTHERS), 300.0), u_mm=0.5)
    lengths = dict(zip(PATTERN, (300.1, 299.7, 300.4, 299.9, 300.3, 299.5), strict=True))

    taken = {}
    for leg, length in lengths.items():
        assert judge(leg, length, taken, blind) is None
        taken[leg] = length
    assert judge_pose(lengths, blind, **READINGS) == ()


def test_a_forecast_that_knows_nothing_accuses_nobody_with_twelve_pairs_either():
    legs = tuple((cup, nest) for cup in (1, 2, 3, 4) for nest in (1, 2, 3))
    blind = forecast(dict.fromkeys(legs, 300.0), u_mm=0.5)
    lengths = dict(zip(legs, 300.0 + 0.15 * (np.arange(12) - 5.5), strict=True))

    assert judge_pose(lengths, blind, **READINGS) == ()


def test_six_legs_as_asked_are_judged_right():
    assert judge_pose(CODED, EXACT, **READINGS) == ()


@pytest.mark.parametrize(("first", "second"), list(combinations(PATTERN, 2)))
def test_two_exchanged_legs_of_a_pose_are_both_named(first, second):
    suspicions = judge_pose(exchanged(CODED, first, second), EXACT, **READINGS)

    assert named(suspicions) == {(first, second, "exchanged"), (second, first, "exchanged")}


@pytest.mark.parametrize("three", list(combinations(PATTERN, 3)))
def test_three_legs_that_changed_places_are_all_named(three):
    first, second, third = three
    for a, b, c in ((first, second, third), (first, third, second)):
        turned = CODED | {a: CODED[b], b: CODED[c], c: CODED[a]}

        suspicions = judge_pose(turned, EXACT, **READINGS)

        assert named(suspicions) == {(a, b, "exchanged"), (b, c, "exchanged"), (c, a, "exchanged")}


def test_all_six_legs_in_the_opposite_order_are_named():
    reversed_mm = dict(zip(PATTERN, reversed(CODED.values()), strict=True))

    suspicions = judge_pose(reversed_mm, EXACT, **READINGS)

    assert named(suspicions) == {
        (one, other, "exchanged") for one, other in zip(PATTERN, reversed(PATTERN), strict=True)
    }


def test_a_pair_read_twice_is_found_in_the_whole_pose_too():
    suspicions = judge_pose(CODED | {(2, 3): CODED[1, 1] + 0.001}, EXACT, **READINGS)

    assert named(suspicions) == {((2, 3), (1, 1), "same_pair")}


def test_a_length_of_nothing_is_found_in_the_whole_pose_too():
    suspicions = judge_pose(CODED | {(2, 3): 301.0}, EXACT, **READINGS)

    assert named(suspicions) == {((2, 3), None, "unlikely")}


@pytest.mark.parametrize(
    ("range_mm", "found"), [(1.0, ((2, 3), (3, 3), "other_pair")), (5.0, ((2, 3), None, "unlikely"))]
)
def test_how_far_a_ballbar_reads_decides_whether_a_length_may_be_of_nothing(range_mm, found):
    """Seven standard uncertainties from another pair, and 4 mm off: beyond one ballbar, within the other."""
    other = forecast(CODED | FAR | {(3, 3): 305.05})

    suspicions = judge_pose(CODED | {(2, 3): 304.7}, other, **READINGS | {"range_mm": range_mm})

    assert named(suspicions) == {found}


def test_two_independent_slips_are_both_named():
    near = forecast(CODED | FAR | {(3, 3): 300.98})
    wrong = CODED | {(1, 1): 300.98, (2, 3): CODED[2, 1]}

    suspicions = judge_pose(wrong, near, **READINGS)

    assert named(suspicions) == {((1, 1), (3, 3), "other_pair"), ((2, 3), (2, 1), "same_pair")}


def test_legs_whose_forecasts_are_alike_may_be_exchanged_unseen():
    # without codes all legs aim at 300 mm: lengths alone cannot tell, and nobody is accused
    alike = forecast(dict.fromkeys(PATTERN, 300.0) | FAR, u_mm=0.06)
    lengths = dict(zip(PATTERN, (300.05, 299.97, 300.02, 299.92, 300.08, 299.99), strict=True))

    assert judge_pose(lengths, alike, **READINGS) == ()
    assert judge_pose(exchanged(lengths, (1, 1), (2, 2)), alike, **READINGS) == ()


def test_more_than_six_legs_are_judged_together():
    legs = tuple((cup, nest) for cup in (1, 2, 3) for nest in (1, 2, 3))
    lengths = dict(zip(legs, 299.2 + 0.2 * np.arange(9), strict=True))
    foreseen = forecast(lengths, u_mm=0.03)

    assert judge_pose(lengths, foreseen, **READINGS) == ()
    suspicions = judge_pose(exchanged(lengths, (1, 1), (3, 3)), foreseen, **READINGS)
    assert named(suspicions) == {((1, 1), (3, 3), "exchanged"), ((3, 3), (1, 1), "exchanged")}


def test_of_no_reading_nothing_is_judged():
    assert judge_pose({}, EXACT, **READINGS) == ()


def test_what_was_foreseen_too_surely_is_questioned_less_with_every_reading():
    # all forecasts are off by ten of their standard uncertainties, this way and that
    sure = forecast(CODED | FAR, u_mm=0.01)
    off = dict(zip(PATTERN, (0.1, -0.1, 0.1, -0.1, 0.1, -0.1), strict=True))
    earlier = {leg: CODED[leg] + off[leg] for leg in PATTERN[:5]}

    last = PATTERN[5]
    assert judge(last, CODED[last] + off[last], {}, sure) is not None
    assert judge(last, CODED[last] + off[last], earlier, sure) is None


@pytest.mark.parametrize("length", [np.nan, np.inf])
def test_a_length_that_is_no_number_is_refused(length):
    with pytest.raises(ConfigurationError, match="B1 T1 is not a number"):
        judge((1, 1), length)
    with pytest.raises(ConfigurationError, match="B2 T1 is not a number"):
        judge((1, 1), 300.0, {(2, 1): length})
    with pytest.raises(ConfigurationError, match="B1 T1 is not a number"):
        judge_pose(CODED | {(1, 1): length}, EXACT, **READINGS)


def test_a_leg_that_the_forecast_does_not_know_is_refused():
    with pytest.raises(ConfigurationError, match="no ballbar length B4 T1"):
        judge((4, 1), 300.0)


@pytest.mark.parametrize("range_mm", [0.0, -1.0, np.nan])
def test_a_ballbar_without_a_range_is_refused(range_mm):
    with pytest.raises(ConfigurationError, match="range"):
        judge_leg((1, 1), 300.0, {}, None, **{**BALLBAR, "range_mm": range_mm})
    with pytest.raises(ConfigurationError, match="range"):
        judge_pose(CODED, EXACT, **READINGS | {"range_mm": range_mm})


@pytest.mark.parametrize("u_mm", [0.0, np.nan])
def test_a_reading_without_uncertainty_is_refused(u_mm):
    with pytest.raises(ConfigurationError, match="greater than 0 mm"):
        judge_leg((1, 1), 300.0, {}, None, **{**BALLBAR, "reading_u_mm": u_mm, "zero_u_mm": 0.0})


@pytest.mark.parametrize(
    "change",
    [
        {"covariance_mm2": ((1.0,),)},
        {"length_mm": (300.0,)},
        {"covariance_mm2": tuple(map(tuple, -np.eye(9)))},
        {"covariance_mm2": tuple(map(tuple, np.full((9, 9), np.nan)))},
    ],
)
def test_a_forecast_that_does_not_hold_together_is_refused(change):
    with pytest.raises(ConfigurationError, match="configuration 7"):
        judge((1, 1), 300.0, foreseen=replace(EXACT, **change))
