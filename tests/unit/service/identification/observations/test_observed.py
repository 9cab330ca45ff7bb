"""Readings of either kind as observations of a model."""

import numpy as np
import pytest

from tests.helpers.diagnosis.leg_scenes import PER_PLACEMENT, N, leg_problem, telling_legs
from tests.helpers.identification.synthetic import nominal_campaign
from truepose.domain.errors import ConfigurationError
from truepose.identification.problem.build import build
from truepose.identification.verdict.judge import observation_block

SECOND = np.arange(PER_PLACEMENT, N)


@pytest.fixture(scope="module")
def problem():
    return leg_problem()


def test_legs_from_some_of_the_cups_are_held_against_those_cups(problem):
    part = observation_block(telling_legs().legs.taken(SECOND), 0.0, problem.structure)

    residual = part.result(problem.structure, problem.start, None).residual

    whole = problem.blocks[0].result(problem.structure, problem.start, None).residual
    assert residual == pytest.approx(whole[SECOND], abs=1e-12)


def test_legs_from_a_cup_that_the_model_does_not_know_are_refused(problem):
    elsewhere = telling_legs(base_point=np.full(N, 7)).legs

    with pytest.raises(ConfigurationError, match="Base point 7 of placement 1"):
        observation_block(elsewhere, 0.0, problem.structure)


def test_each_kind_says_what_it_is_of(problem):
    points = nominal_campaign(20)

    positions = observation_block(points.calibration, 0.02, build(points, ("base", "geometry")).structure)

    assert (positions.quantity, positions.components, positions.scatter_mm) == ("position", 3, 0.02)
    assert [block.quantity for block in problem.blocks] == ["length"]
    assert problem.quantity == "length"


def test_what_scatter_adds_is_not_in_the_stated_covariance():
    points = nominal_campaign(20)

    block = observation_block(points.calibration, 0.5, build(points, ("base", "geometry")).structure)

    stated = points.calibration.standard_uncertainty_mm[:, None, None] ** 2 * np.eye(3)
    assert block.covariance() == pytest.approx(stated)
    assert block.stated_sigma() == pytest.approx(np.sqrt(stated[:, 0, 0].mean() + 0.25))
