"""The order of a session follows from its plan and from how its poses ended."""

import pytest

from tests.unit.service.sessions.ballbar.sessions import (
    KIT,
    KIT_OF_FOUR,
    LEGS,
    found,
    joints,
    make_plan,
    make_pose,
    make_sphere_plan,
    without_away,
)
from truepose.domain.ballbar import PoseForecast, StepKind
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.plan import Course, steps


def ids(plan, course=None, kit=KIT):
    return [step.id for step in steps(plan, kit, course)]


def poses_in(names):
    return [
        step_ids.group_of(name).removeprefix("placement-1/")
        for name in names
        if name.endswith("/move") and "pose" in name
    ]


def test_a_session_is_listed_beforehand_in_the_order_of_the_thesis():
    plan = make_plan((12,))

    listed = ids(plan)

    assert listed == [
        "tool/initialise",
        "tool/side-1-2",
        "tool/side-2-3",
        "tool/side-1-3",
        "tool/detach",
        "placement-1/place",
        "placement-1/ball",
        "placement-1/cup-1/move",
        "placement-1/cup-1/clamp",
        "placement-1/cup-2/move",
        "placement-1/cup-2/clamp",
        "placement-1/cup-3/move",
        "placement-1/cup-3/clamp",
        "placement-1/away/move",
        "placement-1/ball-out",
        "placement-1/initialise",
        "placement-1/side-1-2",
        "placement-1/side-2-3",
        "placement-1/side-1-3",
        "placement-1/detach",
        "placement-1/pose-12/move",
        "placement-1/pose-12/initialise",
        *(f"placement-1/pose-12/leg-{b}-{t}" for b, t in LEGS),
        "placement-1/pose-12/detach",
        "placement-1/precalibrate-1",
    ]


def test_off_the_cups_the_arm_goes_by_a_motion_like_any_other():
    (away,) = (step for step in steps(make_plan((12,)), KIT) if "/away/" in step.id)

    assert (away.kind, away.placement, away.config, away.base_point) == (StepKind.MOVE, 1, None, None)
    assert (away.target_rad, away.via_rad) == (joints(-15), (joints(-14.5),))


def test_a_plan_that_was_stored_without_it_has_no_motion_off_the_cups():
    plan = make_plan((1,), (2,))

    listed = ids(without_away(plan))

    assert listed == [name for name in ids(plan) if "/away/" not in name]
    assert len(listed) == len(ids(plan)) - 2


def test_a_fourth_cup_is_clamped_and_tied_to_the_three_others():
    plan = make_plan((12,), n_cups=4)

    listed = ids(plan, kit=KIT_OF_FOUR)

    assert "placement-1/cup-4/clamp" in listed
    assert {f"placement-1/side-{k}-4" for k in (1, 2, 3)} <= set(listed)


@pytest.mark.parametrize("plan", [make_plan((1, 2, 3), (4, 5)), make_plan((7,), n_cups=3)])
def test_every_name_is_unique_and_tells_the_kind_of_its_step(plan):
    listed = list(steps(plan, KIT))

    assert len({step.id for step in listed}) == len(listed)
    assert all(step_ids.kind_of(step.id) is step.kind for step in listed)
    assert all(step_ids.points_of(step.id) == step.points for step in listed if step.points is not None)


def test_the_pre_calibration_comes_once_enough_poses_are_measured():
    plan = make_plan((1, 2, 3, 4), precalibrate_after=2)

    listed = ids(plan)

    place = listed.index("placement-1/precalibrate-1")
    assert poses_in(listed[:place]) == ["pose-1", "pose-2"]
    assert poses_in(listed[place:]) == ["pose-3", "pose-4"]
    assert "placement-1/precalibrate-2" not in listed


def test_a_skipped_pose_does_not_count_and_is_tried_again_after_the_pre_calibration():
    plan = make_plan((1, 2, 3, 4), precalibrate_after=2)
    again = found(make_pose(4), make_pose(1))
    course = Course({"placement-1/pose-1"}, {"placement-1/precalibrate-1": again})

    listed = ids(plan, course)

    place = listed.index("placement-1/precalibrate-1")
    assert poses_in(listed[:place]) == ["pose-1", "pose-2", "pose-3"]
    assert poses_in(listed[place:]) == ["pose-4", "pose-1/again"]


def test_what_was_skipped_twice_is_not_asked_for_a_third_time():
    plan = make_plan((1, 2), precalibrate_after=1)
    skipped = {"placement-1/pose-1", "placement-1/pose-1/again"}
    course = Course(skipped, {"placement-1/precalibrate-1": found(make_pose(1))})

    listed = ids(plan, course)

    assert poses_in(listed) == ["pose-1", "pose-2", "pose-1/again"]


