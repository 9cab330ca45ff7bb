"""Once the cups are clamped the arm backs off so far that two hands and the ballbar have room."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import IRB_120, LR_MATE, ballbar_cell, fixture_before_the_arm, frame
from truepose.planning.ballbar.bodies import base_fixture, chain_of
from truepose.planning.ballbar.clearance import bodies_at, hands_room_mm
from truepose.planning.ballbar.motion_clearance import Stop, Surroundings, between, is_clear_along
from truepose.planning.ballbar.paths import ROOMS_MM, away
from truepose.planning.ballbar.poses import reach, setups
from truepose.planning.errors import NoWayError

NO_POSES = np.zeros((0, 6))


def last_set_up(cell, fixture):
    held = setups(cell, fixture)[-1]
    return Stop(np.array(held.joints_rad), held.base_point)


def planned(cell, fixture, poses=NO_POSES):
    return away(Surroundings(cell, fixture), last_set_up(cell, fixture), poses, np.random.default_rng(0))


@pytest.mark.parametrize("robot", [LR_MATE, IRB_120])
@pytest.mark.parametrize("points", [3, 4])
def test_no_nest_and_nothing_that_moves_is_near_to_a_cup_or_to_a_side(robot, points):
    cell, fixture = ballbar_cell(robot), fixture_before_the_arm(points)

    found = planned(cell, fixture)

    joints = np.array([found.joints_rad])
    nests = np.array([chain_of(cell, joints).points(nest)[0] for nest in cell.nests_mm])
    apart = np.linalg.norm(nests[:, None] - fixture.cups_mm, axis=2)
    assert apart.min() >= ROOMS_MM[0]
    assert hands_room_mm(bodies_at(cell, fixture, joints))[0] >= ROOMS_MM[0]


def test_over_the_last_cup_itself_there_is_no_room_for_hands():
    cell, fixture = ballbar_cell(), fixture_before_the_arm()

    held = last_set_up(cell, fixture).joints_rad

    # The tool's own cup is 10 mm behind the ball's centre and 8 mm thick.
    assert hands_room_mm(bodies_at(cell, fixture, held[None]))[0] < 3.0


def test_the_way_off_the_cup_is_clear():
    cell, fixture = ballbar_cell(), fixture_before_the_arm()

    found = planned(cell, fixture)

    lifted, *rest = [np.array(p) for p in (*found.via_rad, found.joints_rad)]
    for point in rest:
        assert is_clear_along(Surroundings(cell, fixture), between(lifted, point))
        lifted = point


def test_where_the_arm_cannot_go_straight_back_one_of_the_poses_will_do():
    # so near to the arm that its ranges forbid to lift the tool by as much
    cell, fixture = ballbar_cell(), base_fixture(1, frame(300, 60, 270, -5, -5, 50))
    poses = reach(cell, fixture).joints_rad

    with pytest.raises(NoWayError):
        planned(cell, fixture)
    found = planned(cell, fixture, poses)

    assert found.joints_rad in {tuple(pose) for pose in poses.tolist()}
    assert hands_room_mm(bodies_at(cell, fixture, np.array([found.joints_rad])))[0] >= ROOMS_MM[-1]


def test_where_nothing_leaves_room_the_place_is_refused():
    cell, fixture = ballbar_cell(), fixture_before_the_arm()
    held = last_set_up(cell, fixture)
    tight = Surroundings(replace(cell, arm_room_mm=1000.0), fixture)

    with pytest.raises(
        NoWayError, match="cannot retract from base point 3 of placement 1 far enough to leave 70"
    ):
        away(tight, held, NO_POSES, np.random.default_rng(0))
