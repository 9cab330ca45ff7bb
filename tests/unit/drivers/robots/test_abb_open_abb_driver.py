"""The robot's conversation, against a scripted open_abb server that lives in memory."""

import asyncio
import math
from dataclasses import replace

import pytest

from truepose_drivers.abb_open_abb.driver import PLUGIN, OpenAbbRobot, TimeOuts
from truepose_drivers.abb_open_abb.joint_log import JointLog
from truepose_drivers.abb_open_abb.protocol import (
    REPLY_RESOLUTION_DEG,
    LogLine,
    decode_request,
    encode_log_line,
)
from truepose_drivers.api import MotionGuard, MotionLimits, RobotController
from truepose_drivers.errors import (
    ConfigurationError,
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    RemoteProtocolError,
    TargetRefusedError,
)
from truepose_drivers.transports.memory import MemoryEnd, MemoryLink

pytestmark = pytest.mark.simulated_time

QUICK = TimeOuts(connect_s=0.05, retry_s=0.01, reply_s=0.05, motion_s=0.05, rest_of_reply_s=0.01)
# The longest motion of the driver's argument takes 2e4 / 1e6 s = 0.02 s at this speed.
FAST = MotionLimits(tool_speed_mm_s=1e6, orientation_speed_rad_s=1e3)
HANG_UP = None
TARGET = (0.1, -0.2, 0.3, 0.0, math.pi / 4, -1.0)


class FakeController:
    """Replies from a table and records the requests as text."""

    def __init__(self, **replies: object) -> None:
        self.replies: dict[int, object] = {0: "0 1 ", 2: "2 1 ", 6: "6 1 ", 7: "7 1 ", 8: "8 1 ", 9: "9 1 "}
        self.replies |= {4: "4 1 10.00 -20.55 30.00 0.00 45.00 -0.01", 98: "98 1 120-1*6.08*IRB 120"}
        self.replies |= {int(code.removeprefix("code_")): reply for code, reply in replies.items()}
        self.requests: list[str] = []

    async def serve(self, end: MemoryEnd) -> None:
        pending = b""
        while data := await end.receive():
            pending += data
            if b"#" not in pending:
                continue
            self.requests.append(pending.decode())
            reply = self.replies.get(decode_request(pending).code, "")
            pending = b""
            if reply is HANG_UP:
                return
            if reply:
                await self.say(end, str(reply))

    async def say(self, end: MemoryEnd, reply: str) -> None:
        await end.send(reply.encode())


async def connected_robot(fake: FakeController, chunk_bytes: int = 4096) -> OpenAbbRobot:
    robot = OpenAbbRobot(MemoryLink(fake.serve, chunk_bytes=chunk_bytes), FixedClock(), time_outs=QUICK)
    await robot.connect()
    fake.requests.clear()
    return robot


class FixedClock:
    async def now_s(self) -> float:
        return 7.25

    async def sleep(self, duration_s: float) -> None:
        raise AssertionError("a robot driver never sleeps in cell time")


def codes(fake: FakeController) -> list[str]:
    """What was asked, in order; a ping looks for the end of a reply."""
    return [request.split()[0] for request in fake.requests]


PLAIN_TOOL = ["6 0.0 0.0 0.0 1 0 0 0 #", "7 0 0 0 1 0 0 0 #"]
LIMITS = ["6", "7", "8", "9"]
OURS = {"code_98": "98 1 120-1*6.08*IRB 120*truepose 3", "code_95": "95 1 "}


async def test_a_stock_server_is_sent_short_pieces_and_nothing_that_it_does_not_know():
    fake = FakeController()
    robot = await connected_robot(fake)

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


async def test_the_point_at_which_speeds_hold_is_that_of_the_tool():
    fake = FakeController()
    link = MemoryLink(fake.serve)
    robot = OpenAbbRobot(link, FixedClock(), time_outs=QUICK, tool_mm=(150.0, 0.04, 125.0))
    await robot.connect()

    await robot.set_limits(FAST)

    assert "6 150.0 0.0 125.0 1 0 0 0 #" in fake.requests
    assert "7 0 0 0 1 0 0 0 #" in fake.requests


