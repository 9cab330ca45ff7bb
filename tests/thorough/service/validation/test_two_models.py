"""Two models of one robot that did not change: how often chance alone makes them differ."""

import numpy as np

from tests.helpers.domain.builders import make_model
from tests.helpers.domain.two_models import seen_by, with_values
from truepose.validation.model_comparison import compare_models


def test_two_measurements_of_an_unchanged_robot_differ_by_chance_as_often_as_is_said():
    generator = np.random.default_rng(11)
    truth, covariance = np.array([1e-3, 0.2]), make_model().covariance
    readings = seen_by(make_model())
    runs = 400
    drawn = generator.multivariate_normal(truth, covariance, (runs, 2))

    found = [compare_models(with_values(*a), with_values(*b), readings) for a, b in drawn]

    together = sum(one.p_value < 0.05 for one in found)
    single = sum(any(change.significant for change in one.changes) for one in found)
    assert 8 <= together <= 34  # 20 expected; 99.8 % of a binomial of 400 and 0.05
    assert single <= 34
