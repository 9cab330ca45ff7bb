"""What becomes of a motion, from one state to the next."""

from dataclasses import replace

import pytest

from truepose_drivers.errors import (
    ConnectionLostError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.universal_robots.progress import Progress, require_ready
from truepose_drivers.universal_robots.script import OUTPUTS, Order, robot_state

ORDER = Order(number=5, target_rad=(0.5, 0.0, 0.0, 0.0, 0.0, 0.0))
VALUES = {name: (0.0,) * (6 if kind == "VECTOR6D" else 1) for name, kind in OUTPUTS.items()}
RESTING = robot_state(VALUES | {"robot_mode": (7,), "safety_mode": (1,), "runtime_state": (1,)})
MOVING = replace(RESTING, runtime_state=2, begun=5)


def begun() -> Progress:
    progress = Progress(ORDER, RESTING, 0.0)
    assert not progress.arrived(MOVING, 0.1)
    return progress


def at(joint_rad: float):
    return replace(MOVING, joints_rad=(joint_rad, 0.0, 0.0, 0.0, 0.0, 0.0))


def test_a_motion_has_arrived_when_its_program_says_so_and_has_ended():
    progress = begun()

    assert not progress.arrived(replace(MOVING, arrived=5), 1.0)
    assert progress.arrived(replace(RESTING, begun=5, arrived=5), 1.1)


def test_an_earlier_motion_has_not_arrived_for_this_one():
    assert not begun().arrived(replace(MOVING, arrived=4), 1.0)


def test_a_motion_that_never_begins_is_told_with_what_to_do():
    progress = Progress(ORDER, RESTING, 0.0)

    assert not progress.arrived(RESTING, 4.9)
    with pytest.raises(NotInitialisedError, match="remote control"):
        progress.arrived(RESTING, 5.1)


def test_a_program_that_ends_before_the_arm_moved_has_refused_the_target():
    progress = begun()
    ended = replace(RESTING, begun=5)

    assert not progress.arrived(ended, 0.2)  # the registers may be ahead
    with pytest.raises(TargetRefusedError, match=r"28\.648.*pendant.*\"joint limits\""):
        progress.arrived(ended, 0.4, "joint limits")


def test_a_program_that_ends_on_the_way_was_broken_off():
    progress = begun()

    progress.arrived(at(0.2), 0.2)
    with pytest.raises(NotInitialisedError, match="interrupted"):
        progress.arrived(replace(at(0.2), runtime_state=1), 0.5)


def test_a_motion_that_was_given_up_for_silence_is_a_lost_connection():
    with pytest.raises(ConnectionLostError, match=r"nothing for 0\.6 s"):
        begun().arrived(replace(RESTING, begun=5, given_up=5), 0.3)


@pytest.mark.parametrize(("field", "mode"), [("safety_mode", 3), ("safety_mode", 7), ("robot_mode", 5)])
def test_a_stop_on_the_way_is_told(field, mode):
    with pytest.raises(NotInitialisedError, match="stopped during the motion"):
        begun().arrived(replace(MOVING, **{field: mode}), 0.3)


def test_an_arm_that_stands_under_way_is_waited_for_and_then_lost():
    progress = begun()

    assert not progress.arrived(at(0.2), 10.0)
    assert not progress.arrived(at(0.2), 29.0)  # paused on the pendant, say
    assert not progress.arrived(at(0.3), 29.9)
    with pytest.raises(NoReplyError, match="20 s"):
        progress.arrived(at(0.3), 50.0)


def test_an_arm_at_rest_without_program_may_move():
    require_ready(RESTING)


def test_an_arm_that_a_program_moves_is_left_to_it():
    with pytest.raises(NotInitialisedError, match="another program"):
        require_ready(replace(RESTING, runtime_state=4))


def test_an_arm_that_may_not_move_is_not_asked_to():
    with pytest.raises(NotInitialisedError, match="cannot move: it made a protective stop"):
        require_ready(replace(RESTING, safety_mode=3))
