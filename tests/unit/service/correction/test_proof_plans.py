"""The plan of a proof: pairs that the arm can reach, each with the room that its approach needs."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.models import model_of, parameters_of, plain_parameters
from tests.unit.service.planning.test_candidates import SPACE
from truepose.correction.proof import plan_proof
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.domain.session import SessionPlan

N, OFFSET_RAD = 20, -0.0873
LOWEST_RAD = SPACE.ranges[1].lower_rad
ROOMY = replace(SPACE, nests=SPACE.nests[:2])  # those that the model has
TEMPLATE = SessionPlan("validation", (), approach_offset_rad=OFFSET_RAD)


def at_the_edge(width_rad):
    """A space whose stops have axis 2 within this of where its approach would begin beyond the limit."""
    first = LOWEST_RAD - OFFSET_RAD
    edge = JointRange(first, first + width_rad)
    return replace(ROOMY, joint_limits=SPACE.ranges, ranges=(SPACE.ranges[0], edge, *SPACE.ranges[2:]))


def planned(space, *parameters):
    model = model_of(SPACE.robot, *parameters)
    return plan_proof(space, TEMPLATE, replace(model, nominal_base=model.base), N, seed=3).stops


def lowest_rad(stops):
    return np.array([stop.joints_rad[1] for stop in stops]) + OFFSET_RAD


def test_a_target_whose_correction_cannot_be_approached_is_left_out_with_its_pair():
    stops = planned(at_the_edge(0.004), *plain_parameters(SPACE.robot))

    assert 0 < len(stops) < 2 * N
    assert len(stops) % 2 == 0
    assert lowest_rad(stops).min() >= LOWEST_RAD


def test_where_there_is_room_no_target_is_left_out():
    assert len(planned(ROOMY, *parameters_of("geometry", [("theta_2", 0.001, "rad")]))) == 2 * N


def test_a_plan_of_no_target_is_refused():
    with pytest.raises(ConfigurationError, match="None of the targets"):
        planned(at_the_edge(0.001), *parameters_of("geometry", [("theta_2", 0.01, "rad")]))
