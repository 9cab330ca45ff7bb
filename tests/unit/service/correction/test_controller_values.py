"""What a controller can take of a model, against what was put into the model."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120, SEVEN_AXES
from tests.helpers.identification.models import extended, model_of, parameters_of
from tests.helpers.identification.zones import zoned
from truepose.correction.reduced_models import (
    CONFIGURATIONS,
    controller_values,
    three_point_frame,
    zone_targets,
)
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NestCentre
from truepose.identification.model.validity import measured_zone, outside
from truepose.kinematics.frames import placement_rotation, placement_translation

OFFSETS = (2e-3, -1e-3, 5e-4, -3e-3, 1e-3)
THREE_NESTS = tuple(
    NestCentre(k, centre)
    for k, centre in enumerate([(0.0, 0.0, 125.0), (75.0, 93.7, 215.0), (150.0, 0.0, 125.0)], 1)
)


def of_zeros(robot=IRB_120, **changes):
    """A robot whose joints are off by zeros alone, and which stands askew."""
    zeros = [(f"theta_{k}", offset, "rad") for k, offset in enumerate(OFFSETS, 2)]
    parameters = parameters_of("joint_offset", zeros) + parameters_of("base", [("base_x", 2.0, "mm")])
    nests = {"nests": THREE_NESTS, "nominal_nests": THREE_NESTS}
    return zoned(model_of(robot, *parameters, **(nests | changes)))


def test_zeros_base_and_tool_come_back_from_a_robot_that_is_off_by_nothing_else():
    values = controller_values(of_zeros())

    # The last zero and a turn of the tool about the last axis are one thing: nests take their share of it.
    assert values.joint_zeros_rad[:5] == pytest.approx((0.0, *OFFSETS[:4]), abs=1e-7)
    assert values.base.x_mm == pytest.approx(102.0, abs=1e-4)
    assert values.controller.max_mm < 1e-3 < values.nominal.mean_mm


def test_a_joint_that_counts_backwards_has_its_zero_in_its_own_sense():
    zeros = parameters_of("joint_offset", [("theta_2", 2e-3, "rad"), ("theta_5", 1e-3, "rad")])
    values = controller_values(zoned(model_of(SEVEN_AXES, *zeros)))

    assert values.joint_zeros_rad[1] == pytest.approx(-2e-3, abs=1e-6)
    assert values.joint_zeros_rad[4] == pytest.approx(-1e-3, abs=1e-6)


def test_what_a_controller_reaches_lies_between_the_nominal_robot_and_the_model():
    values = controller_values(zoned(extended(IRB_120)))

    assert 0.01 < values.controller.mean_mm < values.nominal.mean_mm
    assert values.controller.mean_mm < values.controller.max_mm


def test_the_model_itself_is_as_good_as_its_uncertainty_says():
    values = controller_values(of_zeros(discrepancy_mm=0.03, repeatability_mm=0.04))

    # Mean length of a normal vector with 0.05 mm per axis.
    assert values.model.mean_mm == pytest.approx(0.05 * np.sqrt(8.0 / np.pi), rel=1e-6)


def test_the_world_in_the_base_undoes_the_base_in_the_world():
    values = controller_values(of_zeros())

    both = placement_rotation(values.base) @ placement_rotation(values.world)
    place = placement_rotation(values.base) @ placement_translation(values.world)
    assert both == pytest.approx(np.eye(3), abs=1e-12)
    assert place + placement_translation(values.base) == pytest.approx(np.zeros(3), abs=1e-9)


def test_the_same_model_gives_the_same_values():
    assert controller_values(of_zeros()) == controller_values(of_zeros())


@pytest.mark.parametrize(
    "model", [replace(of_zeros(), zone=None), replace(of_zeros(), torques_measured=True)]
)
def test_a_model_of_which_nobody_knows_the_zone_is_refused(model):
    with pytest.raises(ConfigurationError, match="does not state its measured zone, or needs torques"):
        controller_values(model)


def test_a_zone_of_one_configuration_is_that_configuration():
    there = np.array([[0.1, 0.4, -0.3, 0.2, 0.5, 0.0]])
    model = replace(of_zeros(), zone=measured_zone(IRB_120, there))

    targets = zone_targets(model, 3)

    assert np.ptp(targets.stops.joints_rad, axis=0).max() == 0.0
    assert controller_values(model).controller.max_mm < 0.01


def test_a_hull_that_holds_nothing_of_its_joint_ranges_says_nothing():
    nowhere = replace(of_zeros().zone, extents_mm=(-1e4,) * 26)

    assert zone_targets(replace(of_zeros(), zone=nowhere), 3) is None


def test_configurations_of_the_zone_are_within_it():
    model = of_zeros()
    targets = zone_targets(model, 3)

    beyond_mm, beyond_rad = outside(model.zone, model.robot, targets.stops.joints_rad)
    assert len(targets) == 3 * CONFIGURATIONS
    assert beyond_mm.max() < 1e-6 and beyond_rad.max() == 0.0


def test_three_points_make_a_frame_and_points_on_a_line_none():
    frame = three_point_frame(np.array([[1.0, 2.0, 3.0], [1.0, 12.0, 3.0], [-4.0, 3.0, 3.0]]))

    x, y, z = placement_rotation(frame).T
    assert placement_translation(frame) == pytest.approx([1.0, 2.0, 3.0])
    assert (x, y, z) == (pytest.approx([0, 1, 0]), pytest.approx([-1, 0, 0]), pytest.approx([0, 0, 1]))
    assert three_point_frame(np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [5.0, 0.0, 0.0]])) is None
    assert three_point_frame(np.zeros((2, 3))) is None
