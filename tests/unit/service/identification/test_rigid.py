"""What other programs can take of a model, against the model itself."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import (
    EXTENSIONS,
    ROBOTS,
    extended,
    model_of,
    parameters_of,
    plain_parameters,
)
from truepose.domain.campaign import Stops
from truepose.identification.model.estimates import rigid_arm
from truepose.identification.model.prediction import predict
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import placement_rotation, placement_translation

RIGID = {"axis_parallelism", "nest_offset", "tool_certificate"}


def geometric(robot, seed=1):
    """A model of base, tool and table alone."""
    parameters = [p for p in plain_parameters(robot, seed) if p.effect != "compliance"]
    return model_of(robot, *parameters)


def places(arm, joints, nest):
    chain = forward(
        nominal_values(arm.robot, joints), placement_rotation(arm.base), placement_translation(arm.base)
    )
    return chain.points(np.array([arm.nests[k - 1].centre_mm for k in nest]))


@pytest.mark.parametrize("robot", ROBOTS.values(), ids=ROBOTS)
def test_a_geometric_model_is_all_there(robot):
    model = geometric(robot)
    rng = np.random.default_rng(4)
    joints, nest = rng.uniform(-3.0, 3.0, (200, robot.n_joints)), rng.integers(1, 3, 200)

    arm = rigid_arm(model)

    expected, _ = predict(model, Stops(np.arange(200), joints), nest)
    np.testing.assert_allclose(places(arm, joints, nest), expected, atol=1e-9)
    assert arm.left_out == ()


@pytest.mark.parametrize("effect", sorted(EXTENSIONS))
def test_what_is_not_rigid_is_left_out_by_name(effect):
    plain, more = rigid_arm(extended(IRB_120)), rigid_arm(extended(IRB_120, effect))

    added = {p.name for p in more.left_out} - {p.name for p in plain.left_out}
    assert added == (set() if effect in RIGID else {name for name, _, _ in EXTENSIONS[effect]})
    assert {p.effect for p in plain.left_out} == {"compliance"}


def test_a_quantity_of_a_row_is_as_uncertain_as_what_moves_it():
    model = model_of(IRB_120, *plain_parameters(IRB_120))
    names = [p.name for p in model.parameters]
    covariance = np.zeros((len(names), len(names)))
    covariance[names.index("a_3"), names.index("a_3")] = 0.04**2

    arm = rigid_arm(model_of(IRB_120, *model.parameters, covariance=covariance))

    assert arm.uncertainty[2]["a_mm"] == pytest.approx(0.04)
    assert arm.uncertainty[2]["alpha_rad"] == 0.0
    assert arm.uncertainty[0] == {}


def test_a_model_without_parameters_is_the_nominal_arm():
    arm = rigid_arm(model_of(IRB_120, effects=()))

    assert arm.robot == IRB_120
    assert [nest.centre_mm for nest in arm.nests] == [(0.0, 0.0, 125.0), (75.0, 93.7, 215.0)]


def test_a_model_that_knows_no_nest_is_an_arm_without_one():
    arm = rigid_arm(model_of(IRB_120, effects=(), nests=(), nominal_nests=()))

    assert arm.robot == IRB_120
    assert arm.nests == ()


def test_where_lengths_were_read_from_is_none_of_the_robots():
    cup = [(f"anchor_1_2_{axis}", 300.0, "mm") for axis in "xyz"]
    read = parameters_of("legs", [*cup, ("length_offset", 0.1, "mm")])

    assert rigid_arm(model_of(IRB_120, *read, effects=())).left_out == ()
