"""The robot's conversation, against a scripted open_abb server that lives in memory."""

import asyncio
import math
from dataclasses import replace

import pytest

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from tests.unit.drivers.robots.abb.open_abb_server import (
    FAST,
    HANG_UP,
    LIMITS,
    OURS,
    PLAIN_TOOL,
    QUICK,
    TARGET,
    FakeController,
    codes,
    connected_robot,
)
from truepose_drivers.abb_open_abb.driver import PLUGIN, OpenAbbRobot, TimeOuts
from truepose_drivers.abb_open_abb.joint_log import JointLog
from truepose_drivers.abb_open_abb.protocol import (
    LogLine,
    encode_log_line,
)
from truepose_drivers.api import MotionGuard, MotionLimits
from truepose_drivers.errors import (
    ConfigurationError,
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    TargetRefusedError,
)

pytestmark = pytest.mark.simulated_time


async def test_a_stock_server_is_sent_short_pieces_and_nothing_that_it_does_not_know(fake, robot):
    await robot.identify()
    await robot.set_limits(FAST)
    await robot.move_joints(TARGET)

    assert robot.motion_guard == MotionGuard(longest_piece_s=1.0)
    assert [code for code in codes(fake) if code != "0"] == ["98", "6", "7", "8", "9", "2"]


async def test_our_own_server_watches_and_states_its_speed():
    fake = FakeController(**OURS, code_94="94 1 50 3.00")
    robot = await connected_robot(fake)

    await robot.identify()
    await robot.set_limits(MotionLimits(50.0, math.radians(3.0)))
    await robot.move_joints(TARGET)
    await robot.move_joints(TARGET)

    assert robot.motion_guard == MotionGuard(stops_unheard_s=1.0, speed_read_back=True)
    assert [code for code in codes(fake) if code != "0"] == ["98", *LIMITS, "94", "95", "2", "2"]
    assert "95 0.80 #" in fake.requests


async def test_connecting_asks_who_is_there_each_time():
    fake = FakeController(**OURS)
    robot = await connected_robot(fake)
    assert robot.motion_guard.stops_unheard_s == 1.0
    fake.replies[98] = "98 1 120-1*6.08*IRB 120"

    await robot.connect()

    assert robot.motion_guard == MotionGuard(longest_piece_s=1.0)


async def test_the_point_at_which_speeds_hold_is_that_of_the_tool(fake):
    link = MemoryLink(fake.serve)
    robot = OpenAbbRobot(link, FixedClock(), time_outs=QUICK, tool_mm=(150.0, 0.04, 125.0))
    assert robot.motion_guard.speed_point_mm == (150.0, 0.04, 125.0)
    await robot.connect()

    await robot.set_limits(FAST)

    assert "6 150.0 0.0 125.0 1 0 0 0 #" in fake.requests
    assert "7 0 0 0 1 0 0 0 #" in fake.requests


async def test_a_controller_that_states_another_speed_is_not_moved():
    fake = FakeController(**OURS, code_94="94 1 500.00 3.00")
    robot = await connected_robot(fake)
    await robot.identify()

    with pytest.raises(DeviceRefusedError, match="set to 50 mm/s and 3 deg/s but reports 500 mm/s"):
        await robot.set_limits(MotionLimits(50.0, math.radians(3.0)))

    assert not robot.connected


async def test_a_server_that_watches_hears_the_driver_while_the_arm_moves():
    fake = FakeController(**OURS, code_94="94 1 1000000 57295.78", code_2="", code_96="")
    robot = OpenAbbRobot(MemoryLink(fake.serve), FixedClock(), time_outs=replace(QUICK, motion_s=5.0))
    await robot.connect()
    await robot.identify()
    await robot.set_limits(FAST)

    moving = asyncio.create_task(robot.move_joints(TARGET))
    while fake.requests.count("96 #") < 3:
        await asyncio.sleep(0.01)
    moving.cancel()

    assert fake.requests[-4].startswith("2 ")
    assert fake.requests[-3:] == ["96 #"] * 3


async def test_a_joint_target_goes_out_in_degrees_with_five_decimals(fake, robot):
    await robot.set_limits(FAST)

    await robot.move_joints(TARGET)

    assert fake.requests[-1] == "2 +0005.72958 -0011.45916 +0017.18873 +0000.00000 +0045.00000 -0057.29578 #"


async def test_limits_are_sent_in_wire_units_with_a_fine_zone(fake, robot):
    await robot.set_limits(MotionLimits(tool_speed_mm_s=500.0, orientation_speed_rad_s=math.radians(20.0)))

    assert fake.requests == [*PLAIN_TOOL, "8 500.0 20.00 #", "9 1 0 0 0 #"]


async def test_the_first_motion_of_a_connection_never_runs_with_a_fly_by_zone(fake, robot):
    await robot.set_limits(FAST)
    await robot.connect()  # the controller may have been restarted meanwhile
    fake.requests.clear()

    await robot.move_joints(TARGET)
    await robot.move_joints(TARGET)

    assert [request.split()[0] for request in fake.requests] == [*LIMITS, "2", "2"]


