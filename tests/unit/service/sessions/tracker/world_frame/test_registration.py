"""The tracker's place in the world: exact without noise, and as far known as what it stands on."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.registered import CERTIFIED, ROTATION, draw, in_tracker
from tests.unit.service.sessions.tracker.fakes import FIXED_NESTS, TRACKER_AT
from truepose.domain.cell import CertifiedLength
from truepose.domain.robot import FixedNest
from truepose.messages.catalogue import english
from truepose.sessions.errors import AttentionNeededError
from truepose.sessions.tracker.registration import nest_mean, register, scale_sentence, to_tracker, to_world


def test_without_noise_the_motion_is_found_exactly():
    means = [nest_mean(np.array([place] * 5), np.zeros((5, 3, 3))) for place in in_tracker(CERTIFIED)]

    registration = register(means, FIXED_NESTS, two_face_mm=0.01)

    assert registration.rotation == pytest.approx(ROTATION, abs=1e-12)
    assert registration.translation_mm == pytest.approx(TRACKER_AT, abs=1e-9)
    assert registration.rms_mm < 1e-9
    assert registration.two_face_mm == 0.01


def test_there_and_back_is_where_one_started():
    registration = draw(np.random.default_rng(0))
    points = np.random.default_rng(1).uniform(-1000, 1000, (5, 3))

    assert to_tracker(registration, to_world(registration, points)) == pytest.approx(points, abs=1e-9)


def test_a_nest_with_a_poor_certificate_has_little_say():
    rng = np.random.default_rng(4)
    poor = (*FIXED_NESTS[:2], FixedNest(FIXED_NESTS[2].centre_mm, 5.0))
    extra = (*poor, FixedNest((-350.0, -500.0, 100.0), 0.002))
    true_nests = np.array([nest.centre_mm for nest in extra])
    true_nests[2] += (4.0, -3.0, 0.0)

    registration = draw(rng, true_nests, nests=extra)

    assert registration.rotation == pytest.approx(ROTATION, abs=2e-5)  # 0.02 mm over 1 m


@pytest.mark.parametrize(
    ("ppm", "sentence"),
    [(0.0, "scale agrees with the certified"), (200.0, "scale contradicts the certified")],
)
def test_the_scale_is_put_into_words(ppm, sentence):
    registration = draw(np.random.default_rng(1), scale=1.0 + ppm * 1e-6)

    assert sentence in english(scale_sentence(registration))


def test_without_a_certified_length_the_scale_is_not_verified():
    coarse = tuple(FixedNest(nest.centre_mm, 0.5) for nest in FIXED_NESTS)

    registration = draw(np.random.default_rng(1), nests=coarse)

    assert registration.scale is None
    assert english(scale_sentence(registration)).startswith("Scale not verified")


@pytest.mark.parametrize("n", [2, 20])
def test_what_the_instrument_states_is_the_covariance_of_the_mean(n):
    stated = np.diag([1e-4, 4e-4, 4e-4])
    points = np.random.default_rng(0).multivariate_normal(np.zeros(3), stated, n)

    mean = nest_mean(points, np.broadcast_to(stated, (n, 3, 3)))

    assert mean.covariance_mm2 == pytest.approx(stated / n)


@pytest.mark.parametrize("n", [2, 3, 4])
def test_a_few_readings_of_which_nothing_is_stated_speak_by_their_scatter(n):
    points = 0.05 * np.random.default_rng(0).standard_normal((n, 3))

    mean = nest_mean(points, np.full((n, 3, 3), math.nan))

    assert mean.covariance_mm2 == pytest.approx(np.cov(points, rowvar=False) / n)
    assert np.trace(mean.covariance_mm2) > 0.0


@pytest.mark.parametrize("stated", [math.nan, math.inf])
def test_one_reading_of_which_nothing_is_stated_is_refused(stated):
    with pytest.raises(AttentionNeededError, match="at least two readings"):
        nest_mean(np.zeros((1, 3)), np.full((1, 3, 3), stated))


@pytest.mark.parametrize("stated", [1e-6, math.nan])
def test_readings_that_scatter_far_more_than_is_stated_speak_for_themselves(stated):
    points = 0.05 * np.random.default_rng(0).standard_normal((20, 3))

    mean = nest_mean(points, np.broadcast_to(np.diag([stated] * 3), (20, 3, 3)))

    assert mean.covariance_mm2 == pytest.approx(np.cov(points, rowvar=False) / 20)


def length(first, second, u_mm=0.001):
    between = float(np.linalg.norm(CERTIFIED[first - 1] - CERTIFIED[second - 1]))
    return CertifiedLength((first, second), between, u_mm)


def test_certified_lengths_speak_for_the_scale_where_the_centres_are_coarse():
    coarse = tuple(FixedNest(nest.centre_mm, 0.5) for nest in FIXED_NESTS)
    errors = []
    for seed in range(300):
        rng = np.random.default_rng(seed)
        drawn = [length(*ends) for ends in ((1, 2), (2, 3), (3, 1))]
        off = [replace(one, length_mm=one.length_mm + 0.001 * rng.standard_normal()) for one in drawn]
        registration = draw(rng, scale=1.0 / (1.0 - 30e-6), nests=coarse, lengths=off)
        errors.append((registration.scale - 1.0 + 30e-6) / registration.scale_standard_uncertainty)

    # the spread of 300 draws is known to 4 %, four of these are allowed for
    assert np.std(errors) == pytest.approx(1.0, abs=0.17)
    assert abs(np.mean(errors)) < 4 / np.sqrt(300)


def test_a_length_that_is_itself_coarse_verifies_nothing():
    registration = draw(np.random.default_rng(1), lengths=[length(1, 2, u_mm=0.2)])

    assert registration.scale is None
