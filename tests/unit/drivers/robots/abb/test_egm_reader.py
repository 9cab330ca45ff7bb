"""The stream of a controller, in memory: only what is newer than what was read before is a reading."""

import asyncio
import math
from dataclasses import replace

import pytest

from truepose_drivers.abb_egm.protocol import Motors, Rapid, RobotFrame, encode_robot
from truepose_drivers.abb_egm.reader import EgmReader
from truepose_drivers.api import MotionGuard, MotionLimits, RobotController
from truepose_drivers.arm_motion import AccompaniedRobot
from truepose_drivers.contract.wire import LoopClock
from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    NoReplyError,
    NotInitialisedError,
    RemoteProtocolError,
)

pytestmark = pytest.mark.simulated_time

FIRST = RobotFrame(100, 5000, (0.0, 10.0, 20.0, 30.0, 40.0, 50.0), (), Motors.ON, Rapid.RUNNING)


class Stream:
    """A source that says a frame every 4 ms; `spoil` makes others of them."""

    address = "UDP port 6510 from memory"

    def __init__(self) -> None:
        self.frame = FIRST
        self.is_open = False
        self.sent = 0
        self.spoil = lambda frame: [encode_robot(frame)]
        self._waiting: asyncio.Queue[bytes] = asyncio.Queue()

    async def open(self) -> None:
        self.is_open = True
        self._speaking = asyncio.create_task(self._speak())

    async def close(self) -> None:
        if self.is_open:
            self._speaking.cancel()
        self.is_open = False

    async def receive(self, timeout_s):
        if not self.is_open:
            raise ConnectionLostError("nobody listens: connect first")
        if timeout_s <= 0.0 and self._waiting.empty():
            return None
        try:
            async with asyncio.timeout(timeout_s):
                return await self._waiting.get()
        except TimeoutError:
            return None

    async def _speak(self):
        while True:
            await asyncio.sleep(0.004)
            self.frame = replace(self.frame, sequence=self.frame.sequence + 1, time_ms=self.frame.time_ms + 4)
            for data in self.spoil(self.frame):
                self._waiting.put_nowait(data)

    def move_to(self, *joints_deg):
        self.frame = replace(self.frame, joints_deg=joints_deg)


async def reading(stream):
    reader = EgmReader(stream, LoopClock())
    await reader.connect()
    return reader


@pytest.fixture
def stream():
    return Stream()


@pytest.fixture
async def reader(stream):
    reader = await reading(stream)
    yield reader
    await reader.close()


async def test_joints_are_those_that_arrive_after_the_question(stream, reader):
    await asyncio.sleep(10.0)  # thousands of frames wait meanwhile
    stream.move_to(1.0, 2.0, 3.0, 4.0, 5.0, 6.0000001)

    joints = await reader.read_joints()

    assert joints.joints_rad == tuple(map(math.radians, (1.0, 2.0, 3.0, 4.0, 5.0, 6.0000001)))
    assert joints.resolution_rad == 1e-6
    assert joints.time_s == pytest.approx(10.0, abs=0.1)


async def test_frames_that_come_twice_or_late_are_passed_over(stream, reader):
    old = replace(stream.frame, joints_deg=(9.0,) * 6)
    stream.spoil = lambda frame: [encode_robot(old), encode_robot(old), encode_robot(frame)]

    for _ in range(5):
        assert (await reader.read_joints()).joints_rad == tuple(map(math.radians, FIRST.joints_deg))


@pytest.mark.parametrize(
    "spoil",
    [
        lambda frame: [],
        lambda frame: [encode_robot(replace(frame, sequence=7))],
        lambda frame: [encode_robot(replace(frame, time_ms=5004))],
        lambda frame: [encode_robot(replace(frame, sequence=FIRST.sequence + 1, time_ms=5004))],
    ],
)
async def test_a_stream_that_ends_or_does_not_move_on_is_a_lost_link(stream, reader, spoil):
    await reader.read_joints()
    stream.spoil = spoil
    began_s = asyncio.get_running_loop().time()

    with pytest.raises(NoReplyError, match="no new data arrives at UDP port 6510"):
        await reader.read_joints()

    assert asyncio.get_running_loop().time() - began_s == pytest.approx(0.5, abs=0.05)
    assert not reader.connected
    with pytest.raises(ConnectionLostError, match="connect first"):
        await reader.read_joints()


async def test_a_controller_that_began_anew_is_read_after_connecting_again(stream, reader):
    stream.frame = replace(FIRST, sequence=0, time_ms=4)

    with pytest.raises(NoReplyError):
        await reader.read_joints()
    await reader.connect()

    assert (await reader.read_joints()).joints_rad


async def test_nonsense_closes_the_port(stream, reader):
    stream.spoil = lambda frame: [b"\xff\xff nonsense"]

    with pytest.raises(RemoteProtocolError):
        await reader.read_joints()
    assert not reader.connected


async def test_a_port_at_which_nothing_arrives_is_no_connection(stream):
    stream.spoil = lambda frame: []

    with pytest.raises(ConnectFailedError, match=r"TruePoseEgm\.mod"):
        await reading(stream)
    assert not stream.is_open


class FakeRobot:
    """Moves at once, and says how it is guarded."""

    def __init__(self) -> None:
        self.connected = False
        self.can_stop_motion = True
        self.motion_guard = MotionGuard(stops_unheard_s=1.0)
        self.moved: list[object] = []

    async def connect(self) -> None:
        self.connected = True

    async def close(self) -> None:
        self.connected = False

    async def identify(self):
        return "who moves it"

    async def set_limits(self, limits) -> None:
        self.moved.append(limits)

    async def move_joints(self, target_rad) -> None:
        self.moved.append(target_rad)

    async def read_joints(self):
        raise AssertionError("the stream tells where the joints are")


def robot_on(stream):
    mover = FakeRobot()
    return mover, AccompaniedRobot(mover, EgmReader(stream, LoopClock()))


async def test_a_robot_is_moved_one_way_and_read_the_other():
    mover, robot = robot_on(Stream())
    as_api: RobotController = robot
    await as_api.connect()
    limits = MotionLimits()

    await robot.set_limits(limits)
    await robot.move_joints((0.1,) * 6)

    assert mover.moved == [limits, (0.1,) * 6]
    assert (await robot.read_joints()).joints_rad == tuple(map(math.radians, FIRST.joints_deg))
    assert await robot.identify() == "who moves it"
    assert (robot.can_stop_motion, robot.motion_guard) == (True, mover.motion_guard)
    assert robot.connected
    await robot.close()
    assert not mover.connected


@pytest.mark.parametrize(
    ("now", "match"),
    [({"motors": Motors.OFF}, "motors are off"), ({"rapid": Rapid.STOPPED}, "program is stopped")],
)
async def test_an_arm_whose_controller_says_that_it_cannot_move_is_not_moved(stream, now, match):
    mover, robot = robot_on(stream)
    await robot.connect()
    stream.frame = replace(stream.frame, **now)

    with pytest.raises(NotInitialisedError, match=match):
        await robot.move_joints((0.1,) * 6)

    assert mover.moved == []
    assert robot.connected
    await robot.close()


async def test_a_robot_without_its_stream_is_not_connected(stream):
    mover, robot = robot_on(stream)
    stream.spoil = lambda frame: []

    with pytest.raises(ConnectFailedError):
        await robot.connect()
    assert not mover.connected
