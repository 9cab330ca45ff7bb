"""What a model lacks: found where it is, nothing where there is nothing, and right at other targets."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.synthetic import (
    NOISE_MM,
    configurations,
    leg_campaign,
    measured,
    nominal_campaign,
)
from truepose.domain.measurement.campaign import Stops
from truepose.identification import identify
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import predict
from truepose.identification.problem.build import build

GAP_RAD = 3e-4  # 0.1 to 0.2 mm at the tool
WAVE_RAD = 2e-4
MODEL = ("base", "geometry", "compliance")


def campaign(seed=0, n=80):
    """Stops that were approached from both sides."""
    plain = nominal_campaign(n, seed)
    ways = np.random.default_rng(seed).choice([-1, 1], (n, 6))
    stops = replace(plain.calibration.stops, direction=ways)
    return replace(plain, calibration=replace(plain.calibration, stops=stops))


def robot(seed=0, n=80, **lacking):
    """A campaign of an arm with effects that `MODEL` lacks, and the values of all its parameters."""
    asked, effects = campaign(seed, n), (*MODEL, "backlash", "joint_harmonics")
    structure = build(asked, effects).structure
    rng = np.random.default_rng((seed, 1))
    values = structure.prior_means + 0.2 * np.minimum(structure.prior_widths, 1.0) * rng.normal(
        size=len(structure.specs)
    )
    for k, name in enumerate(structure.names):
        if structure.owners[k] in ("backlash", "joint_harmonics"):
            values[k] = lacking.get(name, 0.0)
    return measured(asked, values, seed=seed, effects=effects)[0], structure, values


def errors_over_stated(read, structure, values, model, seed):
    """True errors of a model at targets where no one measured, over its stated uncertainty, (n, 3)."""
    n = 200
    joints = configurations(n, seed=1000 + seed)
    stops = Stops(np.arange(n), joints, direction=np.ones((n, 6), dtype=np.int64))
    nest = 1 + np.arange(n) % 3
    true = evaluate(structure, values, Targets(stops, nest)).position_mm
    predicted, uncertainty = predict(model, stops, nest)
    return (true - predicted) / uncertainty[:, None]


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


def ratios_over_robots(changed=lambda model: model, **lacking):
    """Errors over stated uncertainty of eight arms."""
    found = []
    for seed in range(8):
        read, structure, values = robot(seed, **lacking)
        model = changed(identify(read, MODEL).model)
        found.append(errors_over_stated(read, structure, values, model, seed))
    return np.array(found)


def test_of_noise_alone_parameters_are_nearly_all_of_the_uncertainty():
    ratios = ratios_over_robots()
    of_parameters = ratios_over_robots(lambda model: replace(model, shortfall=None, discrepancy_mm=0.0))

    assert 0.93 < np.mean(np.abs(ratios) <= 1.96) < 0.985
    assert np.std(ratios) == pytest.approx(np.std(of_parameters), rel=0.1)


def test_what_is_stated_beside_structure_is_as_large_as_true_errors_are():
    ratios = ratios_over_robots(
        gap_1=GAP_RAD, gap_3=GAP_RAD, wave_1_2_sin=WAVE_RAD, wave_2_2_cos=WAVE_RAD, wave_5_1_sin=WAVE_RAD
    )

    assert np.sqrt(np.mean(ratios**2)) == pytest.approx(1.0, abs=0.15)
    assert np.mean(np.abs(ratios) <= 1.96) > 0.93


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
