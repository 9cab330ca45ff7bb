"""Curves: the fitted cause over one variable, its band, and what each reading says of it on its own."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import ORIGIN_S, telling_campaign
from tests.helpers.diagnosis.selections import make_selected, make_start, proposed
from tests.helpers.domain.robots import IRB_120
from truepose.diagnosis.curves import finding_curve, remaining_curve
from truepose.diagnosis.evidence.residual_structure import Relation
from truepose.diagnosis.evidence.sensitivities import of_joint, seen

GAIN = ("joint_gain", "joint 4")


@pytest.fixture(scope="module")
def unexplained():
    return make_start({"joint_gain": {"gain_4": 1e-3}})


def curve_of(effects, *picked, **changes):
    start = make_start(effects, **changes)
    selected = make_selected(start, picked)
    return selected, finding_curve(selected, start.scene, selected.picks)


def scatter(curve):
    """Distances of the readings from the line in their own standard uncertainties."""
    return (curve.residual - np.interp(curve.x, curve.line_x, curve.line)) / curve.standard_uncertainty


def test_a_gain_is_a_line_through_zero_with_a_band_that_opens():
    selected, curve = curve_of({"joint_gain": {"gain_4": 1e-3}}, GAIN)

    row = selected.fit.structure.index_of("gain_4")
    spread = np.sqrt(selected.fit.solution.covariance[row, row])
    assert curve.variable == "angle of joint 4"
    assert curve.line == pytest.approx(selected.fit.values[row] * curve.line_x)
    assert curve.line_band == pytest.approx(1.96 * spread * np.abs(curve.line_x))


def test_the_band_of_a_wave_is_that_of_its_shape_its_mean_is_the_zero_of_the_joint():
    selected, curve = curve_of(
        {"joint_harmonics": {"wave_4_1_sin": 1e-3}}, ("joint_harmonics", "joint 4", "wave_4_1_sin")
    )

    rows = [selected.fit.structure.index_of(name) for name in selected.picks[0].names]
    angle = np.deg2rad(curve.line_x)
    about_mean = np.stack([wave - wave.mean() for wave in (np.sin(angle), np.cos(angle))])
    covariance = selected.fit.solution.covariance[np.ix_(rows, rows)]
    spread = np.sqrt(np.einsum("km,kl,lm->m", about_mean, covariance, about_mean))
    assert curve.line_band == pytest.approx(1.96 * np.rad2deg(spread))


@pytest.mark.parametrize(
    ("planted", "picked"),
    [
        ({"joint_gain": {"gain_4": 1e-3}}, GAIN),
        ({"joint_coupling": {"coupling_6_5": 2e-3}}, ("joint_coupling", "joint 6", "coupling_6_5")),
        ({"joint_harmonics": {"wave_4_4_sin": 1e-3}}, ("joint_harmonics", "joint 4", "wave_4_4_sin")),
        ({"backlash": {"gap_2": 4e-4}}, ("backlash", "joint 2")),
        ({"base_drift": {"drift_linear_x": 0.3}}, ("base_drift", "base", "drift_linear_x")),
        ({"thermal_growth": {"growth": 5e-5}}, ("thermal_growth", "links")),
        ({"nest_offset": {"offset_2_y": 0.1}}, ("nest_offset", "nest 2")),
        ({"payload": {"payload_mass": 0.5}}, ("payload", "tool")),
    ],
    ids=lambda value: value[0] if isinstance(value, tuple) else "",
)
def test_readings_scatter_about_the_line_as_they_state(planted, picked):
    _, curve = curve_of(planted, picked)

    # 80 readings: the standard deviation of normal noise is known to 8 %, of which the fit takes up to half.
    assert 0.6 < np.std(scatter(curve)) < 1.3
    assert (curve.line_band >= 0.0).all()
    assert curve.line_band.max() > 0.0
    assert (np.diff(curve.line_x) > 0.0).all()


def test_fast_waves_are_drawn_over_one_period():
    picked = ("joint_harmonics", "joint 4", "wave_4_40_sin")

    geared = replace(IRB_120, gear_ratios=(50.0,) * 6)
    campaign = telling_campaign(80, robot=geared)
    _, curve = curve_of({"joint_harmonics": {"wave_4_40_sin": 1e-3}}, picked, campaign=campaign)

    assert curve.variable == "angle of joint 4 within one period"
    assert (curve.x >= 0.0).all()
    assert (curve.x < 9.0).all()  # 360 deg / 40
    # The planted 1e-3 rad is known to 15 um / 150 mm / sqrt(40) = 1.6e-5 rad.
    assert np.abs(curve.line).max() == pytest.approx(np.rad2deg(1e-3), rel=0.1)


def test_a_reading_that_hardly_feels_the_joint_is_left_out():
    start = make_start({})
    selected = make_selected(start, [])
    unit = of_joint(selected, 3)
    unit[:3] *= 0.019 * np.median(np.linalg.norm(unit, axis=1)) / np.linalg.norm(unit[:3], axis=1)[:, None]

    told = seen(selected, unit, np.zeros_like(unit), np.ones(len(unit), dtype=bool))

    assert not told.rows[:3].any()
    assert told.standard_uncertainty.max() < 50.0 * np.median(told.standard_uncertainty)  # 1 / 2 %


def test_a_drift_is_a_straight_line_over_time_though_readings_differ():
    picked = ("base_drift", "base", "drift_linear_x")

    _, curve = curve_of({"base_drift": {"drift_linear_x": 0.3, "drift_linear_rz": 3e-4}}, picked)

    slope = curve.line[-1] / curve.line_x[-1]
    assert curve.variable == "time"
    assert curve.line == pytest.approx(slope * curve.line_x, abs=1e-9)
    # 0.3 mm/h along x and up to 3e-4 rad/h * 500 mm across: between 0.3 and 0.45 mm/h, noise aside.
    assert 0.25 < slope < 0.5


def test_a_jump_is_a_step():
    start = make_start({"base_shift": {f"jump_{ORIGIN_S + 30.0 * 40 - 15.0:g}_y": 0.2}})
    jump = proposed(start.scene, "base_shift", "base")
    nearest = min(jump, key=lambda one: abs(one.variant - (ORIGIN_S + 30.0 * 40 - 15.0)))
    selected = make_selected(start, [("base_shift", "base", nearest.names[0])])

    curve = finding_curve(selected, start.scene, selected.picks)

    before = curve.line_x < (nearest.variant - start.scene.origin_s) / 3600.0
    assert curve.line[before] == pytest.approx(np.zeros(before.sum()), abs=1e-12)
    # 0.2 mm; the turn that is fitted with it adds its own uncertainty of a few um.
    assert curve.line[~before] == pytest.approx(np.full((~before).sum(), 0.2), abs=0.03)


def test_an_offset_nest_stands_out_from_the_others():
    _, curve = curve_of({"nest_offset": {"offset_2_y": 0.1}}, ("nest_offset", "nest 2"))

    assert curve.line_x.tolist() == [1.0, 2.0, 3.0]
    assert curve.quantity == "shift along y of the tool"
    # 27 readings of 15 um: 3 um, times two for what tool and arm absorb, times three.
    assert curve.line == pytest.approx([0.0, 0.1, 0.0], abs=0.02)


def test_the_tools_seats_are_drawn_about_their_mean():
    planted = {"tool_reseating": {"seat_1_y": -0.2, "seat_2_y": 0.2}}

    _, curve = curve_of(planted, ("tool_reseating", "tool"))

    assert "about the mean" in curve.quantity
    assert curve.line.mean() == pytest.approx(0.0, abs=1e-9)
    assert np.ptp(curve.line) == pytest.approx(0.4, abs=0.1)  # seats are known to about 0.02 mm each
    assert curve.line_band.max() < 0.1


def test_a_cause_without_a_variable_of_its_own_is_drawn_against_what_it_foretells():
    _, curve = curve_of({"payload": {"payload_mass": 0.5}}, ("payload", "tool"))

    assert curve.variable == "shift that this cause foretells"
    assert curve.line == pytest.approx(curve.line_x)


@pytest.mark.parametrize(
    ("kind", "joint", "variable"),
    [
        ("angle", 3, "angle of joint 4"),
        ("torque", 3, "torque"),
        ("direction", 3, "direction"),
        ("coupling", 3, "angle of joint 4"),
        ("time", None, "time"),
        ("temperature", None, "temperature"),
        ("attachment", None, "attachment of the tool"),
        ("nest", None, "nest"),
        ("place", None, "place along"),
    ],
)
def test_whatever_it_depends_on_what_is_left_has_a_curve_with_a_band(unexplained, kind, joint, variable):
    selected = make_selected(unexplained, [])

    curve = remaining_curve(selected, unexplained.scene, Relation(kind, 1e-6, kind, joint, None))

    assert variable in curve.variable
    assert (curve.line_band > 0.0).all()
    assert np.isfinite(curve.line).all()


def test_an_unknown_error_of_an_angle_shows_in_its_curve():
    start = make_start({"joint_harmonics": {"wave_4_2_sin": 2e-3}})

    curve = remaining_curve(
        make_selected(start, []), start.scene, Relation("angle of joint 4", 1e-6, "angle", 3, None)
    )

    wave = np.rad2deg(2e-3) * np.sin(2.0 * np.deg2rad(curve.line_x))
    # The present model takes what an offset and a tilt can of it; most of two waves per turn is left.
    assert np.corrcoef(wave, curve.line)[0, 1] > 0.9
