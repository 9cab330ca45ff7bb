"""An arm that stands still before its target is told in seconds, and one that moves never."""

import asyncio

import pytest

from truepose_drivers.arm_motion import CommandedMotion, Standstill, answered_unless_it_stands
from truepose_drivers.errors import NoReplyError

pytestmark = pytest.mark.simulated_time

COURSE = CommandedMotion((0.0, 10.0), (90.0, 10.0), arrived_deg=0.02, still_deg=0.002)
MOTION_S = 200.0


def told_after_s(joint_at, until_s=MOTION_S, course=COURSE):
    """Return when the standstill of a joint is told, None where it is not."""
    standstill = Standstill(course, 0.0)
    for step in range(1, int(2 * until_s)):
        if standstill.lasts((joint_at(0.5 * step), 10.0), 0.5 * step):
            return 0.5 * step
    return None


def test_an_arm_that_stops_on_its_way_is_told_three_seconds_later():
    assert told_after_s(lambda now_s: 10.0 * min(now_s, 4.0)) == 7.0


def test_an_arm_that_never_sets_off_is_told_five_seconds_after_the_order():
    assert told_after_s(lambda now_s: 0.0) == 5.0


def test_an_arm_that_sets_off_late_and_is_stopped_is_told():
    assert told_after_s(lambda now_s: max(0.0, min(now_s, 6.0) - 4.0)) == 9.0


@pytest.mark.parametrize("speed_deg_s", [0.001, 0.03, 0.45])
def test_an_arm_that_creeps_is_not_told(speed_deg_s):
    assert told_after_s(lambda now_s: speed_deg_s * now_s) is None


def test_an_arm_that_brakes_for_long_before_its_target_is_not_told():
    assert told_after_s(lambda now_s: 90.0 - 0.0005 * max(0.0, 60.0 - now_s) ** 2) is None


def test_an_arm_at_its_target_is_not_told():
    assert told_after_s(lambda now_s: min(90.0, 20.0 * now_s)) is None


def test_the_noise_of_a_held_joint_is_no_motion():
    assert told_after_s(lambda now_s: 45.0 + 0.001 * (int(2 * now_s) % 2)) == 3.5


@pytest.mark.parametrize("elsewhere_deg", [-2.0, 92.0])
def test_joints_beside_the_way_tell_nothing(elsewhere_deg):
    assert told_after_s(lambda now_s: elsewhere_deg) is None


def after(duration_s, answer="done"):
    async def motion():
        await asyncio.sleep(duration_s)
        return answer

    return motion()


async def test_the_motion_of_an_arm_that_stands_is_given_up():
    given_up = asyncio.Event()

    async def motion():
        try:
            await asyncio.sleep(MOTION_S)
        except asyncio.CancelledError:
            given_up.set()
            raise

    async def look():
        return (30.0, 10.0)

    begun_s = asyncio.get_running_loop().time()
    with pytest.raises(NoReplyError, match=r"stopped 60\.00 deg before its target: look there"):
        await answered_unless_it_stands(motion(), look, COURSE, "look there")

    assert given_up.is_set()
    assert asyncio.get_running_loop().time() - begun_s == pytest.approx(3.5, abs=0.1)


async def test_an_answer_does_not_wait_for_a_look_that_hangs():
    async def look():
        await asyncio.sleep(MOTION_S)

    begun_s = asyncio.get_running_loop().time()

    assert await answered_unless_it_stands(after(0.6), look, COURSE, "") == "done"
    assert asyncio.get_running_loop().time() - begun_s == pytest.approx(0.6, abs=0.1)


async def test_where_nobody_tells_the_joints_the_answer_is_awaited():
    async def look():
        return None

    assert await answered_unless_it_stands(after(MOTION_S), look, COURSE, "") == "done"


async def test_what_a_motion_raises_is_raised():
    async def motion():
        raise NoReplyError("it says nothing")

    async def look():
        return (30.0, 10.0)

    with pytest.raises(NoReplyError, match="says nothing"):
        await answered_unless_it_stands(motion(), look, COURSE, "")
