"""A limit, and what the uncertainty of the readings leaves of it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.identification import NestCentre
from truepose.domain.robot import FramePlacement
from truepose.identification import judge
from truepose.kinematics.chain import nominal_chain
from truepose.validation.uncertainty import Figure, deciding_reading, known
from truepose.validation.validate import decide, decide_figures, validate

_CENTRES = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS, start=1))
_MODEL = model_of(IRB_120, base=FramePlacement(), nests=_CENTRES, nominal_nests=_CENTRES)
_ERROR_MM, _U_MM = 0.2, 0.01
_GUARD_MM = 1.65 * _U_MM


def readings(errors_mm, u_mm, covariance_mm2=None):
    """Readings that are off along x."""
    n = len(errors_mm)
    joints, nest = configurations(n), 1 + np.arange(n) % 3
    places = nominal_chain(IRB_120, joints).points(np.array(NESTS)[nest - 1])
    places[:, 0] += errors_mm
    return PointReadings(
        Stops(np.arange(n), joints), nest, places, np.full(n, u_mm), covariance_mm2=covariance_mm2
    )


def decision(limit_mm, errors_mm=(0.05, _ERROR_MM, 0.1), u_mm=_U_MM, **more):
    return validate(_MODEL, readings(np.array(errors_mm), u_mm), limit_mm=limit_mm, **more).decision


@pytest.mark.parametrize(
    ("limit_mm", "verdict"),
    [
        (_ERROR_MM + 1.01 * _GUARD_MM, "conforms"),
        (_ERROR_MM + 0.99 * _GUARD_MM, "cannot be decided"),
        (_ERROR_MM - 0.99 * _GUARD_MM, "cannot be decided"),
        (_ERROR_MM - 1.01 * _GUARD_MM, "does not conform"),
    ],
)
def test_the_guard_band_stands_on_either_side_of_the_limit(limit_mm, verdict):
    found = decision(limit_mm)

    assert (found.rule, found.verdict, found.limit_mm) == ("guard band", verdict, limit_mm)
    assert found.error_mm == pytest.approx(_ERROR_MM)
    assert found.guard_mm == pytest.approx(_GUARD_MM)


@pytest.mark.parametrize(("limit_mm", "verdict"), [(0.201, "conforms"), (0.199, "does not conform")])
def test_the_simple_rule_always_decides(limit_mm, verdict):
    found = decision(limit_mm, rule="simple")

    assert (found.rule, found.verdict, found.guard_mm) == ("simple", verdict, 0.0)


def test_what_passes_does_not_depend_on_the_rule():
    judged = [
        validate(_MODEL, readings(np.array([_ERROR_MM]), 0.1), limit_mm=0.21, rule=rule)
        for rule in ("guard band", "simple")
    ]

    assert [one.decision.verdict for one in judged] == ["cannot be decided", "conforms"]
    assert [one.passed for one in judged] == [True, True]


def test_without_a_limit_nothing_is_decided():
    assert decision(None) is None


def test_readings_without_an_error_conform_by_their_guard_alone():
    assert decision(1.01 * _GUARD_MM, errors_mm=(0.0, 0.0)).verdict == "conforms"
    assert decision(0.99 * _GUARD_MM, errors_mm=(0.0, 0.0)).verdict == "cannot be decided"


def test_a_small_error_that_is_badly_known_may_decide():
    points = readings(np.array([0.2, 0.15]), _U_MM)
    doubtful = replace(points, standard_uncertainty_mm=np.array([0.01, 0.1]))

    found = validate(_MODEL, doubtful, limit_mm=0.3).decision

    assert (found.verdict, found.error_mm) == ("cannot be decided", pytest.approx(0.15))


def test_only_the_uncertainty_along_the_error_counts():
    covariance = np.tile(np.diag([1e-6, 1.0, 1.0]), (2, 1, 1))
    points = readings(np.array([0.2, 0.1]), _U_MM, covariance)

    found = validate(_MODEL, points, limit_mm=0.21).decision

    assert (found.verdict, found.guard_mm) == ("conforms", pytest.approx(1.65e-3, rel=1e-6))


def deciding(errors_mm, u_mm, error_mm=None, **known_as):
    judged = judge(_MODEL, readings(np.array(errors_mm), np.array(u_mm)), 0.0)
    return deciding_reading(judged, replace(known(_MODEL, judged), **known_as), error_mm)


def test_the_reading_that_decides_has_the_uncertainty_of_its_guard_band():
    errors, u = (0.05, 0.2, 0.19), (0.01, 0.01, 0.03)
    judged = judge(_MODEL, readings(np.array(errors), np.array(u)), 0.0)
    found = decide(judged, known(_MODEL, judged), 0.2, "guard band")

    reading = deciding(errors, u, found.error_mm)

    assert reading.config == 2  # the less known one, though its error is not the largest
    assert 1.65 * reading.combined_u_mm == pytest.approx(found.guard_mm)
    assert deciding(errors, u).config == 1


def test_what_the_placement_adds_is_told_apart_from_the_reading():
    motion = np.zeros((1, 3, 3))
    motion[0, :, 0] = 1.0  # all places move along x

    reading = deciding((0.05, 0.2, 0.1), (0.01,) * 3, motion=motion, placement=np.array([[0.0009]]))

    assert reading.reading_u_mm == pytest.approx(0.01)
    assert reading.placement_u_mm == pytest.approx(0.03)
    assert reading.combined_u_mm == pytest.approx(np.hypot(0.01, 0.03))


def test_of_no_error_the_uncertainty_is_along_the_worst_way():
    reading = deciding((0.0,) * 3, (0.01,) * 3)

    assert reading.error_mm == pytest.approx(0.0, abs=1e-9)
    assert reading.combined_u_mm == pytest.approx(0.01)


def test_a_covariance_that_few_digits_left_below_zero_leaves_a_guard_band():
    judged = judge(_MODEL, readings(np.array([0.05, _ERROR_MM, 0.1]), 1e-9), 0.0)
    inputs = replace(known(_MODEL, judged), placement=-1e-6 * np.eye(6))

    assert decide(judged, inputs, 0.3, "guard band").verdict == "conforms"


@pytest.mark.parametrize(
    ("limit_mm", "rule", "verdict"),
    [
        (0.35, "guard band", "conforms"),
        (0.33, "guard band", "cannot be decided"),
        (0.26, "guard band", "does not conform"),
        (0.31, "simple", "conforms"),
        (0.29, "simple", "does not conform"),
    ],
)
def test_of_several_figures_the_one_that_comes_nearest_to_the_limit_decides(limit_mm, rule, verdict):
    figures = [Figure(0.1, 0.01), Figure(-0.3, 0.02)]

    found = decide_figures(figures, limit_mm, rule)

    assert (found.verdict, found.rule) == (verdict, rule)
    assert found.error_mm == pytest.approx(0.3)