def test_a_pose_whose_legs_were_exchanged_is_asked_for_again_and_again_but_not_for_ever():
    plan = make_plan((1, 2), precalibrate_after=1)
    exchanged = found(exchanged=(1,))
    course = Course(
        frozenset({"placement-1/pose-2"}),
        {f"placement-1/precalibrate-{n}": exchanged for n in range(1, 9)},
    )

    listed = ids(plan, course)

    assert [name for name in poses_in(listed) if "pose-1" in name] == [
        "pose-1",
        "pose-1/again",
        "pose-1/again-2",
    ]


def test_a_fixture_is_not_taken_up_before_its_assignments_are_tested():
    plan = make_plan((1,), (2,), precalibrate_after=12)

    listed = ids(plan)

    assert listed.index("placement-1/precalibrate-1") == listed.index("placement-2/place") - 1


def test_where_nothing_was_measured_nothing_is_pre_calibrated():
    plan = make_plan((1,))

    listed = ids(plan, Course({"placement-1/pose-1"}))

    assert not [name for name in listed if "precalibrate" in name]


def test_a_pre_calibration_that_is_left_out_leaves_the_plan_as_it_was():
    plan = make_plan((1, 2, 3), precalibrate_after=1)

    listed = ids(plan, Course(frozenset(), {"placement-1/precalibrate-1": None}))

    assert poses_in(listed) == ["pose-1", "pose-2", "pose-3"]
    assert listed[-1] == "placement-1/precalibrate-2"  # the swaps of poses 2 and 3 are still untested


def test_targets_and_lengths_are_those_of_the_pre_calibration_once_it_is_there():
    plan = make_plan((1, 2), precalibrate_after=1)
    aimed = make_pose(2, joints_rad=joints(2.2), aimed_mm=(300.7, 300.42, 300.14, 299.86, 299.58, 299.3))
    forecast = PoseForecast(2, LEGS[:1], (300.69,), ((1e-4,),))
    course = Course(found={"placement-1/precalibrate-1": found(aimed, forecasts=(forecast,))})

    listed = {step.id: step for step in steps(plan, KIT, course)}

    assert listed["placement-1/pose-2/move"].target_rad == joints(2.2)
    assert listed["placement-1/pose-2/leg-1-1"].expected_mm == 300.69  # foreseen
    assert listed["placement-1/pose-2/leg-1-2"].expected_mm == 300.42  # coded
    assert listed["placement-1/pose-1/leg-1-2"].expected_mm == 300.0  # nominal


def test_the_first_thing_of_every_group_of_readings_is_the_calibrator():
    for step in steps(make_plan((1, 2, 3), (4,)), KIT):
        if step.kind is StepKind.INITIALISE:
            open_group = step_ids.group_of(step.id)
        if step.kind in {StepKind.MEASURE_SIDE, StepKind.CONNECT_LEG}:
            assert step_ids.group_of(step.id) == open_group


def test_a_short_plan_ends_with_a_test_of_what_was_measured_since():
    plan = make_plan((1, 2, 3), precalibrate_after=2, check_at_end=True)

    listed = ids(plan)

    assert listed[-1] == "placement-1/precalibrate-2"
    assert ids(plan, Course(found={"placement-1/precalibrate-2": found()})) == listed


def test_poses_that_the_last_test_finds_exchanged_are_measured_and_tested_again():
    plan = make_plan((1, 2, 3), precalibrate_after=2, check_at_end=True)
    results = {"placement-1/precalibrate-2": found(make_pose(3), exchanged=(3,))}

    listed = ids(plan, Course(found=results))

    assert "placement-1/pose-3/again/leg-1-1" in listed
    assert listed[-1] == "placement-1/precalibrate-3"


def test_a_last_test_comes_once_for_all_placements():
    plan = make_plan((1, 2), (3, 4), precalibrate_after=1, check_at_end=True)

    listed = [name for name in ids(plan) if "precalibrate" in name]

    assert listed == ["placement-1/precalibrate-1", "placement-2/precalibrate-1"]


def test_a_sphere_test_measures_no_triangle_and_one_leg_a_stop():
    assert ids(make_sphere_plan(2)) == [
        "placement-1/place",
        "placement-1/ball",
        "placement-1/cup-1/move",
        "placement-1/cup-1/clamp",
        "placement-1/away/move",
        "placement-1/ball-out",
        "placement-1/pose-1/move",
        "placement-1/pose-1/initialise",
        "placement-1/pose-1/leg-1-2",
        "placement-1/pose-1/detach",
        "placement-1/pose-2/move",
        "placement-1/pose-2/leg-1-2",
        "placement-1/pose-2/detach",
    ]


def test_the_calibrator_is_read_before_every_tenth_stop_of_a_sphere_test():
    read = [name for name in ids(make_sphere_plan(25)) if name.endswith("initialise")]

    assert [step_ids.group_of(name) for name in read] == [f"placement-1/pose-{k}" for k in (1, 11, 21)]
