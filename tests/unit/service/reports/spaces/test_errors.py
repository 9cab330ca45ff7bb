"""Errors in space: the worst pose first, and nothing where nothing is off."""

import numpy as np
import pytest

from tests.helpers.domain.builders import make_model
from tests.unit.service.reports.conftest import measured, stops_at_random
from truepose.domain.campaign import PointReadings
from truepose.identification import predict
from truepose.reports.error_vectors_3d import error_space


@pytest.fixture(scope="module")
def space():
    generator = np.random.default_rng(3)
    return error_space(make_model(), measured(generator, stops_at_random(generator, 40)))


def test_the_arm_is_shown_where_the_identified_model_is_worst(space):
    after = np.linalg.norm(space.after_mm, axis=1)

    assert [pose.after_mm for pose in space.poses] == sorted(after, reverse=True)[: len(space.poses)]
    assert space.poses[0].config == 1 + int(np.argmax(after))


def test_arrows_are_seen_minus_foreseen(space):
    generator = np.random.default_rng(3)
    readings = measured(generator, stops_at_random(generator, 40))

    assert space.points_mm + space.after_mm == pytest.approx(readings.position_mm, abs=1e-9)


def test_a_model_that_is_right_has_no_arrows():
    stops = stops_at_random(np.random.default_rng(5), 10)
    nest = np.ones(len(stops), np.int64)
    exact, _ = predict(make_model(), stops, nest)

    space = error_space(make_model(), PointReadings(stops, nest, exact, np.full(len(stops), 0.01)))

    assert np.abs(space.after_mm).max() < 1e-9


def test_more_readings_than_can_be_seen_are_selected_evenly():
    generator = np.random.default_rng(6)

    space = error_space(make_model(), measured(generator, stops_at_random(generator, 1500)))

    assert (len(space.points_mm), space.total) == (500, 1500)
