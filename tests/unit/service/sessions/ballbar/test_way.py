"""From wherever the arm stands it follows planned ways only."""

from tests.unit.service.sessions.ballbar.sessions import (
    KIT,
    Story,
    found,
    joints,
    make_plan,
    make_pose,
    without_away,
)
from truepose.sessions.ballbar.plan import steps, ways

PLAN = make_plan((1, 2, 3), (4,), precalibrate_after=3)


def pose(config, place=1):
    return f"placement-{place}/pose-{config}/move"


def between(here, there, plan=PLAN):
    return ways(plan, tuple(steps(plan, KIT)), {}).between(here, there)


def test_the_next_stop_is_reached_as_planned():
    assert between(pose(1), pose(2)) == (joints(2.5),)


def test_the_first_stop_is_reached_as_planned_from_anywhere():
    assert between(None, "placement-1/cup-1/move") == ()
    assert between("no such stop", pose(2)) == (joints(2.5),)


def test_the_first_pose_is_reached_from_the_stop_off_the_cups():
    away = "placement-1/away/move"

    assert between("placement-1/cup-3/move", away) == (joints(-14.5),)
    assert between(away, pose(1)) == (joints(1.5),)


def test_where_the_first_pose_is_left_out_the_second_is_reached_from_off_the_cups_by_way_of_it():
    assert between("placement-1/away/move", pose(2)) == (joints(1.5), joints(1), joints(2.5))


def test_back_to_the_last_cup_the_arm_goes_by_way_of_the_stop_off_the_cups():
    assert between(pose(1), "placement-1/cup-3/move") == (joints(1.5), joints(-15), joints(-14.5))


def test_in_a_plan_without_a_stop_off_the_cups_the_first_pose_is_reached_from_the_last_cup():
    plan = without_away(PLAN)

    assert between("placement-1/cup-3/move", pose(1), plan) == (joints(1.5),)
    assert between(None, "placement-2/cup-1/move", plan) == between(None, "placement-2/cup-1/move")


def test_a_stop_that_is_left_out_is_passed():
    assert between(pose(1), pose(3)) == (joints(2.5), joints(2), joints(3.5))


def test_the_way_back_is_the_way_forth_reversed():
    assert between(pose(3), pose(1)) == (joints(3.5), joints(2), joints(2.5))


def test_where_the_arm_stands_already_there_is_no_way():
    assert between(pose(2), pose(2)) == ()


def test_a_course_has_both_ends_where_a_planned_way_joins_them():
    known = ways(PLAN, tuple(steps(PLAN, KIT)), {})

    assert known.course(pose(1), pose(3)) == (joints(1), joints(2.5), joints(2), joints(3.5), joints(3))
    assert known.course(pose(2), pose(2)) == (joints(2), joints(2))
    assert known.course("no such stop", pose(2)) == (joints(2.5), joints(2))
    assert known.course(None, pose(2)) == (joints(2.5), joints(2))


def test_a_new_placement_is_reached_from_the_pose_that_was_planned_last_wherever_the_arm_went_since():
    # pose 1 was skipped and is tried again after pose 3, which was planned last
    story = Story(make_plan((1, 2, 3), (4,), precalibrate_after=9)).until(pose(1))
    story.skip()
    story.until("placement-1/precalibrate-1")
    story.do(found(make_pose(1, via_rad=(joints(1.3),))))

    story.until("placement-2/cup-1/move")

    assert story.now.last_stop == "placement-1/pose-1/again/move"
    assert story.now.step.via_rad == (joints(1.3), joints(3))  # back to pose 3, where the planned way begins


def test_after_a_pre_calibration_ways_begin_where_the_arm_stood_then_and_not_at_a_pose_that_was_skipped():
    story = Story(make_plan((1, 2, 3, 4), precalibrate_after=2)).until(pose(1))
    story.until(pose(2))
    story.skip()  # the arm never went there
    story.until("placement-1/precalibrate-1")

    story.do(found(make_pose(4, via_rad=(joints(4.3),)), make_pose(2, via_rad=(joints(2.4),))))

    assert story.present == pose(4)
    assert story.now.step.via_rad == (joints(4.3),)
