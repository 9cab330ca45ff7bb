"""Validation: a model against readings whose errors are known."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import LegReadings, PointReadings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Anchor, Model, NestCentre, Parameter
from truepose.domain.robot import FramePlacement
from truepose.kinematics.chain import nominal_chain
from truepose.messages.catalogue import english
from truepose.reports.validation import verdict_sentence
from truepose.validation.validate import validate

ANCHOR = (400.0, -300.0, -50.0)


def model(error_mm=0.0, repeatability_mm=0.0):
    """A model that is off by a constant in x, while the nominal one is off by 1 mm in x."""
    nests = tuple(NestCentre(k, centre) for k, centre in enumerate(NESTS, start=1))
    legs = [
        Parameter(f"anchor_1_2_{axis}", "legs", value, "mm", 0.1, 10.0)
        for axis, value in zip("xyz", ANCHOR, strict=True)
    ]
    return Model(
        robot=IRB_120,
        base=FramePlacement(x_mm=error_mm),
        nests=nests,
        tool_rotation_rad=(0.0, 0.0, 0.0),
        effects=(),
        parameters=tuple(legs),
        covariance=np.zeros((3, 3)),
        gravity_m_s2=(0.0, 0.0, -9.81),
        discrepancy_mm=0.0,
        repeatability_mm=repeatability_mm,
        nominal_base=FramePlacement(x_mm=1.0),
        nominal_nests=nests,
        nominal_anchors=(Anchor(1, 2, ANCHOR),),
        nominal_leg_offset_mm=0.5,
    )


def readings(n=12, noise_mm=0.1, covariance_mm2=None):
    joints = configurations(n, seed=4)
    nest = 1 + np.arange(n) % 3
    places = nominal_chain(IRB_120, joints).points(np.array(NESTS)[nest - 1])
    noise = noise_mm * np.random.default_rng(3).standard_normal((n, 3))
    return PointReadings(
        Stops(np.arange(n), joints), nest, places + noise, np.full(n, 0.1), covariance_mm2=covariance_mm2
    )


def predicted(points, shift_mm):
    noise = 0.1 * np.random.default_rng(3).standard_normal((len(points), 3))
    return points.position_mm - noise + [shift_mm, 0.0, 0.0]


def between(places, i, j):
    return np.linalg.norm(places[i] - places[j])


def test_distances_are_those_of_all_pairs():
    points = readings()

    answer = validate(model(0.2), points)

    found, signed = answer.distance, answer.distance_errors
    for figures, signs, shift in (
        (found.identified, signed.identified, 0.2),
        (found.nominal, signed.nominal, 1.0),
    ):
        there = predicted(points, shift)
        errors = [
            np.linalg.norm(points.position_mm[i] - points.position_mm[j])
            - np.linalg.norm(there[i] - there[j])
            for i, j in combinations(range(12), 2)
        ]
        assert figures.n == 66
        assert figures.mean_mm == pytest.approx(np.abs(errors).mean())
        assert figures.rms_mm == pytest.approx(np.sqrt(np.mean(np.square(errors))))
        assert figures.sd_mm == pytest.approx(np.abs(errors).std(ddof=1))
        assert figures.max_mm == pytest.approx(np.abs(errors).max())
        assert signs.mean_mm == pytest.approx(np.mean(errors))
        assert signs.positive_share == pytest.approx(np.mean(np.array(errors) > 0.0))
        assert sum(signs.histogram.counts) == 66


def test_a_constant_shift_is_an_error_of_position_and_none_of_distance():
    answer = validate(model(0.2), readings(noise_mm=0.0))

    assert answer.position.identified.mean_mm == pytest.approx(0.2)
    assert answer.position.identified.sd_mm == pytest.approx(0.0, abs=1e-9)
    assert answer.distance.identified.max_mm < 1e-9


def test_expected_noise_is_what_draws_of_readings_and_scatter_give():
    n = 400
    covariance = np.broadcast_to(np.diag([0.04, 0.01, 0.0025]), (n, 3, 3))
    points = readings(n, noise_mm=0.0, covariance_mm2=covariance)
    rng = np.random.default_rng(8)
    noise = rng.standard_normal((n, 3)) * [0.2, 0.1, 0.05] + 0.1 * rng.standard_normal((n, 3))

    answer = validate(model(repeatability_mm=0.1), replace(points, position_mm=points.position_mm + noise))

    # 400 norms know their mean to 2.3 %; directions of pairs are not quite uniform, so distances to 10 %
    assert answer.position.identified.mean_mm == pytest.approx(answer.position.identified.noise_mm, rel=0.1)
    assert answer.distance.identified.mean_mm == pytest.approx(answer.distance.identified.noise_mm, rel=0.15)


@pytest.mark.parametrize(("limit_mm", "passed"), [(0.21, True), (0.19, False)])
def test_the_limit_judges_the_largest_error(limit_mm, passed):
    answer = validate(model(0.2), readings(noise_mm=0.0), limit_mm=limit_mm)

    assert answer.passed is passed
    assert answer.limit_mm == limit_mm


@pytest.mark.parametrize(("error_mm", "passed"), [(0.5, True), (1.5, False)])
def test_without_a_limit_the_nominal_model_is_the_measure(error_mm, passed):
    honest = replace(model(error_mm), discrepancy_mm=error_mm)

    assert validate(honest, readings(noise_mm=0.0)).passed is passed


def test_without_a_limit_a_model_far_from_what_it_claims_fails():
    boastful = replace(model(0.5), discrepancy_mm=0.01)

    answer = validate(boastful, readings(noise_mm=0.0))

    assert not answer.passed
    assert answer.position.identified.mean_mm > 3.0 * answer.claimed_mm


def test_one_reading_has_no_distances():
    answer = validate(model(), readings(1))

    assert (answer.distance, answer.distance_errors) == (None, None)


def test_nothing_to_validate_with_is_refused():
    with pytest.raises(ConfigurationError, match="no readings to validate with"):
        validate(model(), readings(0))


def legs(base_point=2, n=6):
    points = readings(n, noise_mm=0.0)
    length = np.linalg.norm(points.position_mm - ANCHOR, axis=1) + 0.3
    ones = np.ones(n, dtype=np.int64)
    return LegReadings(points.stops, ones, base_point * ones, points.nest, length, np.full(n, 0.01))


def test_legs_are_judged_by_length():
    answer = validate(model(), legs())

    assert (answer.quantity, answer.distance) == ("length", None)
    assert answer.position.identified.mean_mm == pytest.approx(0.3)
    assert answer.position.identified.noise_mm == pytest.approx(0.01 * np.sqrt(2.0 / np.pi))


def test_legs_from_a_place_that_the_model_does_not_know_are_refused():
    with pytest.raises(
        ConfigurationError, match="Base point 3 of placement 1 is not among the ballbar lengths"
    ):
        validate(model(), legs(base_point=3))


def test_a_model_whose_file_states_no_uncertainty_keeps_no_claim_but_a_limit():
    unknown = replace(model(0.2), covariance=np.full((3, 3), np.nan))

    without, within = validate(unknown, readings()), validate(unknown, readings(), limit_mm=2.0)

    assert "set a limit" in english(verdict_sentence(without))
    assert (without.passed, within.passed, within.decision.verdict) == (False, True, "conforms")
