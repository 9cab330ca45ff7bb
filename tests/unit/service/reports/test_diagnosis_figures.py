import re
import xml.etree.ElementTree as ElementTree

import numpy as np
import pytest

from service.domain.diagnosis import HeldOutErrors
from service.reports.figures.comparison import comparison
from service.reports.figures.error_maps import error_maps
from service.reports.figures.gains import gains
from service.reports.figures.residual_curve import residual_curve
from tests.diagnosed_cells import make_curve, make_errors, make_finding, make_gain_finding


def drawn(curve, **options):
    return residual_curve(curve, "c", line="fitted effect", **options)


@pytest.mark.parametrize(
    "draw",
    [
        lambda: drawn(make_curve()).picture,
        lambda: comparison(np.ones(5), np.ones(5), 0.5)[0],
        lambda: error_maps(make_errors(n=20)).picture,
        lambda: error_maps(make_errors(n=20, components=1)).picture,
        lambda: gains((make_finding(), make_gain_finding())),
    ],
)
def test_a_picture_is_well_formed_and_takes_its_colours_from_the_page(draw):
    svg = draw()

    root = ElementTree.fromstring(svg)

    assert root.attrib["role"] == "img"
    assert root.attrib["aria-label"]
    assert "var(--ink)" in svg
    assert not re.search(r"#0[1-9a]0[1-9a]0[1-9a]", svg)  # no stand-in colour is left


def test_axes_name_quantity_and_unit_as_they_are_printed():
    svg = drawn(make_curve(variable="torque of joint 2", variable_unit="N*m")).picture

    assert "torque of joint 2 [N·m]" in svg
    assert "error of joint 6 [deg]" in svg


def test_few_readings_are_seen_by_themselves():
    assert "weighted means" not in drawn(make_curve(n=59)).caption
    assert "weighted means of up to 5 neighbours" in drawn(make_curve(n=100)).caption


def test_a_fast_wave_is_drawn_within_one_period():
    figure = drawn(make_curve(), period_deg=360.0 / 202.0)

    assert "within one period of 1.78 deg (202 per turn) [deg]" in figure.picture


def test_a_slow_wave_and_other_variables_stay_as_they_are():
    slow = drawn(make_curve(), period_deg=180.0).picture
    timed = drawn(make_curve(variable="time", variable_unit="h"), period_deg=1.0).picture

    assert "within one period" not in slow
    assert "within one period" not in timed


def test_folding_keeps_readings_and_wave_together():
    order = 50.0
    curve = make_curve(
        shape=lambda x: 0.03 * np.sin(np.radians(order * x)), line_x=np.linspace(-180, 180, 5000)
    )
    line = 0.03 * np.sin(np.radians(order * curve.line_x))
    curve = make_curve(
        shape=lambda x: 0.03 * np.sin(np.radians(order * x)),
        line_x=curve.line_x,
        line=line,
        line_band=np.zeros(5000),
    )

    figure = drawn(curve, period_deg=360.0 / order)

    # One period rises and falls once: its means follow a line of few bends, so means are drawn again.
    assert "weighted means" in figure.caption


def test_a_far_reading_is_said_and_does_not_flatten_the_rest():
    residual = np.full(200, 0.01)
    residual[3] = 5.0

    figure = drawn(make_curve(n=200, residual=residual))

    assert "1 reading lies beyond the picture, the farthest at 5 deg." in figure.caption


def test_where_far_readings_are_the_finding_they_are_shown():
    residual = np.full(200, 0.01)
    residual[3] = 5.0

    assert "beyond" not in drawn(make_curve(n=200, residual=residual), whole=True).caption


@pytest.mark.parametrize("n", [0, 1])
def test_hardly_any_reading_is_no_fault(n):
    figure = drawn(make_curve(n=n, line_x=np.zeros(0), line=np.zeros(0), line_band=np.zeros(0)))

    assert (figure is None) == (n == 0)


def test_unknown_uncertainties_draw_no_whiskers_and_no_means():
    figure = drawn(make_curve(standard_uncertainty=np.full(100, np.nan)))

    assert "weighted means" not in figure.caption


def test_both_histograms_hold_every_error():
    before, after = np.array([0.1] * 399 + [9.0]), np.full(400, 0.05)

    _, beyond = comparison(before, after, 0.0)

    assert beyond == 1  # one of 800 lies beyond 99.5 %


def test_arrows_before_and_after_have_one_scale():
    maps = error_maps(make_errors(n=300))

    assert maps.exaggeration > 1.0
    assert (maps.shown, maps.total) == (150, 300)
    assert "error of 0." in maps.picture


def test_errors_at_one_place_only_are_still_a_picture():
    errors = make_errors(n=5)
    same = HeldOutErrors(
        errors.config, np.tile([300.0, 0.0, 400.0], (5, 1)), errors.before_mm, errors.after_mm
    )

    assert error_maps(same).shown == 5


def test_errors_of_nothing_at_all_are_still_a_picture():
    errors = make_errors(n=5, before_mm=0.0, after_mm=0.0)

    assert error_maps(errors).exaggeration == 1.0
    assert error_maps(make_errors(n=5, components=1, before_mm=0.0, after_mm=0.0)).lengths


def test_no_finite_error_is_no_picture():
    errors = make_errors(n=3)

    assert (
        error_maps(
            HeldOutErrors(errors.config, errors.position_mm * np.nan, errors.before_mm, errors.after_mm)
        )
        is None
    )


def test_gains_are_compared_where_there_are_two():
    assert gains((make_finding(),)) is None
    assert gains((make_finding(), make_gain_finding(gain=None))) is None
    assert "joint gain, joint 2" in gains((make_finding(), make_gain_finding()))
