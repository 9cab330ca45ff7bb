"""A controller with the Remote Motion Interface that lives in memory, and the driver that speaks to it."""

import asyncio
import math

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from truepose_drivers.api import MotionLimits
from truepose_drivers.fanuc_rmi.driver import RmiRobot
from truepose_drivers.fanuc_rmi.protocol import (
    CONNECT_PORT,
    Kind,
    PacketReader,
    Status,
    encode,
    encode_axes,
    encode_status,
    reply,
)

TARGET = tuple(map(math.radians, (10.0, 20.0, -50.0, 1.0, 2.0, 3.0)))
SHOWN_DEG = (10.0, 20.0, 30.0, -1.0, -2.0, -3.0)  # joint 3: 50 from the upper arm, of which 20 are joint 2's
FAST = MotionLimits(1e5, 10.0)
SILENT = HANG_UP = None
WELCOME = {"PortNumber": 16002, "MajorVersion": 9, "MinorVersion": 0}


class FakeController:
    """Carries out everything at once, answers from a table what is in it, and records what it is told."""

    def __init__(self, **replies):
        self.replies = replies  # by the name of a request: bytes, SILENT, or a function of the request
        self.status = Status(True, False, False, False, 1, 100)
        self.axes_deg = (0.0,) * 9
        self.time_ms = 1000
        self.welcome = WELCOME
        self.told = []
        self.overrides = []
        self.motions = []
        self.ends = []

    def link(self, port):
        return MemoryLink(self.greet if port == CONNECT_PORT else self.serve, chunk_bytes=11)

    async def greet(self, end: MemoryEnd) -> None:
        async for packet in requests_at(end):
            await end.send(self.replies.get("greeting") or encode(reply(packet, fields=self.welcome)))

    async def serve(self, end: MemoryEnd) -> None:
        self.ends.append(end)
        async for packet in requests_at(end):
            self.told.append(packet.name)
            said = self._say(packet)
            if said is not SILENT:
                await end.send(said)

    def _say(self, packet):
        if packet.name in self.replies:
            answer = self.replies[packet.name]
            return answer(packet) if callable(answer) else answer
        if packet.kind is Kind.INSTRUCTION:
            self.motions.append(packet)
            self.axes_deg = tuple(packet.fields["JointAngle"].values())
            self.status = replace_status(self.status, next_sequence=self.status.next_sequence + 1)
            return encode(reply(packet))
        if packet.name == "FRC_SetOverRide":
            self.overrides.append(packet.fields["Value"])
            self.status = replace_status(self.status, override_percent=packet.fields["Value"])
        return encode(reply(packet, fields=self._fields(packet.name)))

    def _fields(self, name):
        match name:
            case "FRC_GetStatus":
                return encode_status(self.status)
            case "FRC_ReadJointAngles":
                self.time_ms += 1
                return {"TimeTag": self.time_ms, "JointAngle": encode_axes(self.axes_deg)}
            case "FRC_Initialize":
                self.status = replace_status(self.status, running=True)
            case "FRC_ReadError":
                return {"Count": 1, "ErrorData": "SRVO-002 Teach pendant E-stop"}
        return {}


def replace_status(status, **changes):
    values = {name: getattr(status, name) for name in Status.__dataclass_fields__}
    return Status(**(values | changes))


async def requests_at(end):
    reader = PacketReader()
    while data := await end.receive():
        reader.receive_data(data)
        while (packet := reader.next_message()) is not None:
            yield packet


def refusal(error):
    return lambda packet: encode(reply(packet, error))


def robot_of(fake):
    return RmiRobot(fake.link, FixedClock())


async def connected(fake):
    robot = robot_of(fake)
    await robot.connect()
    await robot.set_limits(FAST)
    return robot


async def begun(robot, fake, degrees_per_s):
    """Return a motion in pieces, of which the second is under way."""
    await robot.set_limits(MotionLimits(1e5, math.radians(degrees_per_s)))
    moving = asyncio.create_task(robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0)))
    while len(fake.motions) < 2:
        await asyncio.sleep(0)
    return moving
