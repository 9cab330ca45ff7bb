"""Before anything is measured it is said at which poses an exchange hardly shows."""

from dataclasses import replace

import pytest

from tests.helpers.ballbar.cells import ballbar_cell
from tests.helpers.ballbar.early_sessions import KIT, plan_of
from truepose.planning.ballbar.length_forecast import SessionForecast, unseen_swaps


@pytest.fixture(scope="module")
def plan():
    return plan_of(ballbar_cell(), poses=12)


def test_the_first_poses_are_named_and_later_ones_are_not(plan):
    unseen = unseen_swaps(SessionForecast(ballbar_cell(), plan, KIT), plan, KIT)

    assert unseen[:3] == (1, 2, 3)
    assert 12 not in unseen


def test_poses_after_the_pre_calibration_are_coded_and_never_named(plan):
    early = replace(plan, precalibrate_after=2)

    assert unseen_swaps(SessionForecast(ballbar_cell(), plan, KIT), early, KIT) == (1, 2)


def test_a_leg_that_is_read_twice_is_exchanged_with_itself_unseen(plan):
    (placement,) = plan.placements
    poses = tuple(replace(pose, legs=(*pose.legs[:5], pose.legs[0])) for pose in placement.poses)
    twice = replace(plan, placements=(replace(placement, poses=poses),))

    assert 1 in unseen_swaps(SessionForecast(ballbar_cell(), twice, KIT), twice, KIT)
