"""Each interlock by itself: everything else in order, one thing wrong."""

import math
from dataclasses import replace
from itertools import product

import pytest

from tests.helpers.domain.robots import IRB_120
from truepose.domain.robot import JointRange
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.interlocks import (
    MotionConditions,
    common_ranges,
    motion_limits,
    motion_obstacle,
)
from truepose.sessions.errors import PlanRefusedError
from truepose_drivers.api import JointReading

AT = (0.1, -0.2)
LIMITS = (JointRange(-1.0, 1.0), JointRange(-1.0, 1.0))
IN_ORDER = MotionConditions(
    state=SessionState.RUNNING,
    stop_requested=False,
    question=None,
    robot_connected=True,
    reading=JointReading(AT, math.radians(0.01), 100.0),
    now_s=100.5,
    left_at_rad=AT,
    tolerance_rad=0.00035,
)


def test_nothing_speaks_against_a_motion_when_everything_is_in_order():
    assert motion_obstacle(IN_ORDER, (0.5, 0.5), LIMITS) is None


@pytest.mark.parametrize("state", [state for state in SessionState if state is not SessionState.RUNNING])
def test_only_a_running_session_moves(state):
    assert "nothing moves" in english(motion_obstacle(replace(IN_ORDER, state=state), AT, LIMITS))


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"stop_requested": True}, "was requested"),
        ({"question": "Is the cell clear?"}, "question is open"),
        ({"robot_connected": False}, "link to the robot is down"),
        ({"now_s": 102.1}, "2.1 s old"),
        ({"now_s": 97.0}, "-3.0 s old"),
        ({"max_state_age_s": 0.4}, "the limit is 0.4 s"),
        ({"obstacle": "The ballbar may still be attached."}, "ballbar may still be attached"),
        ({"now_s": math.nan}, "nan s old"),
        ({"left_at_rad": (0.1, -0.21)}, "Joint 2 is 0.57 deg away"),
        ({"left_at_rad": (0.1, -0.2, 0.0)}, "reports 2 joints; 3"),
        ({"reading": JointReading((0.1, math.nan), 1e-4, 100.0)}, "Joint 2"),
    ],
)
def test_one_thing_wrong_forbids_motion_and_is_named(wrong, sentence):
    assert sentence in english(motion_obstacle(replace(IN_ORDER, **wrong), AT, LIMITS))


@pytest.mark.parametrize(
    ("target", "sentence"),
    [
        ((1.01, 0.0), "joint 1 at 57.87 deg, limits -57.30 to 57.30 deg"),
        ((0.0, -1.01), "joint 2 at -57.87 deg"),
        ((0.0, math.nan), "joint 2 at nan deg"),
    ],
)
def test_a_target_outside_the_limits_is_never_sent(target, sentence):
    assert sentence in english(motion_obstacle(IN_ORDER, target, LIMITS))


def test_the_limit_itself_is_inside():
    assert motion_obstacle(IN_ORDER, (1.0, -1.0), LIMITS) is None


def test_the_protocols_rounding_is_no_motion_by_others():
    rounded = JointReading((AT[0] + math.radians(0.005), AT[1]), math.radians(0.01), 100.0)

    assert motion_obstacle(replace(IN_ORDER, reading=rounded), AT, LIMITS) is None


def test_after_a_person_confirmed_it_does_not_matter_where_the_arm_was_left():
    moved = replace(IN_ORDER, left_at_rad=None, reading=JointReading((0.9, 0.9), 1e-4, 100.0))

    assert motion_obstacle(moved, AT, LIMITS) is None


# Of every condition one value that is in order, first, and all kinds that are not.
EVERY = {
    "state": [SessionState.RUNNING, *(state for state in SessionState if state is not SessionState.RUNNING)],
    "stop_requested": [False, True],
    "question": [None, "Is the cell clear?"],
    "obstacle": [None, "The ballbar may still be attached."],
    "robot_connected": [True, False],
    "now_s": [100.5, 102.1, 97.0, math.nan],
    "left_at_rad": [AT, (0.1, -0.21), (0.1, -0.2, 0.0)],
}
TARGETS = [AT, (1.01, 0.0), (math.nan, 0.0)]


def test_of_all_combinations_of_conditions_one_moves_the_arm():
    combinations = list(product(*EVERY.values(), TARGETS))

    let_through = []
    for *values, target in combinations:
        conditions = replace(IN_ORDER, **dict(zip(EVERY, values, strict=True)))
        if motion_obstacle(conditions, target, LIMITS) is None:
            let_through.append((values, target))

    assert len(combinations) == 9 * 2 * 2 * 2 * 2 * 4 * 3 * 3
    assert let_through == [([values[0] for values in EVERY.values()], AT)]


WIDE, NARROW = (JointRange(-2.0, 1.0), JointRange(-1.0, 2.0)), (JointRange(-1.0, 3.0), JointRange(-3.0, 1.0))


@pytest.mark.parametrize(
    ("first", "second", "common"),
    [
        (WIDE, NARROW, LIMITS),
        (NARROW, WIDE, LIMITS),
        (WIDE, None, WIDE),
        (None, WIDE, WIDE),
        (None, None, None),
    ],
)
def test_ranges_have_in_common_what_lies_within_both_and_unknown_ones_bind_nothing(first, second, common):
    assert common_ranges(first, second) == common


def test_ranges_of_robots_with_other_numbers_of_joints_have_nothing_in_common():
    with pytest.raises(PlanRefusedError):
        common_ranges(WIDE, WIDE[:1])


def test_the_cell_limits_a_motion_before_the_robot_and_where_nothing_is_known_nothing_moves():
    one, two, three = ((JointRange(-limit, limit),) * 6 for limit in (1.0, 2.0, 3.0))
    told = replace(IRB_120, joint_limits=two, calibration_ranges=three)

    assert motion_limits(told, one) == one
    assert motion_limits(told, None) == two
    assert motion_limits(replace(told, joint_limits=None), None) == three
    with pytest.raises(PlanRefusedError):
        motion_limits(replace(told, joint_limits=None, calibration_ranges=None), None)
