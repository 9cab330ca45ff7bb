"""A motion that cannot be stopped goes out in pieces: the same way, the same side, and a halt after each."""

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.domain import asking
from tests.unit.service.sessions.stand_ins import nothing_in_the_way
from tests.unit.service.sessions.tracker.fakes import IRB120, FakeClock, FakeRobot, make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, begun, until
from truepose.domain.robot import FramePlacement, JointRange
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.engine.arm import Arm, MotionSegments, Permission
from truepose.sessions.engine.interlocks import motion_notice
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose.sessions.engine.ways import KnownWays
from truepose.sessions.errors import MotionForbiddenError
from truepose_drivers.api import MotionGuard, MotionLimits

SLOW = MotionLimits(20.0, math.radians(3.0))
START = (0.0, 0.1, -0.2, 0.0, 0.3, 0.0)
TARGET = (0.8, 0.5, -0.4, 1.0, 0.3, -1.5)
WIDE = (JointRange(-7.0, 7.0),) * 6


def duration_s(start, target, speed=SLOW):
    """How long the flange takes along the straight motion of the joints, looked at closely."""
    joints = np.linspace(start, target, 400)
    chain = nominal_chain(IRB120, FramePlacement(), joints)
    path = np.linalg.norm(np.diff(chain.origin[-1], axis=0), axis=1).sum()
    turns = np.swapaxes(chain.rotation[-1][:-1], 1, 2) @ chain.rotation[-1][1:]
    angles = np.arccos(np.clip((np.trace(turns, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
    return max(path / speed.tool_speed_mm_s, angles.sum() / speed.orientation_speed_rad_s)


def test_no_piece_takes_longer_than_a_second_and_all_lie_on_one_line():
    ends = tuple(MotionSegments(IRB120, SLOW).of(START, TARGET, 1.0))
    starts = (START, *ends[:-1])

    assert ends[-1] == TARGET
    # the speed of the flange changes a little between two of the looks along the way
    assert max(duration_s(a, b) for a, b in zip(starts, ends, strict=True)) <= 1.05
    assert len(ends) <= 2 * duration_s(START, TARGET)
    steps = np.diff([START, *ends], axis=0)
    assert steps == pytest.approx(np.broadcast_to(steps[0], steps.shape), abs=1e-12)


def test_a_short_motion_stays_whole():
    near = tuple(q + 0.01 for q in START)

    assert list(MotionSegments(IRB120, MotionLimits()).of(START, near, 1.0)) == [near]
    assert list(MotionSegments(IRB120, MotionLimits()).of(START, START, 1.0)) == [START]


def test_a_motion_of_many_minutes_too_has_no_piece_of_more_than_a_second():
    creeping = MotionLimits(1.0, math.radians(0.1))

    ends = tuple(MotionSegments(IRB120, creeping).of(START, TARGET, 1.0))

    assert len(ends) > 500
    longest_s = max(duration_s(a, b, creeping) for a, b in pairwise((START, *ends[:100])))
    assert longest_s <= 1.05
    assert ends[-1] == TARGET


class GuardedRobot(FakeRobot):
    """A robot whose driver asks for pieces."""

    motion_guard = MotionGuard(longest_piece_s=1.0)


async def make_arm(robot, clock, permission=None, **changes):
    allowed = Permission(SessionState.RUNNING, stop_requested=False, question=None)
    ask = permission or (lambda now_s: allowed)
    settings = {"wall_s": lambda: clock.time_s, **changes}
    arm = Arm(robot, clock, IRB120, WIDE, 0.00035, ask, KnownWays(nothing_in_the_way), **settings)
    await arm.set_limits(SLOW)
    return arm


async def connected(kind=GuardedRobot):
    clock = FakeClock()
    robot = kind(clock)
    robot.joints = START
    await robot.connect()
    return robot, clock


async def test_the_arm_comes_to_its_stop_from_the_same_side_in_pieces():
    whole, clock = await connected(FakeRobot)
    pieces, clock_of_pieces = await connected()
    arms = await make_arm(whole, clock), await make_arm(pieces, clock_of_pieces)

    for arm in arms:
        await arm.move(TARGET)

    assert whole.moves == [TARGET]
    assert len(pieces.moves) > 10
    assert pieces.moves[-1] == TARGET
    assert arms[0].direction == arms[1].direction


class SlowedRobot(FakeRobot):
    """A robot whose speed override somebody turns down on its way."""

    turns_down_after, low = 3, 0.2

    @property
    def motion_guard(self):
        share = 1.0 if len(self.moves) < self.turns_down_after else self.low
        return MotionGuard(longest_piece_s=1.0, speed_share=share)


async def test_each_piece_is_cut_for_the_override_that_holds_then():
    robot, clock = await connected(SlowedRobot)
    arm = await make_arm(robot, clock)

    await arm.move(TARGET)

    times_s = [duration_s(a, b) for a, b in pairwise((START, *robot.moves))]
    assert robot.moves[-1] == TARGET
    assert min(times_s[: robot.turns_down_after]) > 0.3
    # the speed of the flange changes a little between two of the looks along the way
    assert max(times_s[: robot.turns_down_after]) <= 1.05
    assert max(times_s[robot.turns_down_after :]) <= 1.05 * robot.low
    ways = np.diff((START, *robot.moves), axis=0)
    assert ways / np.linalg.norm(ways, axis=1, keepdims=True) == pytest.approx(
        np.broadcast_to(ways[0] / np.linalg.norm(ways[0]), ways.shape), abs=1e-9
    )


async def test_a_halt_takes_effect_after_the_piece_under_way():
    robot, clock = await connected()
    asked = []

    def permission(now_s):
        asked.append(len(robot.moves))
        return Permission(SessionState.RUNNING, stop_requested=len(robot.moves) >= 3, question=None)

    arm = await make_arm(robot, clock, permission)
    with pytest.raises(MotionForbiddenError, match="A pause or the end"):
        await arm.move(TARGET)

    assert len(robot.moves) == 3
    assert asked == [0, 1, 2, 3]  # everything is looked at before each piece


async def test_what_the_permission_rests_on_is_read_anew_before_each_further_piece():
    robot, clock = await connected()
    looked_s, judged_s = [], []

    async def look():
        looked_s.append(clock.time_s)

    def permission(now_s):
        judged_s.append(now_s)
        return Permission(SessionState.RUNNING, stop_requested=False, question=None)

    arm = await make_arm(robot, clock, permission, before_piece=look)
    await arm.move(TARGET)

    assert len(looked_s) == len(robot.moves) - 1 > 10
    assert looked_s == judged_s[1:]  # nothing has moved in between


async def test_where_motions_take_no_wall_time_they_go_out_whole_from_the_second_on():
    robot, clock = await connected()
    arm = await make_arm(robot, clock, wall_s=lambda: 0.0)

    await arm.move(TARGET)
    of_the_first = len(robot.moves)
    await arm.move(START)

    assert of_the_first > 10
    assert robot.moves[of_the_first:] == [START]


async def test_an_arm_outside_its_limits_may_be_brought_inside():
    robot, clock = await connected()
    robot.joints = (7.2, *START[1:])

    await (await make_arm(robot, clock)).move(TARGET)

    assert robot.moves[-1] == TARGET


@pytest.mark.parametrize("stated", [(math.nan, *START[1:]), START[:-1]], ids=["no number", "a joint less"])
async def test_an_arm_that_does_not_say_where_all_its_joints_are_is_not_at_rest(stated):
    robot, clock = await connected()
    arm = await make_arm(robot, clock)
    looks = iter((START, stated))
    read = robot.read_joints

    async def read_otherwise():
        robot.joints = next(looks, START)
        return await read()

    robot.read_joints = read_otherwise

    with pytest.raises(MotionForbiddenError, match="still moving"):
        await arm.move(TARGET)

    assert robot.moves == []


async def test_a_paused_session_says_when_the_arm_rests_and_goes_on_later(cell):
    cell.robot.motion_guard = MotionGuard(longest_piece_s=1.0)
    runner, running = await begun(cell, make_plan(1, tool_speed_mm_s=20.0))
    said = []

    async def pause():
        if len(cell.robot.moves) == 3:
            said.append(await asking.pause(runner, "Eva"))

    cell.robot.before_move = pause
    await asking.confirm(runner, "Eva")
    await until(lambda: runner.state is SessionState.PAUSED)
    paused_after = len(cell.robot.moves)

    assert await PatientOperator().attend(runner, running) is SessionState.FINISHED
    assert paused_after == 4
    assert "within about 1 s" in english(said[0])


def test_what_a_controller_does_when_it_is_left_alone_is_said():
    assert "keeps moving to its target" in english(motion_notice(MotionGuard()))
    assert "for up to 1 s, longer at less than 100 %" in english(
        motion_notice(MotionGuard(longest_piece_s=1.0))
    )
    told = MotionGuard(longest_piece_s=1.0, speed_share=0.3)
    assert "for up to 1 s, longer if the override" in english(motion_notice(told))
    assert "stops the arm by itself within 1 s" in english(motion_notice(MotionGuard(stops_unheard_s=1.0)))