async def test_a_controller_that_states_another_speed_is_not_moved():
    fake = FakeController(**OURS, code_94="94 1 500.00 3.00")
    robot = await connected_robot(fake)
    await robot.identify()

    with pytest.raises(DeviceRefusedError, match="told 50 mm/s and 3 deg/s and states 500 mm/s"):
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


def test_it_is_a_robot_controller_that_cannot_stop():
    robot: RobotController = OpenAbbRobot(MemoryLink(None), FixedClock())

    assert not robot.can_stop_motion
    assert not robot.connected


async def test_a_joint_target_goes_out_in_degrees_with_five_decimals():
    fake = FakeController()
    robot = await connected_robot(fake)
    await robot.set_limits(FAST)

    await robot.move_joints(TARGET)

    assert fake.requests[-1] == "2 +0005.72958 -0011.45916 +0017.18873 +0000.00000 +0045.00000 -0057.29578 #"


async def test_limits_are_sent_in_wire_units_with_a_fine_zone():
    fake = FakeController()
    robot = await connected_robot(fake)

    await robot.set_limits(MotionLimits(tool_speed_mm_s=500.0, orientation_speed_rad_s=math.radians(20.0)))

    assert fake.requests == [*PLAIN_TOOL, "8 500.0 20.00 #", "9 1 0 0 0 #"]


async def test_the_first_motion_of_a_connection_never_runs_with_a_fly_by_zone():
    fake = FakeController()
    robot = await connected_robot(fake)
    await robot.set_limits(FAST)
    await robot.connect()  # the controller may have been restarted meanwhile
    fake.requests.clear()

    await robot.move_joints(TARGET)
    await robot.move_joints(TARGET)

    assert [request.split()[0] for request in fake.requests] == [*LIMITS, "2", "2"]


@pytest.mark.parametrize("chunk_bytes", [1, 5, 4096])
async def test_joints_survive_any_split_of_the_stream(chunk_bytes):
    robot = await connected_robot(FakeController(), chunk_bytes)

    reading = await robot.read_joints()

    assert tuple(map(math.degrees, reading.joints_rad)) == pytest.approx((10, -20.55, 30, 0, 45, -0.01))
    assert math.degrees(reading.resolution_rad) == pytest.approx(REPLY_RESOLUTION_DEG)
    assert reading.time_s == 7.25


@pytest.mark.parametrize("chunk_bytes", [1, 4096])
async def test_whole_degrees_may_come_without_decimals(chunk_bytes):
    robot = await connected_robot(FakeController(code_4="4 1 10 -20.5 30 0 45 90"), chunk_bytes)

    reading = await robot.read_joints()

    assert tuple(map(math.degrees, reading.joints_rad)) == pytest.approx((10, -20.5, 30, 0, 45, 90))


@pytest.mark.parametrize("chunk_bytes", [1, 4096])
async def test_a_server_that_gives_more_decimals_is_read_to_its_own_resolution(chunk_bytes):
    fake = FakeController(code_4="4 1 10.12345 -20.55000 30 0.1 45.00000 90.12345")
    robot = await connected_robot(fake, chunk_bytes)

    reading = await robot.read_joints()

    assert math.degrees(reading.joints_rad[5]) == pytest.approx(90.12345, abs=1e-9)
    assert math.degrees(reading.resolution_rad) == pytest.approx(1e-5)


@pytest.mark.parametrize(
    ("begun", "rest", "last_deg"),
    [
        ("4 1 10.00 -20.55 30.00 0.00 45.00 -0.0", "1", -0.01),
        ("4 1 10.00 -20.55 30.00 0.00 45.00 9", "0.12", 90.12),
        ("4 1 10 20 30 0 45 1", "80.25", 180.25),
        ("4 1 0 0 0 0 0 10.12", "345", 10.12345),
        ("4 1 10.00 -20.55 30.00 0.00 45.00 9", "1.00 ", 91.0),
    ],
)
async def test_a_line_that_stalls_inside_a_number_ends_none(begun, rest, last_deg):
    class Stalling(FakeController):
        async def say(self, end: MemoryEnd, reply: str) -> None:
            if reply.startswith(begun):
                await end.send(begun.encode())
                await asyncio.sleep(0.05)  # longer than the driver waits for the rest of a reply
                reply = rest
            await end.send(reply.encode())

    robot = OpenAbbRobot(MemoryLink(Stalling(code_4=begun + rest).serve), FixedClock())
    await robot.connect()

    assert math.degrees((await robot.read_joints()).joints_rad[5]) == pytest.approx(last_deg)
    await robot.close()


