"""Set-ups: the ball in nest 1 at every cup, well inside the limits, and a way off the cup."""

import numpy as np
import pytest

from tests.helpers.ballbar.cells import IRB_120, LR_MATE, ballbar_cell, fixture_before_the_arm, frame
from truepose.planning.ballbar.bodies import base_fixture, chain_of, tool_normal
from truepose.planning.ballbar.clearance import arm_room_mm, bodies_at, without_cups
from truepose.planning.ballbar.motion_clearance import Stop, Surroundings, can_lift
from truepose.planning.ballbar.poses import inside, orientations_facing, setup_joints, setups
from truepose.planning.errors import WorkSpaceError


@pytest.mark.parametrize("points", [3, 4])
def test_at_each_set_up_nest_1_is_at_its_cup(points):
    cell, fixture = ballbar_cell(), fixture_before_the_arm(points)

    found = setups(cell, fixture)

    joints = np.array([setup.joints_rad for setup in found])
    assert [setup.base_point for setup in found] == list(range(1, points + 1))
    assert chain_of(cell, joints).points(cell.nests_mm[0]) == pytest.approx(fixture.cups_mm, abs=1e-6)


@pytest.mark.parametrize("name", [LR_MATE, IRB_120])
def test_set_ups_are_inside_their_ranges_and_the_tool_faces_the_cup(name):
    cell, fixture = ballbar_cell(name), base_fixture(1, frame(300, -150, 100))

    found = setups(cell, fixture)

    joints = np.array([setup.joints_rad for setup in found])
    opens = chain_of(cell, joints).end_rotation @ tool_normal(cell.nests_mm)
    assert inside(cell.ranges, joints).min() > 0.05
    assert np.einsum("ni,ni->n", opens, -fixture.axes).min() > np.cos(np.radians(46.0))


def test_but_for_the_two_cups_about_the_ball_everything_keeps_its_room():
    cell, fixture = ballbar_cell(), fixture_before_the_arm()

    for setup in setups(cell, fixture):
        bodies = bodies_at(cell, fixture, np.array([setup.joints_rad]))
        assert arm_room_mm(without_cups(bodies, setup.base_point))[0] >= cell.arm_room_mm
        assert can_lift(Surroundings(cell, fixture), Stop(np.array(setup.joints_rad), setup.base_point))


def test_each_orientation_above_a_cup_is_tried_once():
    rotations, tilts = orientations_facing(ballbar_cell(), np.array([0.0, 0.0, 1.0]))

    assert len(np.unique(rotations.round(9), axis=0)) == len(rotations) == len(tilts)
    assert np.unique(tilts.round(9)) == pytest.approx(np.radians([0.0, 15.0, 30.0, 45.0]))


def test_a_cup_out_of_reach_is_named():
    far = base_fixture(2, frame(2000, 0, 100))

    assert setup_joints(ballbar_cell(), far, 1) is None
    with pytest.raises(WorkSpaceError, match="base point 1 of placement 2"):
        setups(ballbar_cell(), far)


def test_a_cup_that_cannot_be_reached_clear_is_named():
    with pytest.raises(WorkSpaceError, match="cannot hold the setting ball"):
        setups(ballbar_cell(arm_room_mm=400.0), fixture_before_the_arm())


def test_how_far_inside_is_a_share_of_the_range():
    cell = ballbar_cell(IRB_120)

    middle = np.array([[(limit.lower_rad + limit.upper_rad) / 2 for limit in cell.ranges]])
    edge = middle.copy()
    edge[0, 2] = cell.ranges[2].upper_rad

    assert inside(cell.ranges, middle) == pytest.approx([0.5])
    assert inside(cell.ranges, edge) == pytest.approx([0.0])
