"""A plan that cannot be done is refused before anything moves, with one sentence."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, domain_cell
from tests.helpers.ballbar.early_sessions import plan_of
from tests.unit.service.sessions.ballbar.sessions import (
    CUPS,
    KIT,
    KIT_OF_FOUR,
    LEGS,
    joints,
    make_plan,
    make_sphere_plan,
)
from tests.unit.service.sessions.tracker.fakes import IRB120
from truepose.domain.cell import BallbarKit
from truepose.domain.robot import JointRange
from truepose.messages.catalogue import english
from truepose.sessions.ballbar.dry_run import check_plan, dry_run
from truepose.sessions.ballbar.planning import path_warnings_of_plan
from truepose.sessions.engine.interlocks import motion_limits
from truepose.sessions.errors import PlanRefusedError

LIMITS = (JointRange(-1.0, 1.0),) * 6


def with_pose(**changes):
    plan = make_plan((1,))
    placement = plan.placements[0]
    pose = replace(placement.poses[0], **changes)
    return replace(plan, placements=(replace(placement, poses=(pose,)),))


def with_stop(**changes):
    plan = make_sphere_plan(1)
    placement = plan.placements[0]
    stop = replace(placement.poses[0], **changes)
    return replace(plan, placements=(replace(placement, poses=(stop,)),))


def with_placement(**changes):
    plan = make_plan((1,))
    return replace(plan, placements=(replace(plan.placements[0], **changes),))


@pytest.mark.parametrize(
    ("plan", "says"),
    [
        (make_plan(), "no placement"),
        (make_plan(()), "no configuration"),
        (make_plan((1, 1)), "twice"),
        (make_plan((1,), stable_s=0.0), "stable_s"),
        (make_plan((1,), state_age_s=3.0), "2 s"),
        (make_plan((1,), settle_s=float("nan")), "settle_s"),
        (with_placement(number=2), "number them 1, 2"),
        (with_placement(cups_mm=CUPS[:2]), "2 cups"),
        (with_placement(cups_mm=(*CUPS[:2], (150.0, 262.0, 0.0))), "cups 2 and 3 301.90 mm apart"),
        (with_placement(setups=()), "hold the ball"),
        (with_pose(placement=2), "belongs to placement 2"),
        (with_pose(legs=LEGS[:5]), "5 ballbar lengths"),
        (with_pose(legs=(*LEGS, LEGS[0])), "twice"),
        (with_pose(legs=(*LEGS[:5], (4, 1))), "B4-T1"),
        (with_pose(aimed_mm=(300.0,) * 5), "5 target lengths"),
        (with_pose(aimed_mm=(301.5,) * 6), "range of the ballbar"),
        (with_pose(joints_rad=joints(200)), "joint 1 at 114.59 deg"),
        (with_pose(via_rad=(joints(200),)), "The path to the target"),
        (with_pose(joints_rad=(0.0,) * 5), "6 finite joint angles"),
        (with_stop(legs=((2, 2),)), "needs exactly one pair, from base point 1"),
        (with_stop(legs=((1, 2), (1, 3))), "needs exactly one pair, from base point 1"),
        (with_stop(legs=((1, 4),)), "needs exactly one pair, from base point 1"),
        (with_stop(aimed_mm=(301.5,)), "range of the ballbar"),
        (replace(make_plan((1,)), test="sphere"), "for each cup: 1."),
    ],
)
def test_a_plan_that_cannot_be_done_is_refused_with_one_sentence(plan, says):
    with pytest.raises(PlanRefusedError) as refused:
        check_plan(plan, KIT, IRB120, LIMITS)

    assert says in str(refused.value)
    assert str(refused.value).endswith(".")


def test_a_plan_for_three_cups_is_refused_for_a_fixture_of_four():
    with pytest.raises(PlanRefusedError):
        check_plan(make_plan((1,)), KIT_OF_FOUR, IRB120, LIMITS)


def test_a_good_plan_passes_and_says_what_it_amounts_to():
    plan = make_plan(tuple(range(1, 40)))

    check_plan(plan, KIT, IRB120, LIMITS)
    run = dry_run(plan, KIT)

    assert (run.poses, run.moves, run.readings) == (39, 43, 4 + 4 + 39 * 7)
    assert run.duration_s < 3600.0  # thesis: under one hour for 39


def test_a_sphere_test_passes_and_reads_the_calibrator_now_and_then():
    plan = make_sphere_plan(39)

    check_plan(plan, KIT, IRB120, LIMITS)
    run = dry_run(plan, KIT)

    assert (run.poses, run.moves, run.readings) == (39, 41, 39 + 4)


def test_nothing_moves_where_no_limits_are_known():
    with pytest.raises(PlanRefusedError):
        motion_limits(replace(IRB120, calibration_ranges=None), None)


def test_a_stop_that_touches_the_table_is_refused_and_a_way_near_it_is_told():
    plan = plan_of(ballbar_cell(), poses=3)
    (placement,) = plan.placements
    in_the_table = replace(
        placement.poses[1], joints_rad=tuple(np.radians([0.0, 110.0, 40.0, 0.0, 0.0, 0.0]))
    )
    poses = (placement.poses[0], in_the_table, placement.poses[2])

    told = path_warnings_of_plan(domain_cell(), plan, BallbarKit())
    with pytest.raises(PlanRefusedError) as refused:
        path_warnings_of_plan(
            domain_cell(), replace(plan, placements=(replace(placement, poses=poses),)), BallbarKit()
        )

    assert "below floor or table" in english(told)
    assert refused.value.text.key == "room.at.step"
    assert dict(refused.value.text.values)["step"] == "placement-1/pose-2/move"
