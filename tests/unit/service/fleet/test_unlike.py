"""Campaigns that are none of their robot, and fleets in which all are."""

import numpy as np
import pytest

from tests.helpers.fleet.linear import drawn
from truepose.fleet.causes import AgeingCause
from truepose.fleet.changes import account_of
from truepose.fleet.trials import Change, Trial

CHANGE = Change("robot", "robot 1", AgeingCause("backlash", "joint 4", np.eye(4)), "step", 30.0, np.ones(2))
_GAP = np.array([0.0, 0.0, 1.0, 0.0])
_BETWEEN = (0.5, 0.4, 0.3)


def _own(seed, robots=6):
    """Return what `drawn` draws each robot to differ by from its type, shape (robots, 4)."""
    rng = np.random.default_rng(seed)
    rng.standard_normal(3)
    return np.column_stack([np.array(_BETWEEN) * rng.standard_normal((robots, 3)), np.zeros(robots)])


def _account(seed, drift=None):
    return account_of(drawn(seed, readings=60, months=5, robot=_BETWEEN, drift=drift).fleet())


def test_robots_that_were_taken_for_each_other_on_one_day_are_told_and_left_out():
    own, other = _own(31), {1: 4, 4: 1}

    account = _account(
        31, lambda i, k, month: own[other[i]] - own[i] if i in other and month == 2 else np.zeros(4)
    )

    assert {(one.robot, one.day, one.resembles) for one in account.unlike} == {
        ("robot 1", 60.0, "robot 4"),
        ("robot 4", 60.0, "robot 1"),
    }
    assert {one.place for one in account.unlike} == {1 * 5 + 2, 4 * 5 + 2}
    assert account.named == ()
    assert len(account.fleet.day) == 28


def test_a_campaign_of_a_robot_that_nobody_knows_resembles_none():
    account = _account(32, lambda i, k, month: np.array([1.5, -1.2, 1.0, 0.0]) * ((i, month) == (3, 4)) + 0.0)

    assert [(one.robot, one.resembles) for one in account.unlike] == [("robot 3", "")]
    assert account.named == ()


@pytest.mark.parametrize("seed", range(33, 37))
def test_where_all_are_of_their_robots_none_is_left_out(seed):
    assert _account(seed).unlike == ()


def test_a_robot_that_changed_in_one_cause_is_no_other_robot():
    account = _account(38, lambda i, k, month: 1.5 * ((i, month) == (2, 4)) * _GAP)

    assert account.unlike == ()
    assert [(one.change.of, one.change.kind, one.change.since) for one in account.named] == [
        ("robot 2", "step", 120.0)
    ]


def test_what_other_causes_show_over_the_same_campaigns_makes_a_change_less_certain():
    def trial(squares):
        return Trial(CHANGE, 1.0, 1.0, 1.0, squares, 2)

    calm, wild = [trial(1.4)] * 9, [trial(4.2)] * 9  # the median of chi-square of 2 degrees is 1.39

    assert trial(30.0).chance_beside(calm) == pytest.approx(np.exp(-15.0), rel=0.2)
    assert trial(30.0).chance_beside(wild) == pytest.approx(np.exp(-5.0), rel=0.2)
    assert trial(30.0).chance_beside([]) == pytest.approx(np.exp(-15.0))
