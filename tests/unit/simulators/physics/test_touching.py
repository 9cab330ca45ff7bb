"""How far gauges are pushed in: closed forms against what the words mean."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_simulators.physics.contacts import (
    ball_on_gauge_mm,
    ball_position_mm,
    probe_on_plane_mm,
    probe_on_sphere_mm,
    wire_mm,
)

DOWN = np.array([0.0, 0.0, -1.0])
UP = -DOWN
ORIGIN = np.zeros(3)


@given(beside=st.floats(-10.0, 10.0), height=st.floats(10.0, 30.0), tilt=st.floats(-0.3, 0.3))
def test_a_tip_that_gave_way_is_outside_the_sphere_by_both_radii(beside, height, tilt):
    axis = np.array([math.sin(tilt), 0.0, -math.cos(tilt)])
    tip = np.array([beside, 0.0, height])

    pushed_mm = probe_on_sphere_mm(tip, axis, ORIGIN, 16.0)

    if math.isfinite(pushed_mm):
        assert np.linalg.norm(tip - pushed_mm * axis) == pytest.approx(16.0, abs=1e-9)
        assert np.linalg.norm(tip - (pushed_mm + 1e-3) * axis) > 16.0  # it left outwards


def test_a_probe_above_the_pole_is_pushed_in_by_what_it_is_too_low():
    assert probe_on_sphere_mm(np.array([0.0, 0.0, 15.0]), DOWN, ORIGIN, 16.0) == pytest.approx(1.0)
    assert probe_on_sphere_mm(np.array([0.0, 0.0, 18.0]), DOWN, ORIGIN, 16.0) == pytest.approx(-2.0)


def test_a_probe_that_passes_beside_touches_nothing():
    assert probe_on_sphere_mm(np.array([17.0, 0.0, 15.0]), DOWN, ORIGIN, 16.0) == -math.inf
    assert probe_on_plane_mm(UP, UP, ORIGIN, UP, 0.0) == -math.inf
    assert ball_on_gauge_mm(np.array([20.0, 0.0, 1.0]), ORIGIN, UP, 15.0) == -math.inf


def test_a_leaning_probe_gives_way_further_than_it_is_too_low():
    lean = np.array([math.sin(0.2), 0.0, -math.cos(0.2)])

    pushed_mm = probe_on_plane_mm(np.array([5.0, 5.0, -1.0]), lean, ORIGIN, UP, 0.0)

    assert pushed_mm == pytest.approx(1.0 / math.cos(0.2))


def test_a_fixed_gauge_reads_along_its_direction_alone():
    assert ball_on_gauge_mm(np.array([3.0, -4.0, 1.5]), ORIGIN, UP, 15.0) == pytest.approx(1.5)


def test_a_wire_reads_beyond_its_zero():
    assert wire_mm(np.array([300.0, 400.0, 0.0]), ORIGIN, 450.0) == pytest.approx(50.0)


def test_a_sensor_sees_a_ball_along_its_own_axes():
    turned = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])  # 90 deg about z
    seen = [
        ball_position_mm(np.array([1.0, 1.0, 1.0]), turned, np.array([1.0, 3.0, 1.5]), axis)
        for axis in range(3)
    ]

    assert seen == pytest.approx([2.0, 0.0, 0.5])
