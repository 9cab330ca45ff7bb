"""Readings in columns: how far each is off, what was to be expected, what it may depend on."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.builders import make_model
from tests.unit.service.reports.conftest import TRACKER_MM, measured, stops_at_random
from truepose.kinematics.frames import placement_translation
from truepose.reports.reading_residuals import reading_residuals


@pytest.fixture(scope="module")
def readings():
    generator = np.random.default_rng(3)
    return measured(generator, stops_at_random(generator, 400))


@pytest.fixture(scope="module")
def found(readings):
    return reading_residuals(make_model(), readings)


def variable(found, name, joint=None):
    return next(one for one in found.variables if (one.name, one.joint) == (name, joint))


def test_each_reading_is_observed_minus_predicted(found, readings):
    places = np.column_stack([variable(found, axis).values for axis in "xyz"])

    assert places + found.after_mm == pytest.approx(readings.position_mm, abs=1e-9)
    assert (found.config == readings.stops.config).all()
    assert np.linalg.norm(found.before_mm, axis=1).mean() > 10 * np.linalg.norm(found.after_mm, axis=1).mean()


def test_what_is_expected_is_what_noise_and_scatter_show(found):
    seen = np.sqrt((found.after_mm**2).sum(axis=1).mean())

    assert found.expected_mm.min() >= np.sqrt(3) * TRACKER_MM
    assert seen == pytest.approx(np.sqrt(3) * TRACKER_MM, rel=0.05)


def test_variables_are_in_the_units_that_people_read(found, readings):
    at = readings.position_mm - found.after_mm - placement_translation(make_model().base)

    assert variable(found, "joint", 2).values == pytest.approx(np.rad2deg(readings.stops.joints_rad[:, 1]))
    assert variable(found, "reach").values == pytest.approx(np.linalg.norm(at, axis=1))
    assert variable(found, "number").values.tolist() == list(range(1, 401))


def test_only_what_was_recorded_is_a_variable(found, readings):
    n = len(readings)
    time_s = np.arange(n) * 30.0
    time_s[3] = np.nan
    stops = replace(
        readings.stops, time_s=600.0 + time_s, temperature_c=np.full(n, 21.5), attachment=np.ones(n, np.int64)
    )

    told = reading_residuals(make_model(), replace(readings, stops=stops))
    named = {one.name for one in told.variables} - {one.name for one in found.variables}

    assert named == {"time", "temperature"}  # the tool was mounted once: that explains nothing
    assert variable(told, "time").values[[0, 2, 3]] == pytest.approx([0.0, 1.0, np.nan], nan_ok=True)
