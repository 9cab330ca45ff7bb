"""Causes that lengths show: the ballbar's zero, its scale, a fixture that moved."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.leg_scenes import (
    CADENCE_S,
    PER_INITIALISATION,
    N,
    leg_problem,
    leg_scene,
    telling_legs,
)
from tests.helpers.diagnosis.point_scenes import rows_at_start, telling_scene
from tests.helpers.identification.synthetic import leg_campaign
from truepose.effects.causes import FittedCause
from truepose.effects.ports import PortKind
from truepose.effects.registry import CAUSES
from truepose.messages.catalogue import english


def rows(campaign=None):
    return rows_at_start(leg_problem(campaign))


@pytest.mark.parametrize("cause", ["ballbar_zero", "fixture_shift"])
def test_positions_show_nothing_of_a_ballbar(cause):
    assert "no ballbar lengths" in english(CAUSES[cause].unseen(telling_scene()))
    assert CAUSES[cause].candidates(telling_scene()) == ()


def test_a_zero_needs_initialisations_that_are_known():
    unnumbered = telling_legs(initialisation=None)

    assert "(init)" in english(CAUSES["ballbar_zero"].unseen(leg_scene(unnumbered)))
    assert CAUSES["ballbar_zero"].candidates(leg_scene(unnumbered)) == ()


def test_the_one_zero_of_a_wire_of_unknown_length_is_its_length():
    once = replace(telling_legs(initialisation=np.ones(N, dtype=np.int64)), ballbar_nominal_mm=None)

    assert "initialise the ballbar repeatedly" in english(CAUSES["ballbar_zero"].unseen(leg_scene(once)))


def test_zeros_are_constants_or_grow_where_times_are_known():
    constant, growing = CAUSES["ballbar_zero"].candidates(leg_scene())
    (alone,) = CAUSES["ballbar_zero"].candidates(leg_scene(telling_legs(stops=leg_campaign(N).legs.stops)))

    assert constant.names == tuple(f"zero_{number}" for number in range(1, 11))
    assert growing.names[1] == "zerorate_2_240.000"
    assert alone == constant


@pytest.mark.parametrize(
    ("later_s", "earlier_s", "outside"),
    [(0.0, 0.0, []), (5e-4, 5e-4, []), (2e-3, 0.0, [0]), (0.0, 2e-3, [-1])],
)
def test_a_zero_of_a_model_acts_in_its_own_session_within_the_rounding_of_times(later_s, earlier_s, outside):
    known = rows()
    own = known.initialisation == 2
    first, *_, last = known.stops.time_s[own]

    (term,) = CAUSES["ballbar_zero"].terms(
        ("zero_2",), known._replace(origin_s=first + later_s, last_s=last - earlier_s)
    )

    expected = np.ones(own.sum())
    expected[outside] = 0.0
    assert term.weight[own].tolist() == expected.tolist()


def test_a_zero_acts_after_its_initialisation_and_grows_from_the_first_reading_after_it():
    constant, growing = CAUSES["ballbar_zero"].terms(("zero_2", "zerorate_2_240.000"), rows())

    here = np.arange(N) // PER_INITIALISATION == 1
    assert constant.weight == pytest.approx(here.astype(float))
    hours = CADENCE_S * (np.arange(N) - 6) / 3600.0
    assert growing.weight == pytest.approx(np.where(here, hours, 0.0))
    assert constant.port == growing.port
    assert constant.port.kind is PortKind.LENGTH


def test_lengths_of_unknown_initialisation_or_time_have_no_zero():
    unknown = telling_legs(initialisation=None)
    untimed = telling_legs(stops=leg_campaign(N).legs.stops)

    (constant,) = CAUSES["ballbar_zero"].terms(("zero_2",), rows(unknown))
    (growing,) = CAUSES["ballbar_zero"].terms(("zerorate_2_240.000",), rows(untimed))

    assert not constant.weight.any()
    assert not growing.weight.any()


@pytest.mark.parametrize("away_s", [86_400.0, -86_400.0])
def test_of_a_made_model_an_initialisation_of_another_day_is_another_one(away_s):
    names = ("zero_2", "zerorate_2_240.000")
    of_model = rows()._replace(origin_s=0.0, last_s=CADENCE_S * (N - 1))
    stops = replace(of_model.stops, time_s=of_model.stops.time_s + away_s)

    there = CAUSES["ballbar_zero"].terms(names, of_model)
    elsewhere = CAUSES["ballbar_zero"].terms(names, of_model._replace(stops=stops))

    assert all(term.weight.any() for term in there)
    assert not any(term.weight.any() for term in elsewhere)


def test_a_zero_is_shown_as_its_root_mean_square():
    constant, growing = CAUSES["ballbar_zero"].candidates(leg_scene())
    values = 0.006 * (-1.0) ** np.arange(10)

    still = CAUSES["ballbar_zero"].describe(
        "ballbar", FittedCause(constant.names, values, 1e-14 * np.eye(10)), leg_scene()
    )
    grown = CAUSES["ballbar_zero"].describe(
        "ballbar", FittedCause(growing.names, np.full(10, 0.09), 1e-14 * np.eye(10)), leg_scene()
    )

    assert (still.amplitude, still.unit) == (pytest.approx(0.006), "mm")
    assert still.standard_uncertainty == pytest.approx(0.006 / np.sqrt(20.0), rel=1e-3)
    assert "is off by 6.0 \u00b5m" in english(still.sentence)
    assert grown.amplitude == pytest.approx(0.09 * 5 * CADENCE_S / 3600.0)
    assert "drifts by" in english(grown.sentence)


def test_noise_in_the_zeros_is_not_taken_for_their_size():
    constant, _ = CAUSES["ballbar_zero"].candidates(leg_scene())
    rng = np.random.default_rng(4)
    values = 0.004 * rng.standard_normal(10)

    shown = CAUSES["ballbar_zero"].describe(
        "ballbar", FittedCause(constant.names, values, 0.004**2 * np.eye(10)), leg_scene()
    )

    assert shown.amplitude < 3.0 * shown.standard_uncertainty


def test_the_scale_of_a_ballbar_acts_on_each_length_in_proportion():
    campaign = telling_legs()

    (term,) = CAUSES["instrument_scale"].terms(("ballbar_scale",), rows(campaign))

    assert term.weight == pytest.approx(campaign.legs.length_mm)
    assert term.port.kind is PortKind.LENGTH
    assert [spec.name for spec in CAUSES["instrument_scale"].specs(leg_scene().setting)] == ["ballbar_scale"]


def test_a_fixture_may_move_between_stops_of_one_placement_with_twelve_lengths_on_either_side():
    candidates = CAUSES["fixture_shift"].candidates(leg_scene())

    assert [candidate.subject for candidate in candidates] == ["placement 1"] * 7 + ["placement 2"] * 7
    middles = CADENCE_S * (np.arange(11, 18) + 0.5)
    assert [candidate.variant for candidate in candidates[:7]] == pytest.approx(middles.tolist())
    assert candidates[0].names[0] == "fixture_1_460_x"
    present = leg_scene().present | {candidates[0].names[0]}
    assert len(CAUSES["fixture_shift"].candidates(leg_scene(present=present))) == 13


def test_short_placements_show_no_move():
    short = telling_legs(placement=1 + np.arange(N) // 20)

    assert "too few lengths" in english(CAUSES["fixture_shift"].unseen(leg_scene(short)))


def test_a_fixture_acts_through_its_own_placement_from_its_time_on():
    (term,) = CAUSES["fixture_shift"].terms(("fixture_2_1620_ry",), rows())

    assert (term.port.kind, term.port.number) == (PortKind.FIXTURE, 10)
    assert term.weight == pytest.approx((CADENCE_S * np.arange(N) >= 1620.0).astype(float))


def test_a_fixture_is_shown_to_move_as_far_as_it_does_where_it_stands():
    here = leg_scene()
    centre = here.fixtures_mm[1]
    turn = np.array([0.0, 0.0, 2e-4])
    assert centre == pytest.approx([250.0, -450.0, -80.0], abs=5.0)  # the base nest, as lengths place it
    names = CAUSES["fixture_shift"].candidates(here)[0].names
    about_centre = np.concatenate([np.array([0.05, 0.0, 0.0]) - np.cross(turn, centre), turn])

    shown = CAUSES["fixture_shift"].describe(
        "placement 1", FittedCause(names, about_centre, 1e-16 * np.eye(6)), here
    )

    assert shown.amplitude == pytest.approx(0.05, rel=1e-3)
    assert next(d for d in shown.details if d.name == "rotation").value == pytest.approx(
        np.rad2deg(2e-4), rel=1e-3
    )
    assert "during placement 1, by 0.050 mm" in english(shown.sentence)
