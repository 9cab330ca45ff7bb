"""The stated uncertainty of every figure against the scatter of the figure over many tests."""

import numpy as np
import pytest

from tests.helpers.domain.iso9283 import joined, visits_of
from truepose.validation.iso9283.drift import Group, drift
from truepose.validation.iso9283.performance import direction_performance, distance_performance, one_pose
from truepose.validation.iso9283.visits import RADIUS_OF_NOISE, CommandedPose

_TESTS = 1000
_FAR = CommandedPose(1, (-0.1, 0.2, 0.05))
_ENDS = (CommandedPose(2, (0.0, 0.0, 0.0)), CommandedPose(4, (300.0, 50.0, 400.0)))
_SCATTER_MM = np.array([[0.02, 0.0, 0.0], [0.01, 0.015, 0.0], [0.0, 0.0, 0.005]])
_TURNS_RAD = 1e-4
_U_MM = 0.015
_UP = np.array([0.0, 0.0, 1.0])


def drawn(rng, n, middle=(0.0, 0.0, 0.0), u_mm=_U_MM):
    """Visits of a robot that scatters, seen by an instrument whose error of the pose is constant."""
    return np.array(middle) + u_mm * rng.standard_normal(3) + rng.standard_normal((n, 3)) @ _SCATTER_MM.T


def of_pose(rng):
    turns = 3e-5 * rng.standard_normal(3) + _TURNS_RAD * rng.standard_normal((30, 3))
    return one_pose(_FAR, visits_of(1, drawn(rng, 30), turns_rad=turns, u_mm=_U_MM, u_rot_rad=3e-5), 30)


def of_distance(rng):
    seen = [visits_of(end.number, drawn(rng, 30, end.position_mm), u_mm=_U_MM) for end in _ENDS]
    return distance_performance(_ENDS, joined(*seen))


def of_directions(rng):
    instrument = _U_MM * rng.standard_normal(3)
    middles = ((0.0, 0.0, 0.0), (0.06, 0.0, 0.0), (0.0, 0.08, 0.03))
    approaches = [
        visits_of(1, drawn(rng, 30, instrument + middle, u_mm=0.0), u_mm=_U_MM) for middle in middles
    ]
    return direction_performance(approaches, poses=(1,))


def of_drift(rng):
    instrument = 1e-3 * rng.standard_normal(3)
    groups = [
        Group(3600.0 * hours, visits_of(1, drawn(rng, 30, instrument + 0.02 * hours * _UP, u_mm=0.0)))
        for hours in (0.0, 8.0)
    ]
    return drift(_FAR, groups).performance


@pytest.mark.parametrize("test", [of_pose, of_distance, of_directions, of_drift])
def test_the_stated_uncertainty_is_the_scatter_of_the_figure(test):
    rng = np.random.default_rng(11)
    values, stated = {}, {}
    for _ in range(_TESTS):
        for c in test(rng).characteristics:
            values.setdefault((c.symbol, c.component), []).append(c.value)
            stated.setdefault((c.symbol, c.component), []).append(c.standard_uncertainty)

    for name, figures in values.items():
        if name == ("dRP", "l"):
            continue  # the size of a difference about 0 scatters less than the difference: checked below
        scatter, mean = np.std(figures, ddof=1), np.sqrt(np.mean(np.square(stated[name])))
        # 1,000 tests know a scatter to 2.2 %; fourth moments of 30 visits are too small by a few percent.
        assert mean == pytest.approx(scatter, rel=0.12), name


def test_a_drift_of_nothing_stays_within_its_uncertainty():
    rng = np.random.default_rng(5)

    within = [
        abs(c.value) <= 2.0 * c.standard_uncertainty
        for _ in range(400)
        for c in of_drift(rng).characteristics
        if c.symbol == "dRP"
    ]

    assert 0.90 < np.mean(within) < 0.99  # 95 % of 400 to 1.1 %, and the normal is not quite met


def test_at_the_commanded_pose_the_direction_is_the_worst_one():
    away = np.array([[sign * 0.02, 0.0, 0.0] for sign in (1, -1)] * 15)

    found = one_pose(CommandedPose(1, (0.0, 0.0, 0.0)), visits_of(1, away, u_mm=0.01), 30).characteristics[0]

    assert found.value == 0.0
    assert found.standard_uncertainty == pytest.approx(
        np.hypot(np.std(away[:, 0], ddof=1) / np.sqrt(30), 0.01)
    )


def test_an_instrument_alone_shows_a_repeatability():
    rng = np.random.default_rng(2)
    still = [visits_of(1, 0.01 * rng.standard_normal((30, 3)), u_mm=0.01) for _ in range(400)]

    shown = [one_pose(_FAR, seen, 30).characteristics[4] for seen in still]

    assert shown[0].symbol == "RP"
    assert shown[0].noise == pytest.approx(0.01 * RADIUS_OF_NOISE)
    # radii about the barycentre are smaller by sqrt(29/30), 1.7 %
    assert np.mean([c.value for c in shown]) == pytest.approx(shown[0].noise, rel=0.03)
