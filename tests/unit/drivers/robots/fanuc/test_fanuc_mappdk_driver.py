"""The robot's conversation, against a scripted MAPPDK server that lives in memory."""

import asyncio
import math
from dataclasses import replace

import pytest

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.api import MotionGuard, MotionLimits
from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    RemoteProtocolError,
    TargetRefusedError,
)
from truepose_drivers.fanuc_mappdk.driver import MappdkRobot, TimeOuts
from truepose_drivers.fanuc_mappdk.protocol import (
    Command,
    RequestReader,
    decode_motion,
    decode_request,
    decode_timed_motion,
    encode_joints,
    encode_reply,
)

pytestmark = pytest.mark.simulated_time

QUICK = TimeOuts(connect_s=0.0, retry_s=0.01, greeting_s=0.5, reply_s=0.5, motion_s=0.5, rest_of_reply_s=0.05)
TARGET = tuple(map(math.radians, (10.0, 20.0, -50.0, 1.0, 2.0, 3.0)))
SHOWN_DEG = (10.0, 20.0, 30.0, -1.0, -2.0, -3.0)  # joint 3: 50 from the upper arm, of which 20 are joint 2's
FINE_LIMITS = MotionLimits(500.0, math.radians(20.0))
HANG_UP = None


class FakeController:
    """Stands at joints that it shows, answers from a table what is in it, and records the lines."""

    def __init__(self, greeting=b"0:success", **replies):
        self.greeting = greeting
        self.replies = {"identity": "1:wrong-command"} | replies
        self.requests = []
        self.shown_deg = (0.0,) * 6

    async def serve(self, end: MemoryEnd) -> None:
        await end.send(self.greeting)
        lines = RequestReader()
        while data := await end.receive():
            lines.receive_data(data)
            while (line := lines.next_message()) is not None:
                self.requests.append(line)
                reply = self._reply(decode_request(line))
                if reply is HANG_UP:
                    return
                await end.send(reply if isinstance(reply, bytes) else reply.encode())

    def _reply(self, request):
        if request.name in self.replies:
            return self.replies[request.name]
        match request.name:
            case Command.MOVE_TO_JOINTS:
                self.shown_deg = decode_motion(request).values
            case Command.MOVE_IN_TIME:
                self.shown_deg = decode_timed_motion(request).values
            case Command.JOINTS:
                return encode_reply(encode_joints(self.shown_deg))
            case Command.BEAT:
                return b""
        return "0:success"


async def connected(fake, chunk_bytes=4096, **changes):
    link = MemoryLink(fake.serve, chunk_bytes=chunk_bytes)
    robot = MappdkRobot(link, FixedClock(), time_outs=QUICK, **changes)
    await robot.connect()
    return robot


def ours(**replies):
    return FakeController(identity="0:truepose 1,LR Mate 200iC,F123,V7.70P;", **replies)


@pytest.fixture
def fake():
    return FakeController()


@pytest.fixture
async def robot(fake):
    return await connected(fake)


async def test_a_stock_server_tells_nothing_of_its_identity(robot):
    stock = await robot.identify()

    assert (stock.model, stock.serial, stock.firmware) == ("unknown", "unknown", "MAPPDK")


@pytest.mark.parametrize("chunk_bytes", [1, 5, 4096])
async def test_a_target_goes_out_as_the_controller_counts_and_comes_back_as_the_robot_file_does(
    fake, chunk_bytes
):
    robot = await connected(fake, chunk_bytes)

    await robot.move_joints(TARGET)
    reading = await robot.read_joints()

    assert fake.shown_deg == pytest.approx(SHOWN_DEG)
    assert reading.joints_rad == pytest.approx(TARGET, abs=1e-5)
    assert math.degrees(reading.resolution_rad) == pytest.approx(0.001)
    assert reading.time_s == 12.5


async def test_every_motion_is_sent_to_rest_at_a_share_of_the_joint_speeds(fake, robot):
    await robot.set_limits(FINE_LIMITS)

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    (line,) = [line for line in fake.requests if line.startswith("movej")]
    assert line.startswith("movej:0005:0100:000:0:6:+000090.000000:")


async def test_a_stock_server_is_sent_short_pieces_and_only_one_word_that_it_does_not_know(fake, robot):
    await robot.move_joints(TARGET)
    await robot.move_joints(TARGET)

    assert robot.motion_guard == MotionGuard(longest_piece_s=1.0)
    names = [line.split(":")[0] for line in fake.requests]
    assert names == ["identity"] + ["curjpos", "movej", "curjpos"] * 2


