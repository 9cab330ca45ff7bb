"""Rows that do not tell what an effect needs: said so, left out, and as uncertain as the effect is large."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.helpers.diagnosis.leg_scenes import telling_legs
from tests.helpers.diagnosis.point_scenes import telling_campaign
from truepose.domain.identification import Parameter
from truepose.identification import identify, judge, predict, unpredictable, unpredictable_readings
from truepose.identification.model.missing_input_uncertainty import Span, span_of
from truepose.messages.catalogue import english

ARM = ("base", "geometry")
COLUMNS = {
    "thermal_growth": {"temperature_c": None},
    "backlash": {"direction": None},
    "tool_reseating": {"attachment": None},
    "unnamed": {"move_rad": None, "time_s": None},
}
N = 60


@cache
def arm():
    return identify(telling_campaign(N), ARM).model


def model_with(effect, **values):
    """The arm's model with parameters of one effect, known exactly."""
    model = arm()
    added = tuple(Parameter(name, effect, value, "mm", 0.0, 1.0) for name, value in values.items())
    covariance = np.zeros((len(model.parameters) + len(added),) * 2)
    covariance[: len(model.parameters), : len(model.parameters)] = model.covariance
    return replace(
        model,
        effects=(*model.effects, effect),
        parameters=(*model.parameters, *added),
        shortfall=None,
        covariance=covariance,
    )


EXAMPLES = {
    "base_drift": {"drift_linear_x": 0.3},
    "instrument_drift": {"tracker_linear_y": 0.3},
    "thermal_growth": {"growth": 18e-6},
    "backlash": {"gap_2": 1e-3, "gap_5": 2e-3},
    "tool_reseating": {"seat_1_x": 0.1, "seat_2_x": -0.2, "seat_3_x": 0.05},
    "unnamed": {"cell_lag_2_line_share": 1e-3},
}


def rows(**columns):
    readings = telling_campaign(N).calibration
    first = readings.stops.move_rad.copy()
    first[0] = 0.0  # from where it stands
    return replace(readings.stops, **({"move_rad": first} | columns)), readings.nest


@pytest.mark.parametrize("effect", EXAMPLES)
def test_rows_that_tell_everything_leave_nothing_out(effect):
    stops, _ = rows(**({"attachment": 1 + np.arange(N) % 3} if effect == "tool_reseating" else {}))

    assert unpredictable(model_with(effect, **EXAMPLES[effect]), stops) == ()


@pytest.mark.parametrize("effect", COLUMNS)
def test_rows_without_the_column_leave_the_effect_out_and_are_less_certain(effect):
    model = model_with(effect, **EXAMPLES[effect])
    stops, nest = rows(**COLUMNS[effect])

    (sentence,) = map(english, unpredictable(model, stops))
    position, uncertainty = predict(model, stops, nest)

    plain, known = predict(arm(), stops, nest)
    assert sentence.startswith(f"{effect} needs ")
    assert f"which {N} of {N} rows lack: the effect is omitted for these rows" in sentence
    assert position == pytest.approx(plain, abs=1e-9)
    assert np.all(uncertainty > known)


def test_only_the_rows_that_lack_it_are_less_certain():
    model = model_with("thermal_growth", growth=18e-6)
    stops, nest = rows()
    some = stops.temperature_c.copy()
    some[10:13] = np.nan

    told, before = predict(model, stops, nest)
    position, after = predict(model, replace(stops, temperature_c=some), nest)

    lacking = np.isin(np.arange(N), [10, 11, 12])
    assert "3 of 60 rows" in english(unpredictable(model, replace(stops, temperature_c=some))[0])
    assert np.all(after[lacking] > before[lacking])
    assert after[~lacking] == pytest.approx(before[~lacking])
    assert position[~lacking] == pytest.approx(told[~lacking])


def test_a_gap_adds_half_of_itself_times_the_lever_whatever_the_other_joints_do():
    one, two, both = (
        model_with("backlash", **gaps)
        for gaps in ({"gap_2": 1e-3}, {"gap_5": 2e-3}, {"gap_2": 1e-3, "gap_5": 2e-3})
    )
    stops, nest = rows(direction=None)

    def added(model):
        return predict(model, stops, nest)[1] ** 2 - predict(arm(), stops, nest)[1] ** 2

    # Directions of two joints agree as often as not: squares add, but for products of two angles of a
    # milliradian with each other, and levers of a metre are seen.
    assert added(both) == pytest.approx(added(one) + added(two), rel=1e-2)
    assert np.sqrt(3.0 * added(one).max()) == pytest.approx(0.5e-3 * 600.0, rel=0.5)


