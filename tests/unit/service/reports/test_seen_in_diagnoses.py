"""Sentences under the figures of a diagnosis, and under how well parameters are determined."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.diagnosed_cells import two_findings
from tests.helpers.web.pages import Page
from truepose.domain.diagnosis import Curve, CurvePoints, Gain, HeldOutErrors, Spectrum
from truepose.domain.identification import NotIdentifiable, Parameter
from truepose.messages.catalogue import IN_ENGLISH
from truepose.messages.message import leading_key
from truepose.reports.captions import (
    curve_sentence,
    gains_sentence,
    map_sentence,
    places_sentence,
    spectrum_sentence,
)
from truepose.reports.diagnosis.cause_map import CauseMap, MapEntry
from truepose.reports.diagnosis.report import DiagnosisReport
from truepose.reports.identification.observability import (
    determined_parameters,
    observability_figure,
    observability_sentence,
)

LINE_X = np.linspace(-180.0, 180.0, 91)


def english(sentence):
    return IN_ENGLISH.spoken(sentence)


def wave(x):
    return 0.03 * np.sin(np.radians(2.0 * x))


def curve(n, planted, *, unseen=None, seed=3):
    """Readings of 0.01 deg along a joint, on a wave or not, with the wave as the line."""
    rng = np.random.default_rng(seed)
    x = rng.uniform(-180.0, 180.0, n)
    residual = planted * wave(x) + 0.01 * rng.standard_normal(n)
    band = np.full(91, 0.001)
    return Curve(
        "angle of joint 6", "deg", "error of joint 6", "deg", x, residual, np.full(n, 0.01), LINE_X,
        wave(LINE_X), band, unseen,
    )  # fmt: skip


def test_readings_on_the_line_are_told_with_what_it_takes_off():
    text = english(curve_sentence(curve(200, 1.0), IN_ENGLISH))

    assert "It spans 0.0600 deg from lowest to highest" in text
    assert int(text.split("explains ")[1].split(" %")[0]) == pytest.approx(82, abs=4)  # 4.5 / 5.5


def test_noise_beside_the_line_is_nothing():
    assert leading_key(curve_sentence(curve(200, 0.0), IN_ENGLISH)) == "seen.curve.nothing"
    assert leading_key(curve_sentence(curve(8, 1.0), IN_ENGLISH)) == "seen.curve.few"


def test_readings_that_were_never_fitted_are_asked_first():
    own = curve(200, 1.0)
    follows, other = curve(100, 1.0, seed=4), curve(100, 0.0, seed=5)
    unseen = [CurvePoints(one.x, one.residual, one.standard_uncertainty) for one in (follows, other)]

    told = [leading_key(curve_sentence(replace(own, unseen=points), IN_ENGLISH)) for points in unseen]

    assert told == ["seen.curve.follows_unseen", "seen.curve.nothing"]


def test_of_waves_the_largest_beyond_its_uncertainty_is_told():
    orders, u = np.array([1.0, 2.0, 3.0]), np.full(3, 0.001)

    assert english(spectrum_sentence(Spectrum(orders, np.array([0.004, 0.02, 0.0]), u))) == (
        "The largest harmonic has order 2 per turn, 0.0200 deg. "
        "Other harmonics larger than three times their standard uncertainty: 1."
    )
    assert leading_key(spectrum_sentence(Spectrum(orders, u, u))) == "seen.spectrum.nothing"


def test_the_map_says_where_most_acts_and_nothing_of_rivals_alone():
    cells = (
        MapEntry("joint 6", "angle of joint 6", 0.8, (1,), ()),
        MapEntry("base", "time", 0.2, (2,), ()),
        MapEntry("joint 5", "time", 0.0, (), (1,)),
    )

    told = english(map_sentence(CauseMap((), (), cells, ())))

    assert told.startswith("Largest share: joint 6, as a function of ")
    assert told.endswith(", 80 % of the mean square. Other locations with an explanation: 1.")
    assert leading_key(map_sentence(CauseMap((), (), cells[2:], ()))) == "seen.map.nothing"


def test_the_gain_that_is_not_proved_is_counted():
    first, second = two_findings().findings[:2]
    sure = replace(first, gain=Gain(0.10, 0.06, (0.03, 0.05)))
    unsure = replace(second, gain=Gain(0.07, 0.06, (-0.01, 0.03)))

    assert "reduces the held-out RMS by 0.0400 mm." in english(gains_sentence([sure, unsure], IN_ENGLISH))
    assert english(gains_sentence([sure, unsure], IN_ENGLISH)).endswith("not proved: 1.")
    assert english(gains_sentence([sure], IN_ENGLISH)).endswith("lie above 0.")
    assert gains_sentence([replace(first, gain=None)], IN_ENGLISH) == ""


def held_out(after_mm):
    n = len(after_mm)
    places = np.random.default_rng(1).uniform(-500.0, 500.0, (n, 3))
    return HeldOutErrors(np.arange(n), places, np.ones_like(after_mm), after_mm)


def test_errors_that_belong_to_a_place_are_told_and_noise_is_not():
    noise = np.random.default_rng(2).standard_normal((300, 3))

    assert leading_key(places_sentence(held_out(noise))) == "seen.space.nothing"
    assert leading_key(places_sentence(held_out(noise + 3.0))) == "seen.space.alike"
    assert leading_key(places_sentence(held_out(0.01 + np.zeros((40, 1))))) == "seen.distances.long"
    assert leading_key(places_sentence(held_out(np.full((4, 1), np.nan)))) == "seen.space.few"


def test_every_figure_of_a_diagnosis_has_its_sentence():
    page = DiagnosisReport(two_findings()).page()

    figures = page.split("</section>", 1)[1].split("<figure")
    assert len(figures) > 3
    for before in figures[:-1]:
        assert '<p class="said">' in before[-900:], before[-900:]


def parameters(*times):
    return [
        Parameter(f"a_{k}", "geometry", 0.0, "mm", 1.0 / one, 1.0) for k, one in enumerate(times, start=1)
    ]


def test_the_worst_known_parameter_is_named():
    told = english(observability_sentence(determined_parameters(parameters(100.0, 20.0, 50.0))))

    assert "each of the 3 parameters" in told
    assert "a_2, is known 20 times better" in told


def test_parameters_that_an_assumption_holds_are_counted_and_combinations_too():
    found = determined_parameters(parameters(1.25, 20.0, 1.0))

    told = english(observability_sentence(found, [NotIdentifiable(("d_2", "d_3"), "")]))

    assert "2 of 3 parameters" in told
    assert "The worst parameter is a_3: its uncertainty is still 100 %" in told
    assert told.endswith("distinguish at all: 1.")


def test_of_what_nobody_assumed_nothing_is_said_to_be_determined():
    found = determined_parameters([replace(parameters(2.0)[0], prior_width=0.0)])

    assert observability_figure(found) is None
    assert leading_key(observability_sentence(found)) == "seen.observability.none"


def test_the_figure_names_every_parameter_worst_first():
    text = Page(str(observability_figure(determined_parameters(parameters(*range(2, 22)))))).text

    assert text.index("a_1") < text.index("a_20")