@pytest.mark.parametrize(
    ("reply", "error", "complaint", "keeps_link"),
    [
        ("2 0 ", TargetRefusedError, r"5\.730, -11\.459", True),
        ("", NoReplyError, "pendant", False),
        (HANG_UP, ConnectionLostError, "pendant", False),
    ],
)
async def test_a_motion_that_is_not_made_is_told(reply, error, complaint, keeps_link):
    robot = await connected_robot(FakeController(code_2=reply))
    await robot.set_limits(FAST)

    with pytest.raises(error, match=complaint):
        await robot.move_joints(TARGET)

    assert robot.connected == keeps_link


async def test_a_bad_message_answer_is_a_refusal():
    robot = await connected_robot(FakeController(code_8="8 0 "))

    with pytest.raises(DeviceRefusedError, match="SET_SPEED"):
        await robot.set_limits(FAST)


async def test_connecting_is_tried_again_while_the_server_is_between_two_clients():
    class SlowServer(MemoryLink):
        refusals = 2

        async def open(self) -> None:
            if self.refusals:
                self.refusals -= 1
                raise ConnectFailedError("refused")
            await super().open()

    robot = OpenAbbRobot(
        SlowServer(FakeController().serve), FixedClock(), time_outs=TimeOuts(connect_s=5.0, retry_s=0.001)
    )

    await robot.connect()

    assert robot.connected


async def test_nobody_at_the_address_is_a_failed_connection_after_the_retries():
    robot = OpenAbbRobot(MemoryLink(None), FixedClock(), time_outs=QUICK)

    with pytest.raises(ConnectFailedError, match="server program"):
        await robot.connect()


async def test_closing_lets_the_server_listen_again():
    fake = FakeController(code_99=HANG_UP)
    robot = await connected_robot(fake)

    await robot.close()
    await robot.close()

    assert not robot.connected


async def test_an_abandoned_motion_closes_the_link():
    fake = FakeController(code_2="")
    robot = OpenAbbRobot(MemoryLink(fake.serve), FixedClock())
    await robot.connect()
    task = asyncio.create_task(robot.move_joints(TARGET))
    while not fake.requests or not fake.requests[-1].startswith("2 "):
        await asyncio.sleep(0)

    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task

    assert not robot.connected


@pytest.mark.parametrize("tool", ["", "1 2", "1 2 3 4", "a b c", "0 0 nan", 125, True])
async def test_a_tool_that_is_no_point_is_refused_with_an_example(tool):
    with pytest.raises(ConfigurationError, match=r'tool_mm .* give three numbers, as in "0 0 125"'):
        PLUGIN.open({"host": "10.0.0.1", "tool_mm": tool}, None)

    assert PLUGIN.open({"host": "10.0.0.1", "tool_mm": "150 0 125.5"}, None)


STANDS_DEG = (10.0, -20.55, 30.0, 0.0, 45.0, -0.01)  # FakeController


def logger_at(joints_deg, most=10**6):
    """A logger that tells poses and these joints in turn, and hangs after `most` records."""

    async def serve(end: MemoryEnd) -> None:
        for count in range(most):
            values = joints_deg if count % 2 else (300.0, 0.0, 500.0, 1.0, 0.0, 0.0, 0.0)
            record = LogLine(count % 2, "2020-01-01", "12:00:00", 0.1 * count, tuple(values))
            await end.send(encode_log_line(record))
            await asyncio.sleep(0.1)
        await end.receive()

    return serve


async def silent_motion(serve, target_deg, sentence, **replies):
    """Have a motion go unanswered; returns after how long it was told, with `sentence`."""
    fake = FakeController(code_2="", **replies)
    patient = replace(QUICK, motion_s=10.0)
    log = JointLog(MemoryLink(serve, chunk_bytes=70))
    robot = OpenAbbRobot(MemoryLink(fake.serve), FixedClock(), log=log, time_outs=patient)
    await robot.connect()
    await robot.set_limits(FAST)
    begun_s = asyncio.get_running_loop().time()
    with pytest.raises(NoReplyError, match=sentence):
        await robot.move_joints(tuple(map(math.radians, target_deg)))
    assert not robot.connected
    return asyncio.get_running_loop().time() - begun_s


@pytest.mark.parametrize("ours", [{}, OURS | {"code_94": "94 1 1000000 57295.78"}])
async def test_an_arm_that_the_logger_shows_standing_is_told_within_seconds(ours):
    half_way = (10.0, -20.55, 30.0, 0.0, 45.0, 20.0)
    target = (*STANDS_DEG[:5], 40.0)

    told_s = await silent_motion(logger_at(half_way), target, r"stopped 20\.00 deg.*emergency", **ours)

    assert told_s < 5.5


async def test_an_arm_that_never_sets_off_is_told_within_seconds():
    assert await silent_motion(logger_at(STANDS_DEG), (0.0,) * 6, r"stopped 45\.00 deg") < 7.0


@pytest.mark.parametrize(
    "serve",
    [
        None,
        logger_at((0.0,) * 6),  # arrived
        logger_at((100.0,) * 6),  # of another time
        logger_at(STANDS_DEG, most=1),
        logger_at((float("nan"),) * 6),
    ],
)
async def test_a_logger_that_shows_no_standstill_leaves_the_motion_its_time(serve):
    assert await silent_motion(serve, (0.0,) * 6, "did not report the end") > 10.0


async def test_a_motion_that_is_answered_at_once_asks_no_logger(fake):
    robot = OpenAbbRobot(
        MemoryLink(fake.serve), FixedClock(), time_outs=QUICK, log=JointLog(MemoryLink(None))
    )
    await robot.connect()

    await robot.move_joints(TARGET)

    assert robot.connected
