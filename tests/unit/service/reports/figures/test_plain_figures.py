"""Figures that a program gets: those of the pages in ordinary colours, free of any window, to be changed."""

import re
import subprocess
import sys
from importlib.resources import files

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.colors import to_hex

from tests.helpers.diagnosis.diagnosed_cells import make_curve
from tests.helpers.domain.builders import make_pair
from truepose.domain.validation import (
    BranchErrors,
    DistanceBin,
    DistanceErrors,
    ErrorsByPlace,
    Histogram,
    SignedErrors,
)
from truepose.reports.figures.curves import plain_place_errors
from truepose.reports.figures.histograms import (
    comparison,
    plain_comparison,
    plain_distance_histogram,
    plain_histogram,
)
from truepose.reports.figures.residuals import plain_residual_curve
from truepose.reports.figures.svg_rendering import PLAIN
from truepose.reports.identification.judged_figures import judged

_SHELLS = (DistanceBin(0.0, 200.0, make_pair()), DistanceBin(400.0, 600.0, make_pair()))
_PLACES = ErrorsByPlace(
    (0.0, 0.0, 0.0), 300.0, True, _SHELLS, _SHELLS, (BranchErrors("front/up", make_pair()),)
)
_PNG = b"\x89PNG\r\n"
_BEFORE, _AFTER = np.linspace(0.1, 0.5, 40), np.linspace(0.01, 0.06, 40)


@pytest.fixture(
    params=["comparison", "histogram", "distances", "places", "curve", "curve of few", "counted curve"]
)
def figure(request, identification, campaign):
    if request.param == "comparison":
        return plain_comparison(_BEFORE, _AFTER, 0.02)
    if request.param == "histogram":
        return plain_histogram(judged(identification, campaign), 0.016)
    if request.param == "distances":
        signed = SignedErrors(0.004, 0.6, Histogram(0.5, -2, (1, 4, 5)))
        return plain_distance_histogram(DistanceErrors(signed, signed))
    if request.param == "places":
        return plain_place_errors(_PLACES)
    curves = {
        "curve": make_curve(n=100),
        "curve of few": make_curve(n=20),
        "counted curve": make_curve(n=60, variable="mounting", variable_unit="", x=np.arange(60) % 3 + 1.0),
    }
    return plain_residual_curve(curves[request.param])


def test_a_notebook_shows_it_by_itself(figure):
    assert figure._repr_png_().startswith(_PNG)


def test_no_stand_in_colour_of_the_pages_is_left(figure, tmp_path):
    figure.savefig(tmp_path / "figure.svg")

    assert not re.search(r"#0[1-9a]0[1-9a]0[1-9a]", (tmp_path / "figure.svg").read_text())


def test_distances_are_drawn_as_shares_over_their_bins():
    signed = SignedErrors(-0.004, 0.25, Histogram(0.5, -2, (1, 2, 1)))

    panels = plain_distance_histogram(DistanceErrors(signed, signed)).axes

    assert [axes.get_title(loc="left") for axes in panels] == [
        "nominal: mean -0.0040 mm, 25 % above 0",
        "identified: mean -0.0040 mm, 25 % above 0",
    ]
    drawn = panels[1].patches[0].get_data()
    assert drawn.values.tolist() == [25.0, 50.0, 25.0]
    assert drawn.edges.tolist() == [-1.0, -0.5, 0.0, 0.5]


def test_errors_by_place_are_levels_over_their_shells():
    zone, axis = plain_place_errors(_PLACES).axes

    levels = {line.get_label(): line.get_xydata() for line in zone.lines}
    mean = levels["identified, mean"]
    assert mean[[0, 1, 3, 4], 0].tolist() == [0.0, 200.0, 400.0, 600.0]
    assert mean[[0, 1, 3, 4], 1].tolist() == [make_pair().identified.mean_mm] * 4
    assert np.isnan(mean[[2, 5]]).all()
    assert levels["edge of the calibration zone"][0, 0] == 300.0
    assert axis.get_xlabel() == "distance from axis 1 [mm]"


def test_it_can_be_changed(figure):
    axes = figure.axes[0]

    axes.set_title("Cell 3")
    axes.set_xlabel("error of the left arm [mm]")

    assert (axes.get_title(), axes.get_xlabel()) == ("Cell 3", "error of the left arm [mm]")


def test_the_settings_of_the_program_stay_as_they_were():
    before = _settings()

    plain_comparison(_BEFORE, _AFTER, 0.02)

    assert _settings() == before


def _settings():
    """All but the backend, which is chosen by being asked for."""
    return {name: mpl.rcParams[name] for name in mpl.rcParams if name != "backend"}


def test_no_window_and_no_global_state_is_needed():
    code = (
        "import sys, numpy as np;"
        "from truepose.reports.figures.histograms import plain_comparison;"
        "plain_comparison(np.ones(5), np.ones(5), 0.5)._repr_png_();"
        "print('matplotlib.pyplot' in sys.modules)"
    )

    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)

    assert done.stdout == "False\n"


def test_its_colours_are_those_of_a_white_page():
    style = (files("truepose.reports") / "templates" / "tokens.css").read_text(encoding="utf-8")
    light = dict(re.findall(r"--([\w-]+): light-dark\((#\w{6}),", style))

    assert {name: light[name] for name in ("ink", "muted", "grid", "before", "after", "noise")} == {
        name: getattr(PLAIN, name) for name in ("ink", "muted", "grid", "before", "after", "noise")
    }
    assert PLAIN.paper == light["paper"]


def test_it_shows_what_the_page_shows():
    _, beyond = comparison(_BEFORE, _AFTER, 0.02)

    axes = plain_comparison(_BEFORE, _AFTER, 0.02).axes[0]

    bars = axes.patches[0]
    assert (sum(bars.get_data().values), beyond) == (len(_BEFORE), 0)
    assert to_hex(bars.get_facecolor()) == PLAIN.before


def test_a_curve_without_a_finite_reading_is_not_drawn():
    blank = make_curve(n=20)

    assert plain_residual_curve(make_curve(n=20, residual=np.full(20, np.nan))) is None
    assert plain_residual_curve(blank) is not None
