"""Axes of figures in the reader's unit: kept values, marked at round numbers of what is shown."""

import matplotlib as mpl
import pytest
from matplotlib.font_manager import fontManager

from truepose.messages.units import KEPT, Units
from truepose.reports.figures.svg_rendering import mark_axis, new_figure, page_style

INCH = Units.of(["inch", "rad", "f"])


def marks(axis):
    """Return what stands at the marks of an axis that are in sight, and where they are."""
    low, high = axis.get_view_interval()
    at = [value for value in axis.get_major_locator()() if low <= value <= high]
    return dict(zip(axis.get_major_formatter().format_ticks(at), at, strict=True))


def axes_to(right, *, log=False):
    with page_style():
        axes = new_figure(4.0, 2.0).add_subplot()
        axes.set_xscale("log" if log else "linear")
        axes.set_xlim(0.1 if log else 0.0, right)
    return axes


def test_marks_stand_at_whole_inches():
    axes = axes_to(254.0)

    mark_axis(axes.xaxis, INCH.conversion("mm"))

    found = marks(axes.xaxis)
    assert found["4"] == pytest.approx(4 * 25.4)
    assert set(found) <= {"0", "2", "4", "6", "8", "10"}


def test_marks_of_decades_stand_at_round_parts_of_an_inch():
    axes = axes_to(10.0, log=True)

    mark_axis(axes.xaxis, INCH.conversion("mm"))

    assert marks(axes.xaxis)["0.02"] == pytest.approx(0.508)
    assert list(axes.xaxis.get_minor_locator()()) == []


def test_marks_of_temperatures_count_from_their_own_zero():
    axes = axes_to(100.0)

    mark_axis(axes.xaxis, INCH.conversion("°C"))

    assert marks(axes.xaxis)["80"] == pytest.approx(48.0 / 1.8)


def test_an_axis_of_kept_values_stays_as_it_was():
    axes = axes_to(254.0)
    before = axes.xaxis.get_major_locator()

    mark_axis(axes.xaxis, KEPT.conversion("mm"))

    assert axes.xaxis.get_major_locator() is before


def test_only_fonts_that_are_there_are_asked_for():
    with page_style():
        asked = list(mpl.rcParams["font.family"])

    assert asked[0] == "DejaVu Sans"
    assert set(asked) <= {font.name for font in fontManager.ttflist}
