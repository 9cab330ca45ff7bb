"""The conversation with a Universal Robots controller, against a scripted one that lives in memory."""

import asyncio
import contextlib
import math

import pytest

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import (
    ConnectFailedError,
    NoReplyError,
    NotInitialisedError,
    RemoteProtocolError,
    TargetRefusedError,
)
from truepose_drivers.universal_robots.driver import Ports, UniversalRobot
from truepose_drivers.universal_robots.protocol import (
    GREETING,
    Kind,
    Packet,
    PacketReader,
    Recipe,
    controller_version,
    encode,
    recipe_reply,
    text_message,
    verdict,
)
from truepose_drivers.universal_robots.script import INPUTS, OUTPUTS, PROGRAM, order_in

pytestmark = pytest.mark.simulated_time

TARGET = (0.1, -0.2, 0.3, 0.0, math.pi / 4, -1.0)
JOINTS = (0.5, -1.0, 1.5, -2.0, 2.5, -3.0)
OUT, IN = Recipe(1, OUTPUTS), Recipe(1, INPUTS)
PERIOD_S = 0.008
SILENT = None


class FakeController:
    """Streams a state from a table, answers from another, and carries out every motion at once."""

    def __init__(self) -> None:
        self.state = {name: (0.0,) * (6 if kind == "VECTOR6D" else 1) for name, kind in OUTPUTS.items()}
        self.state |= {"actual_q": JOINTS, "robot_mode": (7,), "safety_mode": (1,), "runtime_state": (1,)}
        self.replies: dict[Kind, bytes | None] = {
            Kind.VERSION: encode(verdict(Kind.VERSION, accepted=True)),
            Kind.CONTROLLER: encode(controller_version((5, 11, 0, 108249))),
            Kind.OUTPUTS: encode(recipe_reply(Kind.OUTPUTS, 1, OUTPUTS.values())),
            Kind.INPUTS: encode(recipe_reply(Kind.INPUTS, 1, INPUTS.values())),
            Kind.START: encode(verdict(Kind.START, accepted=True)),
            Kind.PAUSE: encode(verdict(Kind.PAUSE, accepted=True)),
        }
        self.dashboard = {"get serial number": "20185000123", "get robot model": "UR10"}
        self.greeting = GREETING
        self.clock_stands = self.keeps_nothing = False
        self.asked: list[Kind] = []
        self.scripts = ""
        self.beats: list[int] = []
        self.on_script = self.arrive

    def arrive(self) -> None:
        number = self.state["input_int_register_24"]
        self.state |= {"output_int_register_24": number, "output_int_register_26": number}
        self.state |= {"actual_q": order_in(self.state).target_rad}

    def move_for_ever(self) -> None:
        self.state |= {
            "runtime_state": (2,),
            "output_int_register_26": self.state["input_int_register_24"],
        }

    async def serve(self, end: MemoryEnd) -> None:
        packets, stream = PacketReader(), None
        try:
            while data := await end.receive():
                packets.receive_data(data)
                while (packet := packets.next_message()) is not None:
                    stream = await self._answer(end, packet, stream)
        finally:
            if stream is not None:
                stream.cancel()

    async def _answer(self, end, packet: Packet, stream):
        if packet.kind is Kind.DATA:
            values = IN.unpack(packet.payload)
            self.beats.append(order_in(values).beat)
            self.state |= {} if self.keeps_nothing else values
            return stream
        self.asked.append(packet.kind)
        if stream is not None:
            stream.cancel()
        if self.replies[packet.kind] is not SILENT:
            await end.send(self.replies[packet.kind])
        return asyncio.create_task(self._stream(end)) if packet.kind is Kind.START else None

    async def _stream(self, end) -> None:
        while True:
            await asyncio.sleep(PERIOD_S)
            if not self.clock_stands:
                self.state["timestamp"] = (self.state["timestamp"][0] + PERIOD_S,)
            await end.send(encode(OUT.pack(self.state)))

    async def take_script(self, end: MemoryEnd) -> None:
        while data := await end.receive():
            self.scripts += data.decode()
            if self.scripts.endswith("\nend\n"):
                self.on_script()

    async def serve_dashboard(self, end: MemoryEnd) -> None:
        await end.send(f"{self.greeting}\n".encode())
        asked = b""
        while data := await end.receive():
            asked += data
            if asked.endswith(b"\n"):
                answer = self.dashboard.get(asked.decode().strip(), "could not understand")
                await end.send(f"{answer}\n".encode())
                asked = b""


@pytest.fixture
def fake():
    return FakeController()


@pytest.fixture
async def robot(fake):
    async with connected(fake) as robot:
        yield robot


def robot_of(fake: FakeController, chunk_bytes: int = 4096) -> UniversalRobot:
    serves = (fake.serve, fake.take_script, fake.serve_dashboard)
    links = (MemoryLink(serve, chunk_bytes=chunk_bytes) for serve in serves)
    return UniversalRobot(Ports(*links), FixedClock())


@contextlib.asynccontextmanager
async def connected(fake: FakeController, chunk_bytes: int = 4096):
    robot = robot_of(fake, chunk_bytes)
    await robot.connect()
    try:
        yield robot
    finally:
        await robot.close()


@pytest.mark.parametrize("chunk_bytes", [1, 7, 4096])
async def test_joints_are_read_from_any_split_of_the_stream(chunk_bytes):
    async with connected(FakeController(), chunk_bytes) as robot:
        reading = await robot.read_joints()

    assert (reading.joints_rad, reading.time_s) == (JOINTS, 12.5)