STATED = "10.00 -20.55 30.00 0.00 45.00 -0.01"


@pytest.mark.parametrize(
    "bad",
    [
        "10.00 -20.55 30.00 0.00 45.00 -0.0",  # a digit lost at the end
        "10.00 -20.55 30.00 0.00 45.00 -0",
        "10.00 -20.555 30.00 0.00 45.00 -0.01",  # one came twice
    ],
)
async def test_digits_that_were_lost_or_came_twice_are_found_by_asking_again(bad):
    said = iter([STATED, STATED, bad, STATED])
    fake = FakeController()
    fake.replies[4] = Said(lambda: f"4 1 {next(said)}")
    robot = await connected_robot(fake)

    for _ in range(2):
        reading = await robot.read_joints()
        assert math.degrees(reading.joints_rad[1]) == pytest.approx(-20.55)
        assert math.degrees(reading.joints_rad[5]) == pytest.approx(-0.01)


async def test_joints_of_which_nobody_can_tell_whether_they_are_whole_close_the_link():
    said = iter(["10 20 30 0 45 9", "10 20 30 0 45 90"])
    fake = FakeController()
    fake.replies[4] = Said(lambda: f"4 1 {next(said)}")
    robot = await connected_robot(fake)

    with pytest.raises(RemoteProtocolError, match="lost or came twice"):
        await robot.read_joints()
    assert not robot.connected


class Said:
    """A reply that is another one each time."""

    def __init__(self, text) -> None:
        self._text = text

    def __str__(self) -> str:
        return self._text()


async def test_a_reply_whose_end_cannot_be_told_is_none_where_the_ping_stays_without_reply():
    fake = FakeController(code_4="4 1 10 20 30 0 45 90")
    robot = await connected_robot(fake)
    fake.replies[0] = ""

    with pytest.raises(NoReplyError, match="does not end its reply"):
        await robot.read_joints()
    assert not robot.connected


@pytest.mark.parametrize(
    "reply",
    [
        "4 1 10.00 -20.55 30.00 0.00 45.00 -0.01 7.00",
        "4 1 10.00 -20.55 30.00 0.00 45.00 3600.01",
        "4 1 10.00 -20.55 30.00 0.00 45.00 9E+09",
        "4 1 10.00 -20.55 nan 0.00 45.00 -0.01",
        "4 7 10.00 -20.55 30.00 0.00 45.00 -0.01",
        "4 1 10.00 -20.55 30.00 0.00 45.00 -0.014 1 10.00 -20.55 30.00 0.00 45.00 -0.01",
    ],
)
async def test_joints_that_are_none_close_the_link(reply):
    robot = await connected_robot(FakeController(code_4=reply))

    with pytest.raises(RemoteProtocolError):
        await robot.read_joints()
    assert not robot.connected


async def test_a_reply_that_goes_on_is_none_to_a_motion():
    robot = await connected_robot(FakeController(code_8="8 1 9 1 "))

    with pytest.raises(RemoteProtocolError, match="goes on with"):
        await robot.set_limits(FAST)
    assert not robot.connected


async def test_a_reply_without_its_trailing_space_is_taken():
    robot = await connected_robot(FakeController(code_2="2 1", code_8="8 1", code_9="9 1\r\n"))
    await robot.set_limits(FAST)

    await robot.move_joints(TARGET)


@pytest.mark.parametrize("chunk_bytes", [1, 7, 16, 4096])
async def test_an_identity_is_read_to_its_end_whatever_the_line_does_to_it(chunk_bytes):
    fake = FakeController(code_98="98 1 120-500123*6.08.01*IRB 120-3/0.6")
    robot = await connected_robot(fake, chunk_bytes)

    assert (await robot.identify()).model == "IRB 120-3/0.6"


async def test_the_identity_names_serial_version_and_type():
    robot = await connected_robot(FakeController(code_98="98 1 120-500123*6.08.01*IRB 120-3/0.6"))

    identity = await robot.identify()

    assert (identity.manufacturer, identity.model) == ("ABB", "IRB 120-3/0.6")
    assert (identity.serial, identity.firmware) == ("120-500123", "6.08.01")


