"""Reachable poses: their legs are nominal, nothing touches, and what is refused says why."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import IRB_120, ballbar_cell, fixture_before_the_arm, frame
from tests.helpers.ballbar.nominal_poses import nominal_lengths, reachable
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.planning.ballbar.bodies import BallbarCell, base_fixture
from truepose.planning.ballbar.poses import device, in_hand_order, reach

# Tool triangles of 150.0000 mm in the shipped files are rounded to micrometres; legs feel it twice.
LEG = 1e-4


@pytest.mark.parametrize("points", [3, 4])
def test_every_leg_of_every_pose_is_300_mm_long(points):
    cell, fixture = ballbar_cell(), fixture_before_the_arm(points)

    poses = reachable(cell, fixture)

    for pose in poses:
        lengths = nominal_lengths(cell, fixture.cups_mm, pose.legs)(np.array([pose.joints_rad]))
        assert lengths == pytest.approx(np.full((1, 6), 300.0), abs=LEG)
    assert len(poses) > 50


def test_joints_are_within_the_ranges_and_configurations_are_numbered_through():
    cell = ballbar_cell()

    poses = reachable(cell, fixture_before_the_arm(), first_config=7)

    joints = np.array([pose.joints_rad for pose in poses])
    low = [limit.lower_rad for limit in cell.ranges]
    high = [limit.upper_rad for limit in cell.ranges]
    assert np.all((joints >= low) & (joints <= high))
    assert [pose.config for pose in poses] == list(range(7, 7 + len(poses)))


def test_the_arm_of_the_thesis_reaches_about_as_many_poses_as_there():
    # IRB 120: 22 of 72 from the placement that the thesis used, in 39 configurations; where it was, and what
    # it counted as clear, is not said. Of some placements this finds as many.
    found = reach(ballbar_cell(IRB_120), base_fixture(1, frame(350, -150, 80)))

    assert len({assembly.number for assembly in found.assembly}) in range(18, 36)
    assert len(found) in range(30, 60)


def test_both_wrist_solutions_are_offered():
    poses = reachable(ballbar_cell(), fixture_before_the_arm())

    words = [pose.assembly for pose in poses]
    assert any(text.startswith("front/up/no flip, design") for text in words)
    assert any(text.startswith("front/up/flip, design") for text in words)


def test_with_a_fourth_cup_different_three_of_them_carry_poses():
    poses = reachable(ballbar_cell(), fixture_before_the_arm(4))

    used = {tuple(sorted({base for base, _ in pose.legs})) for pose in poses}
    assert len(used) > 1
    assert any(4 in three for three in used)


def test_from_a_placement_out_of_reach_nothing_is_measured_and_it_says_so():
    found = reach(ballbar_cell(), base_fixture(1, frame(3000, 0, 100)))

    assert len(found) == 0
    assert found.refused["out of reach"] == 72 * 8
    assert reachable(ballbar_cell(), base_fixture(1, frame(3000, 0, 100))) == ()


def test_joints_that_may_not_move_leave_nothing():
    cell = replace(ballbar_cell(), ranges=(JointRange(0.0, 0.0),) * 6)

    found = reach(cell, fixture_before_the_arm())

    assert len(found) == 0
    assert found.refused["joints out of range"] > 0


def test_a_base_fixture_in_the_arms_own_column_leaves_nothing():
    found = reach(ballbar_cell(), base_fixture(1, frame(-150, -90, 100)))

    assert len(found) == 0


def test_a_leg_without_room_keeps_its_pose_out():
    roomy, tight = ballbar_cell(), ballbar_cell(bar_room_mm=60.0)
    fixture = fixture_before_the_arm()

    found = reach(tight, fixture)

    assert found.refused["insufficient clearance of the ballbar"] > 0
    assert len(found) < len(reach(roomy, fixture))


def test_a_table_that_comes_up_to_the_tool_leaves_nothing():
    found = reach(ballbar_cell(table_z_mm=700.0), fixture_before_the_arm())

    assert len(found) == 0
    assert found.refused["insufficient clearance of arm or tool"] > 0


def test_an_arm_that_stands_elsewhere_reaches_the_same_poses_from_its_fixture():
    fixture = base_fixture(1, frame(350, -150, 80))
    moved = base_fixture(1, frame(1350, 1850, 180))

    here = reach(ballbar_cell(), fixture)
    there = reach(ballbar_cell(base=frame(1000, 2000, 100), table_z_mm=100.0), moved)

    assert there.joints_rad == pytest.approx(here.joints_rad, abs=1e-9)


def test_the_assemblies_of_the_device_are_the_measurable_ones():
    cell = ballbar_cell()

    assert len(device(cell, base_fixture(1, frame(0, 0, 0)))) == 72
    assert len(device(cell, base_fixture(1, frame(0, 0, 0), 4))) == 288


def test_from_leg_to_leg_one_ball_stays_where_it_is():
    for pose in reachable(ballbar_cell(), fixture_before_the_arm()):
        steps = zip(pose.legs, pose.legs[1:], strict=False)
        assert all(a[0] == b[0] or a[1] == b[1] for a, b in steps)
        assert len(set(pose.legs)) == 6


def test_legs_that_share_nothing_keep_their_order():
    assert in_hand_order([(2, 2), (1, 1)]) == ((1, 1), (2, 2))


def test_two_nests_are_not_enough():
    cell = ballbar_cell()

    with pytest.raises(ConfigurationError, match="three tool nests"):
        BallbarCell(cell.robot, cell.base, cell.nests_mm[:2], cell.ranges)


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"ranges": (JointRange(-1.0, 1.0),)}, "1 joint ranges were given for 6 joints"),
        ({"link_radii_mm": (10.0, 10.0)}, "2 radii were given"),
    ],
)
def test_what_does_not_fit_the_arm_is_refused(given, words):
    with pytest.raises(ConfigurationError, match=words):
        replace(ballbar_cell(), **given)