async def test_nothing_is_streamed_between_two_questions(fake, robot):
    await robot.read_joints()
    fake.state["actual_q"] = TARGET
    await asyncio.sleep(60.0)

    assert (await robot.read_joints()).joints_rad == TARGET
    assert fake.asked[3:] == [Kind.START, Kind.PAUSE, Kind.START, Kind.PAUSE]


async def test_software_that_does_not_tell_its_serial_number_has_none(fake, robot):
    del fake.dashboard["get serial number"]
    assert (await robot.identify()).serial == "unknown"


async def test_a_dashboard_that_is_none_gives_no_identity(fake, robot):
    fake.greeting = "220 smtp"
    with pytest.raises(RemoteProtocolError, match="not an answer"):
        await robot.identify()


async def test_a_motion_writes_its_order_sends_the_program_and_returns_at_rest(fake, robot):
    await robot.set_limits(MotionLimits(50.0, 0.1))
    await robot.move_joints(TARGET)
    reading = await robot.read_joints()

    assert fake.scripts == PROGRAM
    assert reading.joints_rad == TARGET
    assert order_in(fake.state).tool_speed_mm_s == pytest.approx(50.0)
    assert order_in(fake.state).turning_speed_rad_s == 0.1


async def test_each_motion_has_a_number_of_its_own(fake, robot):
    numbers = []
    for _ in range(3):
        await robot.move_joints(TARGET)
        numbers.append(order_in(fake.state).number)

    assert len(set(numbers)) == 3
    assert 0 not in numbers


async def test_beats_go_on_while_the_arm_moves_and_no_longer(fake, robot):
    fake.on_script = fake.move_for_ever
    moving = asyncio.create_task(robot.move_joints(TARGET))
    await asyncio.sleep(1.0)
    assert 8 <= len(set(fake.beats)) <= 12

    moving.cancel()
    with pytest.raises(asyncio.CancelledError):
        await moving
    before = len(fake.beats)
    await asyncio.sleep(1.0)

    assert len(fake.beats) == before
    assert not robot.connected


async def test_an_order_that_the_registers_do_not_keep_moves_nothing(fake, robot):
    fake.keeps_nothing = True
    with pytest.raises(RemoteProtocolError, match="registers 24 to 31"):
        await robot.move_joints(TARGET)
    assert not robot.connected
    assert fake.scripts == ""


@pytest.mark.parametrize("field", [{"safety_mode": (3,)}, {"robot_mode": (3,)}, {"runtime_state": (2,)}])
async def test_an_arm_that_may_not_move_is_sent_nothing_and_can_still_be_read(fake, robot, field):
    fake.state |= field
    with pytest.raises(NotInitialisedError):
        await robot.move_joints(TARGET)

    assert (await robot.read_joints()).joints_rad == JOINTS
    assert fake.scripts == ""


async def test_an_emergency_stop_on_the_way_ends_the_motion(fake, robot):
    fake.on_script = lambda: fake.state.update({"safety_mode": (7,), "runtime_state": (2,)})
    with pytest.raises(NotInitialisedError, match="its emergency stop is pressed"):
        await robot.move_joints(TARGET)


async def test_texts_of_the_controller_stand_in_the_refusal(fake, robot):
    def refuse():
        fake.state["output_int_register_26"] = fake.state["input_int_register_24"]

    fake.on_script = refuse
    fake.replies[Kind.START] += encode(text_message("joint limit", "RTMachine", 0))
    with pytest.raises(TargetRefusedError, match="joint limit"):
        await robot.move_joints(TARGET)
    assert robot.connected


async def test_a_clock_that_stands_still_is_a_lost_link(fake, robot):
    await robot.read_joints()
    fake.clock_stands = True

    with pytest.raises(NoReplyError, match="clock has stopped"):
        await robot.read_joints()
    assert not robot.connected


async def test_states_from_before_are_not_taken_again(fake, robot):
    await robot.read_joints()
    fake.state["timestamp"] = (-5.0,)

    with pytest.raises(NoReplyError):
        await robot.read_joints()


@pytest.mark.parametrize("kind", [Kind.START, Kind.CONTROLLER])
async def test_silence_closes_the_link_and_connecting_again_helps(fake, robot, kind):
    whole, fake.replies[kind] = fake.replies[kind], SILENT
    with pytest.raises(NoReplyError, match="does not respond"):
        await (robot.read_joints() if kind is Kind.START else robot.identify())
    assert not robot.connected

    fake.replies[kind] = whole
    await robot.connect()
    assert (await robot.read_joints()).joints_rad == JOINTS


async def test_a_second_owner_is_refused_before_anything_moves(fake):
    types = ["IN_USE", *list(INPUTS.values())[1:]]
    fake.replies[Kind.INPUTS] = encode(recipe_reply(Kind.INPUTS, 0, types))
    robot = robot_of(fake)

    with pytest.raises(ConnectFailedError, match="another program writes input_int_register_24"):
        await robot.connect()
    assert not robot.connected


async def test_old_software_is_told_which_one_is_needed(fake):
    types = [*list(OUTPUTS.values())[:-1], "NOT_FOUND"]
    fake.replies[Kind.OUTPUTS] = encode(recipe_reply(Kind.OUTPUTS, 0, types))
    robot = robot_of(fake)

    with pytest.raises(RemoteProtocolError, match=r"input_double_register_31.*3\.9 or 5\.3"):
        await robot.connect()
    assert not robot.connected
