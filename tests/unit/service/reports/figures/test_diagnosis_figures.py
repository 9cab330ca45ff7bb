import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.answers import make_spectrum
from tests.helpers.diagnosis.diagnosed_cells import make_curve, make_errors, make_finding, make_gain_finding
from tests.helpers.web.pages import assert_drawn_for_pages
from truepose.domain.diagnosis import CurvePoints, HeldOutErrors
from truepose.reports.diagnosis.findings import spectrum_picture
from truepose.reports.diagnosis.report import gains
from truepose.reports.figures.error_maps import error_maps
from truepose.reports.figures.histograms import comparison
from truepose.reports.figures.residuals import residual_curve


def drawn(curve, **options):
    return residual_curve(curve, "c", **options)


@pytest.mark.parametrize(
    "draw",
    [
        lambda: drawn(make_curve()).picture,
        lambda: comparison(np.ones(5), np.ones(5), 0.5)[0],
        lambda: error_maps(make_errors(n=20)).picture,
        lambda: error_maps(make_errors(n=20, components=1)).picture,
        lambda: gains((make_finding(), make_gain_finding())),
        lambda: spectrum_picture(make_spectrum(), "s"),
    ],
)
def test_a_picture_is_well_formed_and_takes_its_colours_from_the_page(draw):
    assert_drawn_for_pages(draw())


def test_axes_name_quantity_and_unit_as_they_are_printed():
    svg = drawn(make_curve(variable="torque of joint 2", variable_unit="N*m")).picture

    assert "torque of joint 2 [N·m]" in svg
    assert "error of joint 6 [deg]" in svg


def test_a_long_name_is_broken_and_keeps_its_unit():
    name = "shift along z of the tool, about the mean of all mountings"
    svg = drawn(make_curve(quantity=name, quantity_unit="mm")).picture

    assert "[mm]" in svg
    assert "mountings" in svg
    assert f"{name} [mm]" not in svg


def test_few_readings_are_seen_by_themselves():
    assert "weighted means" not in drawn(make_curve(n=59)).caption
    assert "weighted means of up to 5 neighbouring readings" in drawn(make_curve(n=100)).caption


def test_readings_that_hardly_feel_the_cause_do_not_flatten_the_others():
    curve = make_curve()
    curve.residual[:3], curve.standard_uncertainty[:3] = 1.8e14, 2e14

    figure = drawn(curve)

    # The picture is as high as the wave of 0.03 deg and its noise: its ticks stay in hundredths.
    assert "0.02" in figure.picture
    assert "1e14" not in figure.picture
    assert ", 97 readings" in figure.caption
    assert "3 further readings are hardly sensitive to this effect" in figure.caption


def test_a_line_without_a_band_claims_none():
    assert "95 % band" in drawn(make_curve()).picture
    assert "95 % band" not in drawn(make_curve(line_band=np.zeros(200))).picture


def test_a_variable_that_counts_has_one_value_for_each_number():
    directions = np.repeat([-1.0, 1.0], 50)
    line = 0.01 * directions
    curve = make_curve(
        variable="direction of joint 3", variable_unit="", x=directions, residual=line, line_x=directions,
        line=line, line_band=np.zeros(100),
    )  # fmt: skip

    svg = drawn(curve).picture

    assert "fitted effect" in svg
    assert "95 % interval" not in svg
    # two diamonds, joined; the one of the legend is a use of its marker
    (diamonds,) = re.findall(r'<path d="([^"]*)"[^>]*fill="var\(--after\)', svg)
    assert diamonds.count("M") == 2


def test_a_far_reading_is_said_and_does_not_flatten_the_rest():
    residual = np.full(200, 0.01)
    residual[3] = 5.0

    figure = drawn(make_curve(n=200, residual=residual))

    assert "1 reading lies outside the plot, at 5 deg." in figure.caption


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


def test_a_caption_tells_of_whiskers_dots_and_lines_that_are_drawn_only():
    curve = make_curve()
    nothing = np.zeros(0)
    certain = replace(curve, standard_uncertainty=np.zeros(len(curve.x)))
    blind = replace(curve, standard_uncertainty=np.full(len(curve.x), 1e6))

    without_line = drawn(replace(curve, line_x=nothing, line=nothing, line_band=nothing))

    assert drawn(curve).line
    assert (without_line.line, without_line.values) == (False, False)
    assert "standard uncertainty" in drawn(curve).caption
    assert "standard uncertainty" not in drawn(certain).caption
    assert "Dots:" not in drawn(blind).caption


def test_values_for_numbers_are_no_line():
    counted = replace(make_curve(), variable_unit="", x=np.arange(len(make_curve().x)) % 3.0)

    made = drawn(counted)

    assert (made.line, made.values) == (False, True)


def test_noise_beyond_the_picture_is_not_in_its_legend():
    within, _ = comparison(np.ones(5), np.ones(5), 0.5)
    beyond, _ = comparison(np.ones(5), np.ones(5), 3.0)

    assert "noise alone" in within
    assert "noise alone" not in beyond


def test_orders_are_written_as_people_read_them_and_no_more_than_fit():
    few = spectrum_picture(make_spectrum(), "s")
    many = np.arange(1.0, 61.0)
    curve = spectrum_picture(
        make_spectrum(order=many, amplitude_deg=0.01 / many, standard_uncertainty_deg=0.001 * many), "s"
    )

    assert all(f">{order}<" in few for order in ("1", "2", "7.25"))
    assert "amplitude [deg]" in few
    assert ">1<" in curve
    assert ">2<" not in curve


def unseen(n, u=0.012):
    x = np.linspace(-170.0, 170.0, n)
    return CurvePoints(x, 0.029 * np.sin(np.radians(2.0 * x + 40.0)), np.full(n, u))


def test_readings_that_were_never_fitted_are_crosses_and_the_caption_says_so():
    figure = drawn(make_curve(unseen=unseen(30)))

    assert ">validation readings<" in figure.picture
    assert "Crosses: 30 validation readings, not used in the fit" in figure.caption


def test_many_of_them_have_means():
    figure = drawn(make_curve(unseen=unseen(100)))

    assert ">means of validation readings<" in figure.picture
    assert "Crosses, with squares for their means: 100 validation readings" in figure.caption


@pytest.mark.parametrize("points", [None, unseen(0), unseen(10, u=9.0)], ids=["none", "empty", "blind"])
def test_without_any_worth_it_nothing_is_said_of_them(points):
    figure = drawn(make_curve(unseen=points))

    assert "validation" not in figure.picture
    assert "validation" not in figure.caption
