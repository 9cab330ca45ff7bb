"""Relative accuracy: errors that a base somewhere else would hide."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of, plain_parameters
from tests.helpers.identification.synthetic import (
    configurations,
    leg_campaign,
    measured,
    nominal_campaign,
)
from truepose.domain.campaign import PointReadings, Stops
from truepose.identification import identify, predict
from truepose.identification.verdict.relative_accuracy import rigid_motions
from truepose.kinematics.frames import rotation_from_vector
from truepose.validation.validate import validate

MODEL = model_of(IRB_120, *plain_parameters(IRB_120))
N = 60


def readings(shift_mm=(0.0, 0.0, 0.0), turn_rad=(0.0, 0.0, 0.0), noise_mm=0.0, n=N):
    stops, nest = Stops(np.arange(n), configurations(n)), 1 + np.arange(n) % 2
    places, _ = predict(MODEL, stops, nest)
    moved = places @ rotation_from_vector(np.array(turn_rad)).T + shift_mm
    moved += noise_mm * np.random.default_rng(0).standard_normal(moved.shape)
    return PointReadings(stops, nest, moved, np.full(n, 0.01))


def test_a_base_that_stands_elsewhere_costs_absolute_accuracy_and_nothing_else():
    found = validate(MODEL, readings((0.3, -0.2, 0.1), (2e-4, 0.0, -1e-4)))

    assert found.position.identified.mean_mm > 0.3
    assert found.relative.identified.max_mm == pytest.approx(0.0, abs=1e-9)


def test_without_a_shift_both_are_the_noise():
    found = validate(MODEL, readings(noise_mm=0.02))

    assert found.relative.identified.mean_mm == pytest.approx(found.position.identified.mean_mm, rel=0.1)
    assert found.relative.identified.rms_mm <= found.position.identified.rms_mm


def test_three_readings_are_too_few_to_align():
    assert validate(MODEL, readings(n=3)).relative is None


def test_an_identification_says_what_the_held_out_positions_show_relatively():
    campaign, _ = measured(nominal_campaign())
    held_out = campaign.calibration.taken(np.arange(40, 60))
    rest = replace(campaign, calibration=campaign.calibration.taken(np.arange(40)), validation=held_out)
    moved = replace(held_out, position_mm=held_out.position_mm + np.array([0.5, 0.0, 0.0]))

    as_read, elsewhere = (identify(replace(rest, validation=points)) for points in (held_out, moved))

    assert as_read.relative.identified.n == 20
    assert elsewhere.validation.identified.mean_mm > 0.4
    assert elsewhere.relative.identified.mean_mm == pytest.approx(as_read.relative.identified.mean_mm)


def test_without_held_out_readings_each_counts_against_a_model_that_never_saw_it():
    answer = identify(measured(nominal_campaign())[0])

    assert answer.relative.identified.n == 60
    assert answer.relative.identified.rms_mm < answer.cross_validation.identified.rms_mm
    assert answer.relative.identified.rms_mm > 0.9 * answer.cross_validation.identified.rms_mm


def test_lengths_have_no_place_to_align():
    assert identify(leg_campaign(), ["tool", "geometry"]).relative is None


def test_rigid_motions_are_shifts_and_turns_about_the_middle_of_one_size():
    places = np.array([[10.0, 0.0, 0.0], [30.0, 0.0, 0.0], [20.0, 40.0, 0.0], [20.0, -40.0, 0.0]])

    motions = rigid_motions(places).reshape(4, 3, 6)

    assert motions[:, :, :3] == pytest.approx(np.tile(np.eye(3), (4, 1, 1)))
    about_z = [[0.0, -0.25, 0.0], [0.0, 0.25, 0.0], [-1.0, 0.0, 0.0], [1.0, 0.0, 0.0]]
    assert motions[:, :, 5] == pytest.approx(np.array(about_z))
    assert motions[2, :, 3:5] == pytest.approx(np.array([[0.0, 0.0], [0.0, 0.0], [1.0, 0.0]]))
    assert rigid_motions(places[:1]) == pytest.approx(np.eye(3, 6))