def test_a_joint_that_lags_adds_its_share_of_a_usual_move():
    model = model_with("unnamed", cell_lag_2_line_share=1e-3)
    stops, nest = rows(move_rad=None, time_s=None)

    added = predict(model, stops, nest)[1] ** 2 - predict(arm(), stops, nest)[1] ** 2

    # Joint 2 is drawn from about 160 deg: moves of 65 deg (root mean square), at levers up to 0.7 m.
    assert np.sqrt(3.0 * added.max()) == pytest.approx(1e-3 * 1.14 * 650.0, rel=0.5)


def test_rows_in_the_order_of_time_tell_their_moves_themselves():
    model = model_with("unnamed", cell_lag_2_line_share=1e-3)
    stops, _ = rows(move_rad=None, direction=None)

    (sentence,) = map(english, unpredictable(model, stops))

    assert "the previous configuration (time_s in all rows), which 1 of 60 rows lack" in sentence


def test_joints_that_have_no_gap_may_come_from_anywhere():
    stops, _ = rows()
    unknown = stops.direction.copy()
    unknown[:, 0] = 0
    joint_2 = replace(stops, direction=unknown)
    unknown_2 = replace(stops, direction=np.where(np.arange(6) == 1, 0, stops.direction))

    assert unpredictable(model_with("backlash", gap_2=1e-3), joint_2) == ()
    assert len(unpredictable(model_with("backlash", gap_2=1e-3), unknown_2)) == 1


def test_a_mounting_that_the_model_was_not_made_with_is_unpredictable():
    model = model_with("tool_reseating", **EXAMPLES["tool_reseating"])
    stops, nest = rows(attachment=np.where(np.arange(N) < 20, 1, 9))

    (sentence,) = map(english, unpredictable(model, stops))
    _, uncertainty = predict(model, stops, nest)

    assert "needs an attachment that occurs in the model's data, which 40 of 60 rows lack" in sentence
    _, known = predict(arm(), stops, nest)
    added = uncertainty**2 - known**2
    # A seat of 0.1 mm in 300 mm changes the levers of the parameters, and so their share, by 3e-4 at most.
    slack = 1e-3 * float((known**2).max())
    assert added[:20] == pytest.approx(0.0, abs=slack)
    seats = np.array([0.1, -0.2, 0.05])
    assert added[20:] == pytest.approx(np.mean(seats**2) / 3.0, abs=slack)


def test_two_effects_that_need_the_same_are_both_named():
    model = model_with("base_drift", drift_linear_x=0.3)
    model = replace(
        model,
        effects=(*model.effects, "base_shift"),
        shortfall=None,
        parameters=(*model.parameters, Parameter("jump_1500_y", "base_shift", 0.1, "mm", 0.0, 1.0)),
        covariance=np.pad(model.covariance, (0, 1)),
    )

    sentences = [english(sentence) for sentence in unpredictable(model, rows(time_s=None)[0])]

    assert [sentence.split()[0] for sentence in sentences] == ["base_drift", "base_shift"]
    assert all(
        "60 of 60 rows lack: these rows are treated as later than the last reading" in line
        for line in sentences
    )


def test_readings_that_judge_a_model_belong_to_its_campaign():
    campaign = telling_campaign(N)
    later = campaign.calibration.stops.time_s + 4000.0
    stops = replace(campaign.calibration.stops, time_s=later)
    judged = replace(campaign, validation=replace(campaign.calibration, stops=stops))

    model = identify(judged, ARM).model

    assert model.identified_from["duration_s"] == later[-1] - model.origin_s


def test_a_model_says_how_long_and_at_which_temperatures_it_was_measured():
    model = arm()
    stops, _ = rows()

    span = span_of(model.identified_from)

    assert span.duration_s == pytest.approx(stops.time_s[-1] - model.origin_s)
    assert (span.lowest_c, span.highest_c) == (stops.temperature_c.min(), stops.temperature_c.max())


@pytest.mark.parametrize("said", [{}, {"duration_s": "long"}])
def test_a_model_that_does_not_say_so_was_measured_in_a_workshop_in_an_hour(said):
    assert span_of(said) == Span(3600.0, 15.0, 30.0)


def test_positions_know_nothing_of_a_ballbar_but_lengths_do():
    campaign = telling_legs()
    model = identify(campaign, ("tool", "geometry", "ballbar_zero")).model
    unseen = replace(campaign.legs, initialisation=np.full(len(campaign.legs), 99))

    (sentence,) = map(english, unpredictable_readings(model, unseen))

    assert "ballbar_zero needs an init that occurs in the model's data, which 60 of 60 rows lack" in sentence
    assert unpredictable(model, unseen.stops) == ()
    assert unpredictable_readings(model, campaign.legs) == ()
    next_day = replace(campaign.legs.stops, time_s=campaign.legs.stops.time_s + 86_400.0)
    (of_another,) = map(english, unpredictable_readings(model, replace(campaign.legs, stops=next_day)))
    assert "which 60 of 60 rows lack" in of_another
    assert np.isfinite(judge(model, unseen, 0.0).identified_mm).all()
