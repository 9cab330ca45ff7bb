"""P4, P2 and P1 from three perpendicular directions, as a session."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.kinematics.chain import nominal_chain
from truepose.validation.iso9283.plan import Cube, plan_directions, plan_poses

_NEST = (10.0, 20.0, 100.0)
_POSES = plan_poses(IRB_120, Cube((350.0, 0.0, 380.0), 150.0), np.diag([1.0, -1.0, -1.0]), _NEST)


def places_mm(joints_rad):
    return nominal_chain(IRB_120, np.array(joints_rad)).points(np.tile(_NEST, (len(joints_rad), 1)))


def test_each_visit_ends_with_a_way_along_an_axis_of_the_base():
    stops = plan_directions(IRB_120, _POSES, _NEST, approach_mm=40.0).session(nest=2, cycles=4).stops

    ways = places_mm([stop.joints_rad for stop in stops]) - places_mm([stop.begin_rad for stop in stops])
    assert len(stops) == 3 * 4 * 3
    for way, stop in zip(ways, stops, strict=True):
        assert np.abs(way) == pytest.approx(40.0 * np.eye(3)[stop.group - 1], abs=1e-9)
    signs = ways.sum(axis=1).round().reshape(3, 12)
    assert (signs == 40.0).all()  # from the negative side, where both are free


def test_the_cycles_of_a_direction_come_together_from_p4_to_p1():
    session = plan_directions(IRB_120, _POSES, _NEST).session(nest=1)

    stops = session.stops
    assert [stop.config for stop in stops] == list(range(1, 271))
    assert [stop.group for stop in stops] == [1] * 90 + [2] * 90 + [3] * 90
    for number, stop in zip([4, 2, 1] * 90, stops, strict=True):
        assert stop.joints_rad == pytest.approx(_POSES.joints_rad[number - 1])
    first = {stop.config: stop for stop in stops[:3]}
    assert [stop.repeat_of for stop in stops[:3]] == [None] * 3
    assert all(stop.joints_rad == first[stop.repeat_of].joints_rad for stop in stops[3:])
    assert (session.role, session.approach_offset_rad) == ("validation", None)


def with_joint_1_between(low_deg, high_deg):
    """An arm whose joint 1 has so much room beyond what P1, P2 and P4 take."""
    taken = np.degrees(_POSES.joints_rad[[0, 1, 3], 0])
    first = JointRange(*np.radians([taken.min() - low_deg, taken.max() + high_deg]).tolist())
    others = tuple(JointRange(-2.0 * np.pi, 2.0 * np.pi) for _ in range(5))
    return replace(IRB_120, joint_limits=(first, *others))


# For 20 mm joint 1 turns by more than 2 deg along y, and by less than 1.6 deg along x.
@pytest.mark.parametrize(("low_deg", "high_deg", "along_y_mm"), [(9.0, 1.6, 20.0), (1.6, 9.0, -20.0)])
def test_limits_choose_the_side_from_which_the_arm_comes(low_deg, high_deg, along_y_mm):
    plan = plan_directions(with_joint_1_between(low_deg, high_deg), _POSES, _NEST, 20.0)

    way = places_mm(plan.joints_rad) - places_mm(plan.begin_rad[1])
    assert way[:, 1] == pytest.approx(along_y_mm)


def test_a_direction_without_room_is_named():
    with pytest.raises(
        ConfigurationError, match="cannot all be approached from the same side along y of the base"
    ):
        plan_directions(with_joint_1_between(1.6, 1.6), _POSES, _NEST, 20.0)


@pytest.mark.parametrize("approach_mm", [0.0, -5.0, float("nan")])
def test_an_approach_without_length_is_refused(approach_mm):
    with pytest.raises(ConfigurationError, match="approach distance must be greater than 0 mm"):
        plan_directions(IRB_120, _POSES, _NEST, approach_mm)