async def test_our_own_server_is_told_to_watch_once_and_given_times():
    fake = ours()
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(50.0, math.radians(3.0)))

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))
    await robot.move_joints(TARGET)

    assert robot.motion_guard == MotionGuard(stops_unheard_s=1.0)
    names = [line.split(":")[0] for line in fake.requests]
    assert names == ["identity", "watch", *["curjpos", "movet", "curjpos"] * 2]
    assert "watch:0800" in fake.requests
    # 90 deg of a point up to 1000 mm away at 50 mm/s
    assert fake.requests[3].startswith("movet:00315:6:+000090.000000")


async def test_a_server_that_does_not_watch_as_told_is_not_moved():
    fake = ours(watch="1:wrong-watch-value")
    robot = await connected(fake)

    with pytest.raises(DeviceRefusedError, match="does not monitor"):
        await robot.move_joints(TARGET)
    assert fake.shown_deg == (0.0,) * 6


async def test_a_limit_below_the_slowest_share_is_refused_by_what_would_keep_it(fake, robot):
    await robot.set_limits(MotionLimits(20.0, math.radians(3.0)))

    with pytest.raises(DeviceRefusedError, match=r"below 1 %.*own"):
        await robot.move_joints(TARGET)

    assert robot.connected
    assert fake.shown_deg == (0.0,) * 6


async def test_our_own_server_hears_the_driver_while_the_arm_moves():
    fake = ours(movet=b"")
    robot = await connected(fake)

    moving = asyncio.create_task(robot.move_joints(TARGET))
    while fake.requests.count("beat") < 3:
        await asyncio.sleep(0.01)
    moving.cancel()

    assert fake.requests[-4].startswith("movet:")


@pytest.mark.parametrize(
    ("reply", "error", "complaint", "keeps_link"),
    [
        (b"", NoReplyError, "pendant", False),
        (HANG_UP, ConnectionLostError, r"closed the connection during a motion.*fault.*pendant", False),
        (
            "1:position-is-not-reachable",
            TargetRefusedError,
            r"10\.000, 20\.000, 30\.000.*position-is-not-reachable",
            True,
        ),
        ("1:something-new", TargetRefusedError, "something-new", False),  # more words may follow
        ("0:success", RemoteProtocolError, r"30\.000 deg off", False),  # it stands where it stood
    ],
)
async def test_a_motion_that_does_not_end_at_its_target_is_told(reply, error, complaint, keeps_link):
    fake = FakeController(movej=reply)
    robot = await connected(fake, chunk_bytes=4)

    with pytest.raises(error, match=complaint):
        await robot.move_joints(TARGET)
    assert robot.connected == keeps_link
    assert "beat" not in fake.requests  # which a stock server does not know


async def test_a_motion_may_take_as_long_as_a_low_override_makes_it():
    loop = asyncio.get_running_loop()
    fake = FakeController(movej=b"")
    robot = await connected(fake)
    begun_s = loop.time()

    with pytest.raises(NoReplyError):
        await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert loop.time() - begun_s > 20.0 * 90.0 / 20.0


GOOD = "0:j=   1.000,j=   2.000,j=   3.000,j=   4.000,j=   5.000,j=   6.000,j=none,j=none,j=none"


async def test_joints_that_are_not_told_are_no_reading():
    robot = await connected(FakeController(curjpos="1:cannot-convert-joint-vals"))

    with pytest.raises(DeviceRefusedError, match="cannot-convert"):
        await robot.read_joints()
    assert robot.connected


async def test_a_line_end_behind_a_reply_is_nothing():
    robot = await connected(FakeController(curjpos=GOOD + "\r\n"))

    for _ in range(2):
        assert math.degrees((await robot.read_joints()).joints_rad[0]) == pytest.approx(1.0)


async def test_who_lets_in_and_does_not_greet_is_busy_with_another():
    with pytest.raises(ConnectFailedError, match=r"sends no greeting.*another client.*pendant"):
        await connected(FakeController(greeting=b""))


