"""Prediction: what a model needs to be told, and what its uncertainty contains."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model, NestCentre, Parameter
from truepose.domain.robot import FramePlacement
from truepose.identification import judge, predict
from truepose.identification.model.estimates import structure_of, values_of
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.prediction import placed_variance, turned_variance
from truepose.kinematics.chain import nominal_chain

JOINTS = configurations(5)
ONES = np.ones(5, dtype=np.int64)
SPRING = 1e-6  # rad/(N mm)


def model(**changes):
    """A robot whose third link is 0.5 mm longer than nominal, known to 0.1 mm."""
    nests = tuple(NestCentre(k, centre) for k, centre in enumerate(NESTS, start=1))
    values = {
        "robot": IRB_120,
        "base": FramePlacement(),
        "nests": nests,
        "tool_rotation_rad": (0.0, 0.0, 0.0),
        "effects": ("geometry",),
        "parameters": (Parameter("a_3", "geometry", 0.5, "mm", 0.1, 1.0),),
        "covariance": np.array([[0.01]]),
        "gravity_m_s2": (0.0, 0.0, -9.81),
        "discrepancy_mm": 0.0,
        "repeatability_mm": 0.0,
        "nominal_base": FramePlacement(),
        "nominal_nests": nests,
    }
    return Model(**(values | changes))


def with_spring(**changes):
    parameter = Parameter("c_2", "compliance", SPRING, "rad/(N*mm)", 1e-8, 1e-6)
    return model(effects=("compliance",), parameters=(parameter,), covariance=np.array([[1e-16]]), **changes)


def stops(**columns):
    return Stops(np.arange(5), JOINTS, **columns)


def nominal():
    return nominal_chain(IRB_120, JOINTS).points(np.array(NESTS[0]))


def test_a_longer_link_moves_the_nest_along_it():
    position, uncertainty = predict(model(), stops(), ONES)

    along = nominal_chain(IRB_120, JOINTS).x_before[2]
    assert position - nominal() == pytest.approx(0.5 * along, abs=1e-9)
    # one direction of 0.1 mm among three axes
    assert uncertainty == pytest.approx(0.1 / np.sqrt(3.0))


def test_the_uncertainty_contains_scatter_and_discrepancy():
    _, plain = predict(model(), stops(), ONES)
    _, more = predict(model(repeatability_mm=0.03, discrepancy_mm=0.04), stops(), ONES)

    assert np.sqrt(more**2 - plain**2) == pytest.approx(0.05)


def test_the_nominal_prediction_knows_no_parameter():
    readings = PointReadings(stops(), ONES, nominal(), np.full(len(ONES), 0.01))

    assert judge(model(), readings, 0.0).nominal_mm == pytest.approx(np.zeros((len(ONES), 3)), abs=1e-9)


def test_another_number_of_joints_is_refused():
    with pytest.raises(ConfigurationError, match="has 6 joints, but the rows have 5"):
        predict(model(), Stops(np.arange(5), JOINTS[:, :5]), ONES)


@pytest.mark.parametrize("nest", [0, 4])
def test_an_unknown_nest_is_refused(nest):
    with pytest.raises(ConfigurationError, match=f"Nest {nest} is unknown: the model has nests 1 to 3"):
        predict(model(), stops(), np.full(5, nest))


@pytest.mark.parametrize("torque", [None, np.where(np.arange(30).reshape(5, 6) == 8, np.nan, 1.0)])
def test_a_model_of_measured_torques_needs_them_for_every_row(torque):
    with pytest.raises(ConfigurationError, match="tau1_Nm"):
        predict(with_spring(torques_measured=True), stops(torque_n_mm=torque), ONES)


def test_measured_torques_turn_the_joint_by_spring_times_torque():
    torque = np.zeros((5, 6))
    torque[:, 1] = 1000.0

    position, _ = predict(with_spring(torques_measured=True), stops(torque_n_mm=torque), ONES)

    turned = JOINTS.copy()
    turned[:, 1] += SPRING * 1000.0
    assert position == pytest.approx(nominal_chain(IRB_120, turned).points(np.array(NESTS[0])), abs=1e-9)


def test_a_model_of_masses_takes_no_notice_of_measured_torques():
    """Its springs were identified with gravity's torques: others, with friction in them, are not theirs."""
    without, _ = predict(with_spring(), stops(), ONES)
    beside, _ = predict(with_spring(), stops(torque_n_mm=np.full((5, 6), 1e5)), ONES)

    assert np.array_equal(without, beside)


def test_the_base_is_where_the_model_says():
    placed, _ = predict(model(base=FramePlacement(100.0, -50.0, 7.0, rz_rad=np.pi / 2)), stops(), ONES)
    plain, _ = predict(model(), stops(), ONES)

    turned = np.column_stack([-plain[:, 1], plain[:, 0], plain[:, 2]])
    assert placed == pytest.approx(turned + np.array([100.0, -50.0, 7.0]), abs=1e-9)


def test_no_rows_give_no_predictions():
    empty = Stops(np.zeros(0, dtype=np.int64), np.zeros((0, 6)))

    for known in (model(), with_spring()):
        position, uncertainty = predict(known, empty, np.zeros(0, dtype=np.int64))

        assert position.shape == (0, 3) and uncertainty.shape == (0,)


def state_of(told):
    return evaluate(structure_of(told), values_of(told), Targets(stops(), ONES))


def test_where_a_nest_is_is_as_uncertain_as_where_it_is_seen():
    told = model(repeatability_mm=0.03, discrepancy_mm=0.04)
    _, seen = predict(told, stops(), ONES)

    assert placed_variance(told, state_of(told)) == pytest.approx(seen**2)
    assert seen**2 == pytest.approx(0.01 / 3.0 + 0.03**2 + 0.04**2)


def test_the_scale_of_the_instrument_moves_what_is_seen_and_no_nest():
    scale = Parameter("scale", "instrument_scale", 0.0, "1", 1e-4, 1e-3)
    told = model(effects=("instrument_scale",), parameters=(scale,), covariance=np.array([[1e-8]]))

    _, seen = predict(told, stops(), ONES)

    assert placed_variance(told, state_of(told)) == pytest.approx(np.zeros(5), abs=1e-20)
    assert (seen > 0.01).all()


@pytest.mark.parametrize(("name", "turned"), [("theta_4", 1e-6 / 3.0), ("alpha_4", 1e-6 / 3.0), ("d_4", 0.0)])
def test_the_last_frame_turns_with_angles_and_no_lengths(name, turned):
    told = model(
        parameters=(Parameter(name, "geometry", 0.0, "rad", 1e-3, 1.0),), covariance=np.array([[1e-6]])
    )

    assert turned_variance(told, state_of(told)) == pytest.approx(np.full(5, turned))