async def test_an_identity_that_lacks_fields_says_unknown():
    robot = await connected_robot(FakeController(code_98="98 1 120-500123"))

    identity = await robot.identify()

    assert (identity.serial, identity.firmware, identity.model) == ("120-500123", "unknown", "unknown")


async def test_a_refused_target_is_named_in_degrees():
    robot = await connected_robot(FakeController(code_2="2 0 "))
    await robot.set_limits(FAST)

    with pytest.raises(TargetRefusedError, match=r"5\.730, -11\.459"):
        await robot.move_joints(TARGET)

    assert robot.connected


async def test_silence_sends_the_operator_to_the_pendant_and_closes_the_link():
    robot = await connected_robot(FakeController(code_2=""))
    await robot.set_limits(FAST)

    with pytest.raises(NoReplyError, match="pendant"):
        await robot.move_joints(TARGET)

    assert not robot.connected


async def test_a_dropped_connection_sends_the_operator_to_the_pendant():
    robot = await connected_robot(FakeController(code_2=HANG_UP))
    await robot.set_limits(FAST)

    with pytest.raises(ConnectionLostError, match="pendant"):
        await robot.move_joints(TARGET)

    assert not robot.connected


async def test_it_moves_again_after_connecting_again():
    fake = FakeController(code_2=HANG_UP)
    robot = await connected_robot(fake)
    await robot.set_limits(FAST)
    with pytest.raises(ConnectionLostError):
        await robot.move_joints(TARGET)
    fake.replies[2] = "2 1 "

    await robot.connect()
    await robot.move_joints(TARGET)

    assert robot.connected


@pytest.mark.parametrize(
    "target", [(0.0,) * 5, (0.0,) * 7, (), (float("nan"),) * 6, (float("inf"), 0, 0, 0, 0, 0), (100.0,) * 6]
)
async def test_an_absurd_target_never_reaches_the_robot(target):
    fake = FakeController()
    robot = await connected_robot(fake)

    with pytest.raises(TargetRefusedError):
        await robot.move_joints(target)

    assert fake.requests == []


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
async def test_an_absurd_speed_never_reaches_the_robot(speed):
    fake = FakeController()
    robot = await connected_robot(fake)

    with pytest.raises(ConfigurationError, match="speed"):
        await robot.set_limits(MotionLimits(tool_speed_mm_s=speed))
    with pytest.raises(ConfigurationError, match="speed"):
        await robot.set_limits(MotionLimits(orientation_speed_rad_s=speed))

    assert fake.requests == []


async def test_a_reply_to_another_request_is_a_protocol_error():
    robot = await connected_robot(FakeController(code_4="2 1 "))

    with pytest.raises(RemoteProtocolError, match="replied to request 2"):
        await robot.read_joints()

    assert not robot.connected


@pytest.mark.parametrize("reply", ["SSH-2.0-x\r\n", "4 x", "4 1 " + "9" * 100, "4 1 1 2 3 4 5 six.00"])
async def test_garbage_is_a_protocol_error(reply):
    robot = await connected_robot(FakeController(code_4=reply))

    with pytest.raises(RemoteProtocolError):
        await robot.read_joints()


@pytest.mark.parametrize("reply", ["4", "4 1 10.00 20.00"])
async def test_half_a_reply_is_silence(reply):
    robot = await connected_robot(FakeController(code_4=reply))

    with pytest.raises(NoReplyError):
        await robot.read_joints()


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

    told_s = await silent_motion(logger_at(half_way), target, r"stands still 20\.00 deg.*emergency", **ours)

    assert told_s < 5.5


async def test_an_arm_that_never_sets_off_is_told_within_seconds():
    assert await silent_motion(logger_at(STANDS_DEG), (0.0,) * 6, r"stands still 45\.00 deg") < 7.0


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


async def test_a_motion_that_is_answered_at_once_asks_no_logger():
    fake = FakeController()
    robot = OpenAbbRobot(
        MemoryLink(fake.serve), FixedClock(), time_outs=QUICK, log=JointLog(MemoryLink(None))
    )
    await robot.connect()

    await robot.move_joints(TARGET)

    assert robot.connected