@pytest.mark.parametrize("greeting", [b"SSH-2.0-OpenSSH\r\n", b"1:wrong-command", b"0:successsuccess"])
async def test_another_greeting_is_no_robot(greeting):
    robot = MappdkRobot(MemoryLink(FakeController(greeting=greeting).serve), FixedClock(), time_outs=QUICK)

    with pytest.raises(RemoteProtocolError):
        await robot.connect()
    assert not robot.connected


async def test_nobody_at_the_address_is_said_after_the_retries():
    robot = MappdkRobot(MemoryLink(None), FixedClock(), time_outs=replace(QUICK, connect_s=0.05))

    with pytest.raises(ConnectFailedError, match="server program runs"):
        await robot.connect()


async def test_it_moves_again_after_connecting_again():
    fake = ours(movet=HANG_UP)
    robot = await connected(fake)
    with pytest.raises(ConnectionLostError, match=r"0\.8 s"):
        await robot.move_joints(TARGET)
    del fake.replies["movet"]

    await robot.connect()
    await robot.move_joints(TARGET)

    assert fake.shown_deg == pytest.approx(SHOWN_DEG)
    assert fake.requests.count("watch:0800") == 2


async def test_joints_are_read_at_the_logger_while_the_arm_moves():
    moving, logging = FakeController(movej=b""), FakeController()
    logging.shown_deg = (5.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    robot = await connected(moving, logger=MemoryLink(logging.serve))
    assert logging.requests == []
    motion = asyncio.create_task(robot.move_joints(TARGET))
    while not moving.requests or not moving.requests[-1].startswith("movej"):
        await asyncio.sleep(0.01)

    reading = await robot.read_joints()

    assert math.degrees(reading.joints_rad[0]) == pytest.approx(5.0)
    assert logging.requests == ["curjpos"]
    motion.cancel()
    await robot.close()


async def test_without_a_logger_joints_are_told_after_the_motion(fake):
    robot = await connected(fake, logger=MemoryLink(None))

    motion = asyncio.create_task(robot.move_joints(TARGET))
    await asyncio.sleep(0)
    reading = await robot.read_joints()
    await motion

    assert reading.joints_rad


async def test_an_abandoned_motion_closes_the_link():
    fake = FakeController(movej=b"")
    robot = await connected(fake)
    task = asyncio.create_task(robot.move_joints(TARGET))
    while not fake.requests or not fake.requests[-1].startswith("movej"):
        await asyncio.sleep(0)

    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task

    assert not robot.connected


async def told_after_s(robot, sentence):
    loop = asyncio.get_running_loop()
    begun_s = loop.time()
    with pytest.raises(NoReplyError, match=sentence):
        await robot.move_joints(TARGET)
    return loop.time() - begun_s


@pytest.mark.parametrize("server", [ours(movet=b""), FakeController(movej=b"")])
async def test_an_arm_that_the_logger_shows_standing_is_told_within_seconds(server):
    logging = FakeController()
    logging.shown_deg = tuple(0.5 * angle for angle in SHOWN_DEG)
    robot = MappdkRobot(MemoryLink(server.serve), FixedClock(), logger=MemoryLink(logging.serve))
    await robot.connect()

    assert await told_after_s(robot, r"stopped 15\.00 deg before its target.*pendant") < 5.0
    assert not robot.connected


@pytest.mark.parametrize(
    ("shown_deg", "replies"),
    [
        (SHOWN_DEG, {}),  # arrived
        ((5.0, 0.0, 0.0, 80.0, 0.0, 0.0), {}),  # of another time
        ((0.0,) * 6, {"curjpos": b""}),
        ((0.0,) * 6, {"curjpos": "1:cannot-convert-joint-vals"}),
        ((0.0,) * 6, {"curjpos": "SSH-2.0-x\r\n"}),
    ],
)
async def test_a_logger_that_shows_no_standstill_leaves_the_motion_its_time(shown_deg, replies):
    logging = FakeController(**replies)
    logging.shown_deg = shown_deg
    fake = FakeController(movej=b"")
    robot = MappdkRobot(MemoryLink(fake.serve), FixedClock(), logger=MemoryLink(logging.serve))
    await robot.connect()

    assert await told_after_s(robot, "did not report the end") > 20.0


async def test_without_a_logger_a_silent_motion_keeps_its_time():
    fake = FakeController(movej=b"")
    robot = MappdkRobot(MemoryLink(fake.serve), FixedClock(), logger=MemoryLink(None))
    await robot.connect()

    assert await told_after_s(robot, "did not report the end") > 20.0
