"""Stated uncertainties of figures against the scatter of the figures themselves, over drawn measurements."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from tests.helpers.identification.synthetic import NESTS, configurations, leg_campaign
from truepose.domain.measurement.campaign import PointReadings, Stops
from truepose.domain.results.identification import NestCentre, Parameter
from truepose.domain.robot import FramePlacement
from truepose.identification import identify, judge
from truepose.identification.verdict.relative import relative_errors
from truepose.judgement.distances import distances
from truepose.judgement.validation import validate
from truepose.kinematics.chain import nominal_chain

U_MM = 0.02
FRAME = ("base_x", 0.03), ("base_y", 0.01), ("base_rz", 5e-5)
DRAWS = 250
FIGURES = ("mean_mm", "rms_mm", "sd_mm")
_CENTRES = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS, start=1))


def model_with_frame(**changes):
    """A model whose base is known as `FRAME` says."""
    parameters = tuple(
        Parameter(name, "base", 0.0, "rad" if "r" in name else "mm", u, 1.0) for name, u in FRAME
    )
    values = {
        "effects": ("base",),
        "parameters": parameters,
        "covariance": np.diag([u**2 for _, u in FRAME]),
        "base": FramePlacement(),
        "nests": _CENTRES,
        "nominal_nests": _CENTRES,
    }
    return model_of(IRB_120, **(values | changes))


def sure_model():
    """The same with nothing uncertain."""
    return model_with_frame(parameters=(), covariance=np.zeros((0, 0)), effects=())


def readings(n, error_mm=0.25, seed=0):
    """Readings that a sound instrument would give of an arm with errors of some structure."""
    joints, nest = configurations(n, seed=seed), 1 + np.arange(n) % 3
    places = nominal_chain(IRB_120, joints).points(np.array(NESTS)[nest - 1])
    off = error_mm * np.stack(
        [np.cos(joints[:, 0]), np.sin(2.0 * joints[:, 1]), np.cos(joints[:, 2])], axis=1
    )
    return PointReadings(Stops(np.arange(n), joints), nest, places + off, np.full(n, U_MM))


def measured_again(points, rng):
    """The same places, read anew in a frame set up anew."""
    x, y, turn = (u * rng.standard_normal() for _, u in FRAME)
    frame = np.array([x, y, 0.0]) + turn * np.cross([0.0, 0.0, 1.0], points.position_mm)
    noise = U_MM * rng.standard_normal(points.position_mm.shape)
    return replace(points, position_mm=points.position_mm + frame + noise)


def blocks(model, points):
    judged = judge(model, points, 0.0)
    return {
        "position": judged.pair(),
        "relative": relative_errors(judged),
        "distance": distances(judged).sizes,
        "signed": distances(judged).errors.identified.mean_mm,
    }


@pytest.fixture(scope="module")
def drawn():
    """Figures of many measurements of the same places, and what one of them says of its own."""
    model, points, rng = model_with_frame(), readings(40), np.random.default_rng(7)
    found = [blocks(model, measured_again(points, rng)) for _ in range(DRAWS)]
    return found, validate(model, measured_again(points, rng)).uncertainty


@pytest.mark.parametrize("figure", FIGURES)
@pytest.mark.parametrize("block", ["position", "relative", "distance"])
def test_a_stated_uncertainty_is_the_scatter_of_the_figure(drawn, block, figure):
    found, stated = drawn

    scatter = np.std([getattr(one[block].identified, figure) for one in found], ddof=1)

    # 250 draws know a scatter to 4.5 %; the rest is that one measurement is not at the true place
    assert getattr(getattr(stated, block).identified, figure) == pytest.approx(scatter, rel=0.2)


def test_the_mean_of_distances_with_sign_too(drawn):
    found, stated = drawn

    scatter = np.std([one["signed"] for one in found], ddof=1)

    assert stated.distance.identified.signed_mean_mm == pytest.approx(scatter, rel=0.2)


def test_pairs_are_not_counted_as_if_they_were_independent(drawn):
    _, stated = drawn
    pairs = 40 * 39 / 2

    assert stated.distance.identified.signed_mean_mm > 3.0 * np.sqrt(2.0) * U_MM / np.sqrt(pairs)


def test_the_largest_error_is_as_uncertain_as_its_own_reading():
    model = sure_model()

    known = validate(model, readings(30)).uncertainty

    assert known.position.identified.max_mm == pytest.approx(U_MM, rel=1e-6)
    assert known.distance.identified.max_mm == pytest.approx(np.sqrt(2.0) * U_MM, rel=1e-6)


def test_where_the_base_stands_is_in_absolute_figures_and_in_no_relative_one():
    models = (model_with_frame(), sure_model())

    with_frame, without = (validate(one, readings(30)).uncertainty for one in models)

    assert with_frame.position.identified.mean_mm > 1.2 * without.position.identified.mean_mm
    for block in ("relative", "distance"):
        pair = [getattr(known, block).identified.mean_mm for known in (with_frame, without)]
        assert pair[0] == pytest.approx(pair[1], rel=1e-3)


def test_readings_without_errors_and_noise_are_known_exactly():
    points = readings(20, error_mm=0.0)
    exact = replace(points, standard_uncertainty_mm=np.zeros(20))
    model = sure_model()

    known = validate(model, exact).uncertainty

    assert known.position.identified.mean_mm == 0.0
    assert known.distance.identified.max_mm == 0.0


def test_of_thousands_of_readings_some_partners_stand_for_all():
    model = model_with_frame()

    some, all_of_them = (validate(model, readings(n)).uncertainty.distance.identified for n in (900, 500))

    assert some.mean_mm == pytest.approx(all_of_them.mean_mm * np.sqrt(500 / 900), rel=0.25)


def test_lengths_have_no_distances_but_are_known_too():
    campaign = leg_campaign(60)

    known = validate(identify(campaign).model, campaign.legs).uncertainty

    assert (known.relative, known.distance) == (None, None)
    assert 0.0 < known.position.identified.mean_mm < 0.005


def test_the_guard_band_counts_where_the_base_stands():
    models = (model_with_frame(), sure_model())

    limits = [validate(one, readings(30), limit_mm=1.0).decision.guard_mm for one in models]

    assert limits[1] == pytest.approx(1.65 * U_MM)
    assert limits[0] > 1.1 * limits[1]
