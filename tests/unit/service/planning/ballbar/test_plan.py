"""Whole plans: numbers, orders, ways, and what cannot be planned."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, domain_cell, fixture_before_the_arm, frame
from truepose.domain.ballbar import BallbarKit, BallbarPlan, Bars
from truepose.domain.cell import CellLimits
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Nest
from truepose.planning.ballbar.arm_model import arm_model
from truepose.planning.ballbar.bodies import base_fixture, chain_of
from truepose.planning.ballbar.clearance import is_clear
from truepose.planning.ballbar.expected_information import of_poses, pose_rows
from truepose.planning.ballbar.motion_clearance import between
from truepose.planning.ballbar.placements import PlacementRequest, suggest
from truepose.planning.ballbar.plan import ballbar_cell as cell_for
from truepose.planning.ballbar.plan import ballbar_plan, plan_at
from truepose.planning.errors import NoWayError, TooFewCandidatesError, WorkSpaceError
from truepose.planning.workspace.bodies import bodies_of
from truepose.planning.workspace.space import space_to_measure

CELL = ballbar_cell()
AFTER = base_fixture(2, frame(300, 150, 120, 0, 0, 30))


@pytest.fixture(scope="module")
def at_hand():
    return plan_at(CELL, [fixture_before_the_arm()], 24)


def test_every_pose_has_a_number_of_its_own_and_six_legs(at_hand):
    (placement,) = at_hand.placements

    assert [pose.config for pose in placement.poses] == list(range(1, 25))
    assert all(len(set(pose.legs)) == 6 for pose in placement.poses)
    assert all(pose.aimed_mm is None for pose in placement.poses)
    assert len({pose.joints_rad for pose in placement.poses}) == 24


def test_a_placement_at_which_no_pose_is_chosen_says_so():
    with pytest.raises(TooFewCandidatesError, match="None of the 1 poses is best measured from placement"):
        plan_at(CELL, [fixture_before_the_arm(), AFTER], 1)


def test_from_stop_to_stop_the_arm_keeps_room(at_hand):
    (placement,) = at_hand.placements
    fixture = fixture_before_the_arm()

    for before, pose in pairwise(placement.poses):
        points = [np.array(p) for p in (before.joints_rad, *pose.via_rad, pose.joints_rad)]
        for a, b in pairwise(points):
            assert is_clear(replace(CELL, arm_room_mm=9.0), fixture, between(a, b)).all()


def test_the_way_off_the_last_cup_begins_with_a_lift(at_hand):
    (placement,) = at_hand.placements

    held, above = placement.setups[-1].joints_rad, placement.away.via_rad[0]

    nests = chain_of(CELL, np.array([held, above])).points(CELL.nests_mm[0])
    assert np.linalg.norm(nests[1] - nests[0]) >= 60.0 - 1e-6


def test_from_off_the_cups_to_the_first_pose_the_arm_keeps_room(at_hand):
    (placement,) = at_hand.placements
    pose = placement.poses[0]

    points = [np.array(p) for p in (placement.away.joints_rad, *pose.via_rad, pose.joints_rad)]

    for a, b in pairwise(points):
        assert is_clear(replace(CELL, arm_room_mm=9.0), fixture_before_the_arm(), between(a, b)).all()


def test_the_first_poses_are_those_that_the_pre_calibration_needs(at_hand):
    (placement,) = at_hand.placements
    model = arm_model(CELL)
    joints = np.array([pose.joints_rad for pose in placement.poses])
    rows = pose_rows(model, np.array(placement.cups_mm), joints, [pose.legs for pose in placement.poses])
    prior = np.eye(model.parameters + 9)

    def worth(members):
        return np.linalg.slogdet(prior + of_poses(rows, np.array(members)))[1]

    rng = np.random.default_rng(0)
    by_chance = [worth(rng.choice(24, 12, replace=False)) for _ in range(30)]
    assert worth(range(12)) > np.quantile(by_chance, 0.95)


@pytest.fixture(scope="module")
def at_two_places():
    return plan_at(CELL, [fixture_before_the_arm(), AFTER], 20)


def test_configurations_are_numbered_through_all_placements(at_two_places):
    first, second = at_two_places.placements

    assert [placement.number for placement in at_two_places.placements] == [1, 2]
    assert [p.config for p in (*first.poses, *second.poses)] == list(range(1, 21))
    assert {p.placement for p in second.poses} == {2}


def test_while_the_fixture_is_put_to_its_next_place_the_arm_is_out_of_the_way(at_two_places):
    last = at_two_places.placements[0].poses[-1]

    assert is_clear(CELL, AFTER, np.array([last.joints_rad])).all()


def test_the_template_gives_times_and_speeds():
    plan = plan_at(CELL, [fixture_before_the_arm()], 6, template=BallbarPlan((), tool_speed_mm_s=100.0))

    assert plan.tool_speed_mm_s == 100.0
    assert len(plan.placements[0].poses) == 6


def test_a_whole_session_is_planned_from_a_cell():
    plan = ballbar_plan(domain_cell(), poses=20, seed=2, draws=10)

    (placement,) = plan.placements
    assert len(placement.poses) == 20
    assert len(placement.setups) == 3


def test_four_cups_and_another_bar_are_taken_from_what_was_asked():
    kit = BallbarKit(base_bars=Bars(300.0, 300.0, 0.0005, (150.0, 50.0)))

    plan = ballbar_plan(domain_cell(ballbar=kit), base_points=4, poses=20, draws=10)

    assert len(plan.placements[0].cups_mm) == 4
    assert len(plan.placements[0].setups) == 4


def test_from_a_place_out_of_reach_nothing_is_planned():
    with pytest.raises(WorkSpaceError, match="base point 1"):
        plan_at(CELL, [base_fixture(1, frame(3000, 0, 100))], 10)


def test_a_place_where_the_ball_can_be_held_and_no_pose_measured_is_refused():
    with pytest.raises(TooFewCandidatesError, match=r"from placement 1\. Move the base fixture"):
        plan_at(replace(CELL, bar_room_mm=500.0), [fixture_before_the_arm()], 10)


def test_a_next_place_where_the_arm_stands_whatever_it_measured_last_is_refused():
    # the next fixture stands where the tool is in all poses of the first, above its cups
    first = base_fixture(1, frame(450, -200, 80, 0, 0, 60))
    above = base_fixture(2, frame(450, -200, 375, 0, 0, 60))

    with pytest.raises(NoWayError, match="moved to placement 2"):
        plan_at(CELL, [first, above], 10)


@pytest.mark.parametrize(("placements", "poses"), [(0, 10), (3, 2), (1, 0)])
def test_no_session_is_asked_for(placements, poses):
    with pytest.raises(ConfigurationError, match="A session needs at least one placement"):
        ballbar_plan(domain_cell(), placements=placements, poses=poses)


def test_a_tool_with_two_nests_is_refused():
    cell = domain_cell()

    with pytest.raises(ConfigurationError, match="three nests"):
        cell_for(replace(cell, nests=cell.nests[:2]))


def test_a_nest_without_a_centre_is_refused():
    cell = domain_cell()

    with pytest.raises(ConfigurationError, match="centres are known"):
        cell_for(replace(cell, nests=(*cell.nests[:2], replace(cell.nests[2], centre_mm=None))))


def test_the_ranges_of_the_cell_go_before_those_of_the_robot():
    cell = domain_cell()
    narrow = cell.robot.calibration_ranges[::-1]

    assert cell_for(replace(cell, limits=CellLimits(calibration=narrow))).ranges == narrow
    assert cell_for(cell).ranges == cell.robot.calibration_ranges


def test_without_any_range_nothing_is_planned():
    cell = domain_cell()
    unlimited = replace(cell, robot=replace(cell.robot, calibration_ranges=None, joint_limits=None))

    with pytest.raises(WorkSpaceError, match=r"joint ranges of .* are not known"):
        cell_for(unlimited)


@pytest.mark.parametrize(("poses", "after"), [(6, 5), (8, 5), (14, 7)])
def test_a_short_plan_has_its_pre_calibration_halfway_and_ends_with_a_test(poses, after):
    plan = plan_at(ballbar_cell(), [fixture_before_the_arm()], poses, seed=1)

    # The LR Mate has 25 parameters: five poses have 30 lengths.
    assert (plan.precalibrate_after, plan.check_at_end) == (after, True)


def test_a_plan_of_twice_as_many_poses_as_a_pre_calibration_needs_has_it_where_it_was(at_hand):
    assert (at_hand.precalibrate_after, at_hand.check_at_end) == (12, False)


@pytest.mark.parametrize(("floor_z_mm", "table_z_mm"), [(None, 0.0), (120.0, 120.0), (-300.0, -300.0)])
def test_the_floor_that_the_cell_states_is_the_table_of_its_ballbar_plans(floor_z_mm, table_z_mm):
    assert cell_for(domain_cell(limits=CellLimits(floor_z_mm=floor_z_mm))).table_z_mm == table_z_mm


@pytest.mark.parametrize(("foot_z_mm", "floor_z_mm"), [(-800.0, -800.0), (500.0, 0.0)])
def test_a_floor_that_nobody_states_is_one_for_every_plan_and_check(foot_z_mm, floor_z_mm):
    cell = domain_cell(base_nominal=frame(0, 0, foot_z_mm))

    assert cell_for(cell).table_z_mm == floor_z_mm
    assert space_to_measure(cell, None).table_z_mm == floor_z_mm
    assert bodies_of(cell).floor_z_mm == floor_z_mm


def test_tool_nests_on_a_line_are_refused_wherever_the_base_fixture_stands():
    line = tuple(Nest((50.0 * k, 10.0 * k, 120.0), 0.002) for k in (-1.0, 0.0, 1.0))

    with pytest.raises(ConfigurationError, match="tool nests lie on a line"):
        cell_for(replace(domain_cell(), nests=line))


@pytest.mark.parametrize("joints", [2, 6], ids=["two joints", "lengths in metres"])
def test_an_arm_without_links_to_look_at_is_told_that_it_reaches_nothing(joints):
    rows = CELL.robot.joints[:joints]
    if joints == 6:
        rows = tuple(replace(row, a_mm=1e-3 * row.a_mm, d_mm=1e-3 * row.d_mm) for row in rows)
    arm = replace(CELL.robot, joints=rows, masses=(), calibration_ranges=None)
    cell = replace(CELL, robot=arm, ranges=CELL.ranges[:joints], link_radii_mm=())

    with pytest.raises(TooFewCandidatesError, match="the best allows 0"):
        suggest(cell, PlacementRequest(poses=2, draws=8, moves=0, starts=1))
