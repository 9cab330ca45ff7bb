"""Causes that run or happen in time: drifts of base and tracker, jumps of the base."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import (
    ORIGIN_S,
    START,
    rows_at_start,
    telling_campaign,
    telling_problem,
    telling_scene,
)
from truepose.domain.campaign import Stops
from truepose.effects.causes import FittedCause
from truepose.effects.motions import Motion, Widths, gaps, motion_specs
from truepose.effects.ports import PortKind
from truepose.effects.registry import CAUSES
from truepose.identification.problem.build import build
from truepose.messages.catalogue import english

DRIFTS = ("base_drift", "instrument_drift")
FIRST_S = ORIGIN_S - 10.0  # the first look at a fixed nest
CADENCE_S = 30.0


def with_stops(scene, **columns):
    return replace(scene, stops=replace(scene.stops, **columns))


def with_times(campaign, time_s):
    readings = campaign.calibration
    return replace(
        campaign, calibration=replace(readings, stops=replace(readings.stops, time_s=time_s)), reference=None
    )


def rows(campaign=None):
    return rows_at_start(telling_problem() if campaign is None else build(campaign, START))


def six(prefix, vector, spread=1e-6):
    names = tuple(spec.name for spec in motion_specs(prefix, Widths(1.0, 1.0)))
    return FittedCause(names, np.array(vector, dtype=float), spread**2 * np.eye(6))


@pytest.mark.parametrize("cause", [*DRIFTS, "base_shift"])
def test_nothing_that_runs_in_time_is_seen_without_times(cause):
    for times in (None, np.full(24, np.nan), np.full(24, 7.0)):
        scene = with_stops(telling_scene(), time_s=times)

        assert "record when each was taken" in english(CAUSES[cause].unseen(scene))
        assert CAUSES[cause].candidates(scene) == ()


@pytest.mark.parametrize("cause", DRIFTS)
def test_a_drift_is_even_or_settles_with_a_time_constant_that_the_measurements_can_tell(cause):
    scene = telling_scene()  # 700 s from the first look at a fixed nest to the last reading

    variants = [candidate.variant for candidate in CAUSES[cause].candidates(scene)]

    assert variants == [0.0, 75.0, 150.0, 300.0, 600.0]


@pytest.mark.parametrize("cause", [*DRIFTS, "base_shift"])
def test_what_the_model_has_in_time_is_no_candidate(cause):
    scene = telling_scene()
    candidates = CAUSES[cause].candidates(scene)

    left = CAUSES[cause].candidates(replace(scene, present=scene.present | set(candidates[1].names)))

    assert [candidate.names for candidate in left] == [
        candidate.names for candidate in candidates if candidate != candidates[1]
    ]


@pytest.mark.parametrize(("cause", "prefix"), [("base_drift", "drift"), ("instrument_drift", "tracker")])
def test_an_even_drift_goes_its_rate_times_the_hours_since_the_first_reading(cause, prefix):
    (term,) = CAUSES[cause].terms((f"{prefix}_linear_y",), rows())

    hours = (ORIGIN_S + CADENCE_S * np.arange(24) - FIRST_S) / 3600.0
    assert term.weight == pytest.approx(hours)
    assert term.port.number == 1


def test_a_settling_drift_starts_with_its_rate_and_ends_after_rate_times_time_constant():
    campaign = with_times(telling_campaign(), np.concatenate([[0.0, 1e-3], np.full(22, 1e6)]))

    (term,) = CAUSES["base_drift"].terms(("drift_exp1200_x",), rows(campaign))

    assert term.weight[1] == pytest.approx(1e-3 / 3600.0, rel=1e-5)
    assert term.weight[-1] == pytest.approx(1200.0 / 3600.0)


@pytest.mark.parametrize("name", ["drift_linear_rx", "drift_exp600_z"])
def test_a_row_without_a_time_is_left_where_it_is(name):
    times = np.arange(24.0)
    times[5] = np.nan

    (term,) = CAUSES["base_drift"].terms((name,), rows(with_times(telling_campaign(), times)))

    assert term.weight[5] == 0.0
    assert np.isfinite(term.weight).all()
    assert term.weight[6] > 0.0


@pytest.mark.parametrize(
    ("name", "come_s"),
    [
        ("drift_linear_x", lambda after: np.clip(after, 0.0, 600.0)),
        ("drift_exp600_x", lambda after: 600.0 * (1.0 - np.exp(-np.maximum(after, 0.0) / 600.0))),
    ],
)
def test_of_a_made_model_an_even_drift_stands_where_nobody_followed_it(name, come_s):
    known = rows(with_times(telling_campaign(), 60.0 * np.arange(24.0)))

    (term,) = CAUSES["base_drift"].terms((name,), known._replace(origin_s=300.0, last_s=900.0))

    assert term.weight == pytest.approx(come_s(60.0 * np.arange(24.0) - 300.0) / 3600.0)


def test_a_jump_leaves_rows_without_a_time_where_they_were_before():
    times = np.arange(24.0)
    times[20] = np.nan

    (term,) = CAUSES["base_shift"].terms(("jump_11.5_rz",), rows(with_times(telling_campaign(), times)))

    assert term.weight.tolist() == [0.0] * 12 + [1.0] * 8 + [0.0] + [1.0] * 3
    assert (term.port.kind, term.port.number) == (PortKind.MOTION, 5)


@pytest.mark.parametrize("cause", DRIFTS)
def test_a_drift_is_shown_as_the_length_of_its_shift_per_hour(cause):
    (linear, *_) = CAUSES[cause].candidates(telling_scene())
    fitted = FittedCause(linear.names, np.array([0.03, -0.06, 0.06, 0.0, 4e-5, 3e-5]), 1e-18 * np.eye(6))

    shown = CAUSES[cause].describe(linear.subject, fitted, telling_scene())

    assert shown.amplitude == pytest.approx(0.09)
    assert shown.unit == "mm/h"
    rotation = next(detail for detail in shown.details if detail.name == "rotation")
    assert (rotation.value, rotation.unit) == (pytest.approx(np.rad2deg(5e-5)), "deg/h")
    assert "0.090 mm/h" in english(shown.sentence)


def test_a_settling_drift_is_shown_as_its_mean_rate_over_the_measurements():
    scene = replace(telling_scene(), origin_s=ORIGIN_S + CADENCE_S * 23 - 1200.0)  # 1200 s before the last
    fitted = six("drift_exp600", [0.3, 0.0, 0.0, 0.0, 0.0, 0.0])

    shown = CAUSES["base_drift"].describe("base", fitted, scene)

    way = 0.3 * 600.0 / 3600.0 * (1.0 - np.exp(-2.0))
    assert shown.amplitude == pytest.approx(way / (1200.0 / 3600.0), rel=1e-6)
    assert "time constant of 10 min" in english(shown.sentence)
    assert next(d for d in shown.details if d.name == "time_constant").value == 600.0


def test_two_shapes_of_one_drift_are_added_up():
    scene = telling_scene()
    linear, settling = six("drift_linear", [0.1, 0, 0, 0, 0, 0]), six("drift_exp300", [-0.1, 0, 0, 0, 0, 0])
    both = FittedCause(
        linear.names + settling.names,
        np.concatenate([linear.values, settling.values]),
        np.diag(np.full(12, 1e-12)),
    )

    shown = CAUSES["base_drift"].describe("base", both, scene)

    share = 300.0 / 700.0 * (1.0 - np.exp(-700.0 / 300.0))  # of the settling one's first rate, over 700 s
    assert shown.amplitude == pytest.approx(0.1 * (1.0 - share), rel=1e-6)


def test_without_fixed_nests_a_moving_tracker_and_a_moving_base_name_each_other():
    alone = replace(telling_scene(), reference_s=np.zeros(0))
    for cause, prefix, other in (
        ("instrument_drift", "tracker_linear", "cannot be distinguished from a moving base"),
        ("base_drift", "drift_linear", "cannot be distinguished from a drifting tracker"),
    ):
        fitted = six(prefix, [0.1, 0, 0, 0, 0, 0])

        assert other in english(CAUSES[cause].describe("", fitted, alone).sentence)
        assert "cannot be distinguished" not in english(
            CAUSES[cause].describe("", fitted, telling_scene()).sentence
        )


def test_lengths_have_no_frame_that_could_drift():
    scene = replace(telling_scene(), legs=True)

    assert "measure positions" in english(CAUSES["instrument_drift"].unseen(scene))
    assert CAUSES["instrument_drift"].candidates(scene) == ()


def test_a_jump_may_lie_in_every_gap_that_leaves_four_positions_on_either_side():
    candidates = CAUSES["base_shift"].candidates(telling_scene())

    middles = ORIGIN_S + CADENCE_S * (np.arange(3, 20) + 0.5)
    assert [candidate.variant for candidate in candidates] == pytest.approx(middles.tolist())
    assert candidates[0].names[0] == "jump_1105_x"


def test_readings_of_one_stop_have_no_gap_between_them():
    stops = Stops(np.repeat(np.arange(6), 3), np.zeros((18, 6)), time_s=np.arange(18.0))

    found = gaps(stops, np.ones(18, dtype=bool), least_readings=4)

    assert [gap.middle_s for gap in found] == [5.5, 8.5, 11.5]


@pytest.mark.parametrize("step_s", [1e-3, 0.7, 30.0, 86400.0])
@pytest.mark.parametrize("start_s", [-50.0, 0.0, 1.7e9])
def test_the_time_in_a_name_lies_within_its_gap(step_s, start_s):
    time_s = start_s + step_s * np.arange(12)

    found = gaps(Stops(np.arange(12), np.zeros((12, 6)), time_s=time_s), np.ones(12, dtype=bool), 4)

    assert len(found) == 5
    for gap, before, after in zip(found, time_s[3:], time_s[4:], strict=False):
        assert before < float(gap.label) < after


def test_long_campaigns_are_searched_at_most_in_120_gaps():
    n = 1000
    stops = Stops(np.arange(n), np.zeros((n, 6)), time_s=CADENCE_S * np.arange(n))

    candidates = CAUSES["base_shift"].candidates(replace(telling_scene(), stops=stops))

    assert 100 <= len(candidates) <= 120


def test_a_jump_is_shown_with_its_size_and_its_time_as_well_as_the_gap_tells_it():
    fitted = six("jump_1105", [0.0, 0.08, 0.0, 1e-4, 0.0, 0.0])

    shown = CAUSES["base_shift"].describe("base", fitted, telling_scene())

    assert shown.amplitude == pytest.approx(0.08)
    assert (shown.details[0].name, shown.details[0].value) == ("time", 1105.0)
    assert shown.details[0].standard_uncertainty == pytest.approx(CADENCE_S / np.sqrt(12.0))
    assert "115 s after the first reading" in english(shown.sentence)


def test_of_two_jumps_the_larger_is_the_amplitude():
    one, two = six("jump_1105", [0.03, 0, 0, 0, 0, 0]), six("jump_1405", [0, 0, -0.07, 0, 0, 0])
    both = FittedCause(one.names + two.names, np.concatenate([one.values, two.values]), 1e-12 * np.eye(12))

    shown = CAUSES["base_shift"].describe("base", both, telling_scene())

    assert shown.amplitude == pytest.approx(0.07)
    assert [detail.value for detail in shown.details if detail.name == "time"] == [1105.0, 1405.0]
    assert "jumped 2 times" in english(shown.sentence)


def test_too_few_readings_show_no_jump():
    campaign = telling_campaign(n=24)
    scene = telling_scene(campaign=campaign)
    few = replace(
        scene.stops,
        **{
            name: getattr(scene.stops, name)[:7]
            for name in ("config", "joints_rad", "direction", "time_s", "temperature_c", "attachment")
        },
    )

    assert "too few readings" in english(CAUSES["base_shift"].unseen(replace(scene, stops=few)))


def test_a_turn_moves_a_point_by_its_arm():
    motion = Motion(np.array([1.0, 2.0, 3.0, 0.0, 0.0, 1e-3]), np.eye(6))

    there = motion.seen_at(np.array([100.0, 50.0, -20.0]))

    assert there.vector[:3] == pytest.approx([1.0 - 0.05, 2.0 + 0.1, 3.0])
    assert there.covariance[0, 0] == pytest.approx(1.0 + 20.0**2 + 50.0**2)
