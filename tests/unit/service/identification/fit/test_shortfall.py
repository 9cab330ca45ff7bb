"""What a model lacks: found where it is, nothing where there is nothing, and right at other targets."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.lacking import GAP_RAD, MODEL, campaign, errors_over_stated, robot
from tests.helpers.identification.synthetic import (
    NOISE_MM,
    configurations,
    leg_campaign,
    measured,
    nominal_campaign,
)
from truepose.domain.campaign import Stops
from truepose.identification import identify
from truepose.identification.model.prediction import predict


def test_a_gap_that_the_model_lacks_is_found_with_its_size():
    found = identify(robot(gap_2=GAP_RAD)[0], MODEL).model.shortfall

    gap = next(one for one in found.functions if one.name == "gap_2")
    assert gap.value == pytest.approx(GAP_RAD, rel=0.1)
    assert gap.standard_uncertainty < 0.1 * GAP_RAD
    assert found.rest_mm < NOISE_MM


def test_the_covariance_of_what_is_lacking_is_symmetric_to_the_last_digit():
    found = identify(robot(gap_2=GAP_RAD, gap_3=GAP_RAD)[0], MODEL).model.shortfall

    assert len(found.functions) > 1
    assert (found.covariance == found.covariance.T).all()


def test_a_model_that_lacks_nothing_says_next_to_nothing():
    read, *_ = robot()
    model = identify(read, MODEL).model
    stops, nest = read.calibration.stops, read.calibration.nest

    _, stated = predict(model, stops, nest)
    _, of_parameters = predict(replace(model, shortfall=None, discrepancy_mm=0.0), stops, nest)

    assert np.sqrt(np.mean(stated**2) - np.mean(of_parameters**2)) < NOISE_MM / 2


def test_the_discrepancy_alone_would_not_cover_what_all_targets_share():
    read, structure, values = robot(3, gap_1=GAP_RAD, gap_2=GAP_RAD, gap_3=GAP_RAD)
    model = identify(read, MODEL).model

    with_functions, alike = (
        np.mean(np.abs(errors_over_stated(read, structure, values, one, 3)) <= 1.96)
        for one in (model, replace(model, shortfall=None))
    )

    assert with_functions > alike


def test_where_nobody_says_from_which_side_it_came_a_gap_counts_too():
    model = identify(robot(gap_2=GAP_RAD)[0], MODEL).model
    joints, nest = configurations(5, seed=9), np.ones(5, dtype=np.int64)

    told = predict(model, Stops(np.arange(5), joints, direction=np.ones((5, 6), dtype=np.int64)), nest)
    untold = predict(model, Stops(np.arange(5), joints), nest)

    assert untold[1] == pytest.approx(told[1], rel=1e-12)


def test_a_model_of_lengths_has_none():
    assert identify(leg_campaign(60)).model.shortfall is None


def test_of_a_nest_on_the_axis_of_a_joint_rounding_tells_nothing():
    """Waves of joint 6 move it by 1e-14 mm: any size of them would explain the noise as well."""
    on_axis = nominal_campaign(60, nests=((0.0, 0.0, 150.0),))

    answer = identify(measured(on_axis)[0], MODEL)

    functions = () if answer.model.shortfall is None else answer.model.shortfall.functions
    assert not [one for one in functions if one.name.startswith("wave_6")]
    _, u_mm = predict(answer.model, Stops(np.arange(5), configurations(5, 8)), np.ones(5, dtype=int))
    assert u_mm.max() < 1.0


@pytest.mark.parametrize("seed", range(4))
def test_few_readings_whose_noise_functions_could_explain_say_next_to_nothing_of_them(seed):
    """Twelve stops leave a few degrees of freedom, and dozens of functions fit them without any noise."""
    answer = identify(measured(campaign(seed, 12), seed=seed)[0], MODEL)

    functions = answer.model.shortfall.functions
    _, u_mm = predict(answer.model, Stops(np.arange(5), configurations(5, 8)), np.ones(5, dtype=int))
    assert all(abs(one.value) < 10.0 * one.standard_uncertainty for one in functions)
    assert u_mm.max() < 0.2
