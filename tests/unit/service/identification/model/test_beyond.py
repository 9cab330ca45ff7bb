"""Before the first and after the last reading: what drifted is held, less and less surely; jumps are past."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import ORIGIN_S, model_of, parameters_of
from tests.helpers.identification.synthetic import configurations
from truepose.domain.campaign import Stops
from truepose.domain.identification import Parameter
from truepose.identification import predict, unpredictable
from truepose.messages.catalogue import english

N = 5
RATE = 0.3  # mm/h
LASTED_H = 0.8
LAST_S = ORIGIN_S + 3600.0 * LASTED_H
DAY_H, MONTH_H = 24.0, 720.0
NESTS = np.ones(N, dtype=np.int64)
DRIFTS = {
    "base_drift": "drift_linear_x",
    "instrument_drift": "tracker_linear_x",
    "unnamed": "cell_drift_3_line_turn",
}
JUMPS = {
    "base_shift": "jump_1500_x",
    "slip": "cell_slip_0_1500_x",
    "kick": "cell_kick_0_1500_x",
    "jump": "cell_jump_3_1500_turn",
}
SETTLES = "drift_exp1200_x"


def model(**values):
    """An arm that drifts, jumps or settles as its parameters say, known exactly."""
    parameters = [
        parameter
        for name, value in values.items()
        for parameter in parameters_of(_owner(name), [(name, value, "mm")])
    ]
    return model_of(
        IRB_120, *parameters, identified_from={"duration_s": 3600.0 * LASTED_H}, repeatability_mm=0.0
    )


def _owner(name):
    owners = {"drift": "base_drift", "tracker": "instrument_drift", "jump": "base_shift", "cell": "unnamed"}
    return owners[name.split("_")[0]]


def stops(time_s=None):
    times = None if time_s is None else np.full(N, float(time_s))
    return Stops(np.arange(N), configurations(N), time_s=times)


def after_h(hours):
    return stops(LAST_S + 3600.0 * hours)


def positions(made, asked):
    return predict(made, asked, NESTS)[0]


def uncertainties(made, asked):
    return predict(made, asked, NESTS)[1]


@pytest.mark.parametrize("name", DRIFTS.values())
@pytest.mark.parametrize("hours", [1e-3, DAY_H, MONTH_H])
def test_a_drift_is_held_where_the_last_reading_left_it(name, hours):
    made = model(**{name: 1e-3})

    assert positions(made, after_h(hours)) == pytest.approx(positions(made, after_h(0.0)), abs=1e-9)


@pytest.mark.parametrize("name", DRIFTS.values())
def test_before_the_first_reading_a_drift_has_not_begun(name):
    made = model(**{name: 1e-3})

    assert positions(made, stops(ORIGIN_S - 7200.0)) == pytest.approx(positions(model(), stops()), abs=1e-9)


@pytest.mark.parametrize("hours", [0.01, LASTED_H, DAY_H, MONTH_H])
def test_the_uncertainty_grows_as_a_slope_that_may_stay_and_a_walk(hours):
    made = model(drift_linear_x=RATE)

    # one axis of three
    expected = RATE * np.sqrt(hours * (hours + LASTED_H) / 3.0)
    for asked in (after_h(hours), stops(ORIGIN_S - 3600.0 * hours)):
        assert uncertainties(made, asked) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("hours", [DAY_H, MONTH_H])
def test_a_drift_that_goes_on_and_one_that_stops_are_within_the_band(hours):
    made = model(drift_linear_x=RATE)
    held, band = positions(made, after_h(hours)), 1.96 * uncertainties(made, after_h(hours))
    went_on = model_of(IRB_120, *made.parameters, identified_from={"duration_s": 3600.0 * (LASTED_H + hours)})

    stopped, moved = positions(made, after_h(0.0)), positions(went_on, after_h(hours))
    assert np.linalg.norm(moved - stopped, axis=1) == pytest.approx(RATE * hours)
    for truth in (stopped, moved):
        assert np.all(np.abs(truth - held) <= band[:, None])


def test_within_the_campaign_a_drift_adds_no_uncertainty_of_its_own():
    made = model(drift_linear_x=RATE)

    for time_s in (ORIGIN_S, 0.5 * (ORIGIN_S + LAST_S), LAST_S):
        assert uncertainties(made, stops(time_s)) == pytest.approx(0.0, abs=1e-12)
        assert unpredictable(made, stops(time_s)) == ()


def test_the_rate_is_as_uncertain_beyond_as_within():
    known = model(drift_linear_x=0.0)
    doubtful = replace(known, covariance=np.array([[RATE**2]]))

    # held at its end the rate counts for the whole campaign, and as the slope that may stay
    expected = RATE * np.sqrt((LASTED_H**2 + DAY_H * (DAY_H + LASTED_H)) / 3.0)
    assert uncertainties(known, after_h(DAY_H)) == pytest.approx(0.0, abs=1e-12)
    assert uncertainties(doubtful, after_h(DAY_H)) == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("name", DRIFTS.values())
def test_a_row_without_a_time_is_a_campaign_length_after_the_last_reading(name):
    made = model(**{name: 1e-3})

    assert positions(made, stops()) == pytest.approx(positions(made, after_h(LASTED_H)), abs=1e-9)
    assert uncertainties(made, stops()) == pytest.approx(uncertainties(made, after_h(LASTED_H)))


@pytest.mark.parametrize("name", JUMPS.values())
def test_a_jump_has_happened_for_rows_without_a_time(name):
    made = replace(model(**{name: 1e-3}), covariance=np.array([[1e-8]]))

    assert positions(made, stops()) == pytest.approx(positions(made, after_h(0.0)), abs=1e-9)
    assert np.abs(positions(made, stops()) - positions(model(), stops())).max() > 1e-4
    assert uncertainties(made, stops()) == pytest.approx(uncertainties(made, after_h(MONTH_H)))
    assert np.all(uncertainties(made, stops()) > 0.0)


@pytest.mark.parametrize("name", JUMPS.values())
def test_nobody_is_told_of_a_jump_that_is_past(name):
    made = model(**{name: 1e-3})

    assert unpredictable(made, after_h(DAY_H)) == ()
    assert unpredictable(made, stops(ORIGIN_S - 1.0)) == ()


def test_what_settles_goes_to_its_end_by_its_own_law_and_surely():
    made = model(**{SETTLES: RATE})

    come = [positions(made, after_h(hours)) - positions(model(), stops()) for hours in (0.2, DAY_H)]
    ways = [np.linalg.norm(way, axis=1) for way in come]
    tau_h = 1200.0 / 3600.0
    assert ways[0] == pytest.approx(RATE * tau_h * (1.0 - np.exp(-(LASTED_H + 0.2) / tau_h)), rel=1e-9)
    assert ways[1] == pytest.approx(RATE * tau_h, rel=1e-9)
    assert positions(made, stops()) == pytest.approx(positions(made, after_h(DAY_H)), abs=1e-9)
    assert uncertainties(made, after_h(DAY_H)) == pytest.approx(0.0, abs=1e-12)
    assert unpredictable(made, after_h(DAY_H)) == ()


@pytest.mark.parametrize("effect", DRIFTS)
def test_the_sentence_says_who_is_held_and_in_how_many_rows(effect):
    made = model(**{DRIFTS[effect]: 1e-3})
    times = np.array([ORIGIN_S - 60.0, ORIGIN_S, LAST_S, LAST_S + 1.0, LAST_S + 1e6])

    (sentence,) = map(english, unpredictable(made, replace(stops(), time_s=times)))

    assert sentence.startswith(f"{effect} was observed only between the first and last readings")
    assert (
        "3 of 5 rows fall before or after that period; the first or last observed value is used" in sentence
    )


def test_a_model_that_says_nothing_of_its_campaign_lasted_an_hour():
    made = replace(model(drift_linear_x=RATE), identified_from={})

    asked = stops(ORIGIN_S + 2.0 * 3600.0)
    assert positions(made, asked) - positions(model(), stops()) == pytest.approx(
        positions(made, stops(ORIGIN_S + 3600.0)) - positions(model(), stops()), abs=1e-9
    )
    assert uncertainties(made, asked) == pytest.approx(RATE * np.sqrt(2.0 / 3.0), rel=1e-6)


def test_an_arm_that_neither_drifts_nor_jumps_is_known_for_ever():
    parameters = (Parameter("a_3", "geometry", 0.5, "mm", 0.1, 1.0),)
    made = replace(model_of(IRB_120, *parameters), covariance=np.array([[0.01]]))

    assert unpredictable(made, after_h(MONTH_H)) == unpredictable(made, stops()) == ()
    assert uncertainties(made, after_h(MONTH_H)) == pytest.approx(uncertainties(made, stops()))
