"""Stated uncertainties of figures: what they hang on, and what they do not."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.framed import U_MM, model_with_frame, readings
from tests.helpers.identification.synthetic import leg_campaign
from truepose.identification import identify
from truepose.validation.validate import validate


def sure_model():
    """Return the model with nothing uncertain."""
    return model_with_frame(parameters=(), covariance=np.zeros((0, 0)), effects=())


def test_pairs_are_not_counted_as_if_they_were_independent():
    stated = validate(model_with_frame(), readings(40)).uncertainty
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


@pytest.mark.parametrize("seed_mm", [5.0, 300.0])
def test_one_distance_has_no_spread(seed_mm):
    stated = validate(model_with_frame(), readings(2, error_mm=seed_mm))

    assert stated.distance.identified.n == 1
    assert stated.uncertainty.distance.identified.sd_mm == 0.0


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
