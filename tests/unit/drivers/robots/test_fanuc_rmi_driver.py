"""The conversation of the Remote Motion Interface, against a scripted controller that lives in memory."""

import asyncio
import math

import pytest

from truepose_drivers.api import MotionGuard, MotionLimits, RobotController
from truepose_drivers.errors import (
    ConfigurationError,
    ConnectFailedError,
    ConnectionLostError,
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
    RemoteProtocolError,
    TargetRefusedError,
)
from truepose_drivers.fanuc_rmi.driver import PLUGIN, RmiRobot, TimeOuts
from truepose_drivers.fanuc_rmi.protocol import refusals
from truepose_drivers.fanuc_rmi.protocol.messages import (
    CONNECT_PORT,
    Session,
    Status,
    encode_axes,
    encode_status,
    reply,
    session,
)
from truepose_drivers.fanuc_rmi.protocol.packets import Kind, PacketReader, encode
from truepose_drivers.transports.memory import MemoryEnd, MemoryLink

pytestmark = pytest.mark.simulated_time

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


class FixedClock:
    async def now_s(self) -> float:
        return 7.25

    async def sleep(self, duration_s: float) -> None:
        raise AssertionError("a robot driver never sleeps in cell time")


def robot_of(fake, **time_outs):
    return RmiRobot(fake.link, FixedClock(), time_outs=TimeOuts(**time_outs))


async def connected(fake, **time_outs):
    robot = robot_of(fake, **time_outs)
    await robot.connect()
    await robot.set_limits(FAST)
    return robot


def test_it_sends_short_pieces_only():
    robot: RobotController = robot_of(FakeController())

    assert robot.motion_guard == MotionGuard(longest_piece_s=0.8)
    assert robot.can_stop_motion
    assert not robot.connected


async def test_a_target_goes_out_as_the_controller_counts_and_comes_back_as_the_robot_file_does():
    fake = FakeController()
    robot = await connected(fake)

    await robot.move_joints(TARGET)
    reading = await robot.read_joints()

    assert fake.axes_deg[:6] == pytest.approx(SHOWN_DEG)
    assert reading.joints_rad == pytest.approx(TARGET, abs=1e-8)
    assert math.degrees(reading.resolution_rad) == pytest.approx(0.001)
    assert reading.time_s == 7.25


async def test_the_controller_is_initialised_for_the_first_motion_and_not_before():
    fake = FakeController()
    robot = await connected(fake)
    await robot.read_joints()
    assert fake.told == ["FRC_ReadJointAngles", "FRC_ReadJointAngles"]
    fake.told.clear()

    await robot.move_joints(TARGET)
    await robot.move_joints(TARGET)

    motion = ["FRC_ReadJointAngles", "FRC_GetStatus", "FRC_JointMotionJRep", "FRC_ReadJointAngles"]
    first = ["FRC_GetStatus", "FRC_Initialize", "FRC_GetStatus"]
    assert fake.told == [*first, *motion, "FRC_GetStatus", *motion]
    assert [packet.fields["SequenceID"] for packet in fake.motions] == [1, 2]
    assert {packet.fields["TermType"] for packet in fake.motions} == {"FINE"}


async def test_instructions_are_counted_on_from_where_the_controller_stands():
    fake = FakeController()
    fake.status = replace_status(fake.status, next_sequence=41)
    robot = await connected(fake)

    await robot.move_joints(TARGET)

    assert fake.motions[0].fields["SequenceID"] == 41


async def test_a_program_that_another_session_left_is_ended_first():
    fake = FakeController()
    fake.status = replace_status(fake.status, running=True)
    robot = await connected(fake)

    await robot.move_joints(TARGET)

    assert fake.told[1:4] == ["FRC_GetStatus", "FRC_Abort", "FRC_Initialize"]


async def test_faults_are_reset_only_where_the_controller_cannot_be_initialised_otherwise():
    fake = FakeController(FRC_Initialize=refusal(refusals.INVALID_STATE))

    def reset(packet):
        del fake.replies["FRC_Initialize"]
        return encode(reply(packet))

    fake.replies["FRC_Reset"] = reset
    robot = await connected(fake)

    await robot.move_joints(TARGET)

    assert fake.told[2:5] == ["FRC_Initialize", "FRC_Reset", "FRC_Initialize"]


async def test_a_controller_that_is_not_ready_is_not_moved_and_says_why():
    fake = FakeController(FRC_Initialize=refusal(7015))
    robot = await connected(fake)

    with pytest.raises(NotInitialisedError, match=r"RMI_MOVE.*delete it.*SRVO-002.*confirm"):
        await robot.move_joints(TARGET)

    assert fake.motions == []
    assert robot.connected


@pytest.mark.parametrize(
    ("change", "words"), [({"pendant_on": True}, "pendant off"), ({"single_step": True}, "single steps")]
)
async def test_an_arm_in_a_persons_hands_is_not_moved(change, words):
    fake = FakeController()
    fake.status = replace_status(fake.status, **change)
    robot = await connected(fake)

    with pytest.raises(NotInitialisedError, match=words):
        await robot.move_joints(TARGET)
    assert "FRC_Initialize" not in fake.told


async def test_no_piece_takes_longer_than_it_may_go_on_alone():
    fake = FakeController()
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert {packet.fields["Speed"] for packet in fake.motions} == {5}
    assert "FRC_SetOverRide" not in fake.told  # 17.5 of 350 deg/s: within 20 deg/s
    steps = [packet.fields["JointAngle"]["J1"] for packet in fake.motions]
    assert len(steps) == math.ceil(90.0 / 17.5 / 0.8)
    assert max(b - a for a, b in zip([0.0, *steps], steps, strict=False)) <= 17.5 * 0.8
    assert steps[-1] == pytest.approx(90.0)


async def test_a_low_override_makes_pieces_shorter():
    fake = FakeController()
    fake.status = replace_status(fake.status, override_percent=10)
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert len(fake.motions) == math.ceil(90.0 / 1.75 / 0.8)


async def test_an_override_that_somebody_lowers_on_the_way_makes_the_pieces_shorter_from_there():
    fake = FakeController()
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    moving = asyncio.create_task(robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0)))
    while len(fake.motions) < 2:
        await asyncio.sleep(0)
    before = len(fake.motions)
    fake.status = replace_status(fake.status, override_percent=50)
    await moving

    ends = [packet.fields["JointAngle"]["J1"] for packet in fake.motions]
    steps = [b - a for a, b in zip([0.0, *ends], ends, strict=False)]
    assert min(steps[:before]) > 17.5 * 0.4
    assert max(steps[before + 1 :]) <= 17.5 * 0.5 * 0.8 + 1e-9
    assert ends[-1] == pytest.approx(90.0)


async def test_an_override_that_somebody_raises_keeps_no_motion_above_its_limits_and_is_left_to_them():
    fake = FakeController()
    fake.status = replace_status(fake.status, override_percent=80)
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    moving = asyncio.create_task(robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0)))
    while len(fake.motions) < 2:
        await asyncio.sleep(0)
    fake.status = replace_status(fake.status, override_percent=100)
    await moving

    assert fake.overrides == [57, 57, 100]  # 2.0 of 3.5 deg/s, once more, and what somebody had set


async def test_a_fault_between_two_pieces_ends_the_motion():
    fake = FakeController()
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    moving = asyncio.create_task(robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0)))
    while len(fake.motions) < 2:
        await asyncio.sleep(0)
    await fake.ends[-1].send(encode(session(Session.SYSTEM_FAULT, SequenceID=2)))

    with pytest.raises(NotInitialisedError, match="stopped on its way"):
        await moving
    assert len(fake.motions) < 5
    assert fake.told.count("FRC_Initialize") == 1


async def test_an_override_that_makes_a_motion_endless_is_refused():
    fake = FakeController()
    fake.status = replace_status(fake.status, override_percent=1)
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(4.0)))

    with pytest.raises(DeviceRefusedError, match="override"):
        await robot.move_joints((math.pi, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert fake.motions == []


async def test_a_limit_below_the_slowest_share_is_kept_by_a_lower_override_for_so_long():
    fake = FakeController()
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert {packet.fields["Speed"] for packet in fake.motions} == {1}
    assert fake.overrides == [57, 100]  # 2.0 of 3.5 deg/s
    assert len(fake.motions) == math.ceil(90.0 / (3.5 * 0.57) / 0.8)
    assert fake.told.index("FRC_SetOverRide") < fake.told.index("FRC_JointMotionJRep")


async def test_an_override_that_the_driver_lowered_comes_back_after_a_refusal():
    fake = FakeController(FRC_JointMotionJRep=refusal(refusals.BAD_POSITION_DATA))
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    with pytest.raises(TargetRefusedError):
        await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert fake.overrides == [57, 100]


async def test_an_override_that_is_not_kept_moves_nothing():
    fake = FakeController(FRC_SetOverRide=lambda packet: encode(reply(packet)))
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    with pytest.raises(DeviceRefusedError, match="override of 57 %"):
        await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert fake.motions == []


async def test_a_limit_that_no_speed_keeps_is_refused():
    fake = FakeController()
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(0.01, math.radians(3.0)))

    with pytest.raises(DeviceRefusedError, match="no speed as low"):
        await robot.move_joints(TARGET)
    assert fake.motions == []


async def test_additional_axes_stay_where_they_are():
    fake = FakeController()
    fake.axes_deg = (*(0.0,) * 6, 123.5, 7.0, 0.0)
    robot = await connected(fake)

    await robot.move_joints(TARGET)

    assert fake.axes_deg[6:] == (123.5, 7.0, 0.0)


async def test_a_refused_target_is_named_as_the_pendant_shows_it_and_the_next_one_is_taken():
    fake = FakeController(FRC_JointMotionJRep=refusal(refusals.BAD_DESTINATION))
    robot = await connected(fake)

    with pytest.raises(TargetRefusedError, match=r"10\.000, 20\.000, 30\.000.*cannot be reached.*SRVO-002"):
        await robot.move_joints(TARGET)
    del fake.replies["FRC_JointMotionJRep"]
    fake.told.clear()
    await robot.move_joints(TARGET)

    assert fake.told[:3] == ["FRC_GetStatus", "FRC_Abort", "FRC_Initialize"]
    assert fake.axes_deg[:6] == pytest.approx(SHOWN_DEG)


async def test_a_controller_on_hold_is_no_refused_target():
    robot = await connected(FakeController(FRC_JointMotionJRep=refusal(refusals.IN_HOLD)))

    with pytest.raises(NotInitialisedError, match="broke off"):
        await robot.move_joints(TARGET)
    assert robot.connected


async def test_a_fault_on_the_way_is_told_at_once_and_its_late_reply_is_nothing():
    fake = FakeController(FRC_JointMotionJRep=encode(session(Session.SYSTEM_FAULT, SequenceID=1)))
    robot = await connected(fake)

    with pytest.raises(NotInitialisedError, match=r"stopped on its way.*fault"):
        await robot.move_joints(TARGET)
    await fake.ends[-1].send(b'{"Instruction": "FRC_JointMotionJRep", "ErrorID": 1, "SequenceID": 1}\r\n')
    del fake.replies["FRC_JointMotionJRep"]
    await robot.move_joints(TARGET)

    assert fake.axes_deg[:6] == pytest.approx(SHOWN_DEG)


async def test_a_program_that_somebody_ends_is_no_arrival():
    fake = FakeController(FRC_JointMotionJRep=SILENT)
    robot = await connected(fake)

    moving = asyncio.create_task(robot.move_joints(TARGET))
    await asyncio.sleep(1.0)
    fake.status = replace_status(fake.status, running=False)

    with pytest.raises(NotInitialisedError, match="ended on the pendant"):
        await moving


async def test_a_dead_controller_is_known_within_two_seconds_while_the_arm_moves():
    fake = FakeController(FRC_JointMotionJRep=SILENT)
    robot = await connected(fake)
    moving = asyncio.create_task(robot.move_joints(TARGET))
    while "FRC_JointMotionJRep" not in fake.told:
        await asyncio.sleep(0.01)
    fake.replies["FRC_GetStatus"] = SILENT
    dead_s = asyncio.get_running_loop().time()

    with pytest.raises(NoReplyError, match="says nothing"):
        await moving

    assert asyncio.get_running_loop().time() - dead_s < 2.0
    assert not robot.connected


async def test_a_dead_controller_is_known_within_two_seconds_at_rest():
    fake = FakeController()
    robot = await connected(fake)
    fake.replies["FRC_ReadJointAngles"] = SILENT
    dead_s = asyncio.get_running_loop().time()

    with pytest.raises(NoReplyError, match="pendant"):
        await robot.read_joints()

    assert asyncio.get_running_loop().time() - dead_s < 2.0
    assert not robot.connected


async def test_a_motion_that_somebody_holds_is_waited_for_and_then_given_up():
    fake = FakeController(FRC_JointMotionJRep=SILENT)
    robot = await connected(fake)
    begun_s = asyncio.get_running_loop().time()

    with pytest.raises(NoReplyError, match="hold"):
        await robot.move_joints(TARGET)

    assert 20.0 < asyncio.get_running_loop().time() - begun_s < 22.0
    assert fake.told[-1] == "FRC_Disconnect"


async def test_an_abandoned_motion_ends_the_session_and_with_it_the_controllers_program():
    fake = FakeController(FRC_JointMotionJRep=SILENT)
    robot = await connected(fake)
    moving = asyncio.create_task(robot.move_joints(TARGET))
    while "FRC_JointMotionJRep" not in fake.told:
        await asyncio.sleep(0)

    moving.cancel()
    with pytest.raises(asyncio.CancelledError):
        await moving

    assert not robot.connected
    assert fake.told[-1] == "FRC_Disconnect"


async def test_whoever_closes_says_so():
    fake = FakeController()
    robot = await connected(fake)

    await robot.close()
    await robot.close()

    assert fake.told.count("FRC_Disconnect") == 1


async def test_an_end_that_is_reported_elsewhere_is_none():
    robot = await connected(FakeController(FRC_JointMotionJRep=lambda packet: encode(reply(packet))))

    with pytest.raises(RemoteProtocolError, match=r"30\.000 deg off"):
        await robot.move_joints(TARGET)
    assert not robot.connected


async def test_the_end_of_another_motion_is_none():
    other = b'{"Instruction": "FRC_JointMotionJRep", "ErrorID": 0, "SequenceID": 77}\r\n'
    robot = await connected(FakeController(FRC_JointMotionJRep=other))

    with pytest.raises(RemoteProtocolError, match="not asked"):
        await robot.move_joints(TARGET)
    assert not robot.connected


async def test_joints_that_are_stated_again_are_asked_for_again():
    fake = FakeController()
    robot = await connected(fake)
    tags = iter([5000, 5000, 5001])
    fake.replies["FRC_ReadJointAngles"] = lambda packet: encode(
        reply(packet, fields={"TimeTag": next(tags), "JointAngle": encode_axes(fake.axes_deg)})
    )

    await robot.read_joints()
    await robot.read_joints()

    assert list(tags) == []


async def test_a_frozen_controller_is_a_lost_one():
    fake = FakeController()
    robot = await connected(fake)
    fake.replies["FRC_ReadJointAngles"] = lambda packet: encode(
        reply(packet, fields={"TimeTag": 5000, "JointAngle": encode_axes(fake.axes_deg)})
    )
    await robot.read_joints()

    with pytest.raises(NoReplyError, match="repeats itself"):
        await robot.read_joints()
    assert not robot.connected


async def test_older_joints_are_no_reading():
    fake = FakeController()
    robot = await connected(fake)
    await robot.read_joints()
    fake.time_ms -= 100

    with pytest.raises(RemoteProtocolError, match="older"):
        await robot.read_joints()
    assert not robot.connected


@pytest.mark.parametrize(
    "said",
    [
        b"SSH-2.0-x\r\n",
        b'{"Command": "FRC_GetStatus", "ErrorID": 0}\r\n',
        b'{"Command": "FRC_ReadJointAngles"}\r\n',
        b'{"Command": "FRC_ReadJointAngles", "ErrorID": 0, "TimeTag": 1, "JointAngle": {"J1": 1}}\r\n',
        b"x" * 3000,
    ],
)
async def test_nonsense_closes_the_session(said):
    fake = FakeController()
    robot = await connected(fake)
    fake.replies["FRC_ReadJointAngles"] = said

    with pytest.raises(RemoteProtocolError):
        await robot.read_joints()
    assert not robot.connected


async def test_what_was_not_asked_is_noticed_before_the_next_question():
    fake = FakeController()
    robot = await connected(fake)
    await fake.ends[-1].send(b'{"Command": "FRC_ReadJointAngles", "ErrorID": 0}\r\n')

    with pytest.raises(RemoteProtocolError, match="not asked"):
        await robot.read_joints()


async def test_a_controller_that_ends_the_session_is_a_lost_one():
    fake = FakeController()
    robot = await connected(fake)
    await fake.ends[-1].send(encode(session(Session.TERMINATE)))

    with pytest.raises(ConnectionLostError, match="hour"):
        await robot.read_joints()
    assert not robot.connected


async def test_a_fault_between_two_motions_has_the_controller_initialised_anew():
    fake = FakeController()
    robot = await connected(fake)
    await robot.move_joints(TARGET)
    await fake.ends[-1].send(encode(session(Session.SYSTEM_FAULT, SequenceID=1)))
    await fake.ends[-1].send(encode(session(Session.ASCII_READY)))

    await robot.move_joints(TARGET)

    assert fake.told.count("FRC_Initialize") == 2


async def test_joints_that_are_not_told_are_no_reading():
    fake = FakeController()
    robot = await connected(fake)
    fake.replies["FRC_ReadJointAngles"] = refusal(refusals.INVALID_STATE)

    with pytest.raises(DeviceRefusedError, match="not ready"):
        await robot.read_joints()
    assert robot.connected


async def test_joints_are_read_between_the_pieces_of_a_motion():
    fake = FakeController()
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    moving = asyncio.create_task(robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0)))
    while not fake.motions:
        await asyncio.sleep(0)
    under_way = (await robot.read_joints()).joints_rad[0]
    await moving

    assert 0.0 < under_way < 1.0


async def test_two_motions_at_once_go_one_after_the_other():
    fake = FakeController()
    robot = await connected(fake)

    await asyncio.gather(robot.move_joints(TARGET), robot.move_joints((0.0,) * 6))

    assert [packet.fields["SequenceID"] for packet in fake.motions] == list(range(1, len(fake.motions) + 1))
    assert fake.axes_deg[:6] == pytest.approx((0.0,) * 6)


async def test_the_interface_tells_its_version_only():
    identity = await (await connected(FakeController())).identify()

    assert (identity.manufacturer, identity.model, identity.serial) == ("FANUC", "unknown", "unknown")
    assert identity.firmware == "RMI 9.0"


async def test_another_client_is_waited_for_and_then_named():
    fake = FakeController(greeting=b'{"Communication": "FRC_Connect", "ErrorID": 2556954}\r\n')
    begun_s = asyncio.get_running_loop().time()

    with pytest.raises(ConnectFailedError, match="another program"):
        await robot_of(fake).connect()

    assert 3.0 <= asyncio.get_running_loop().time() - begun_s < 5.0


async def test_a_second_port_that_says_nothing_is_another_clients():
    with pytest.raises(ConnectFailedError, match="no other program"):
        await robot_of(FakeController(FRC_ReadJointAngles=SILENT)).connect()


async def test_a_controller_that_lets_in_after_a_while_is_connected():
    fake = FakeController(greeting=b'{"Communication": "FRC_Connect", "ErrorID": 2556954}\r\n')
    robot = robot_of(fake)

    connecting = asyncio.create_task(robot.connect())
    await asyncio.sleep(2.7)
    del fake.replies["greeting"]
    await connecting

    assert robot.connected


async def test_nobody_at_the_address_is_said_at_once():
    robot = RmiRobot(lambda port: MemoryLink(None), FixedClock())
    begun_s = asyncio.get_running_loop().time()

    with pytest.raises(ConnectFailedError):
        await robot.connect()
    assert asyncio.get_running_loop().time() == begun_s


@pytest.mark.parametrize("greeting", [b"SSH-2.0-OpenSSH\r\n", b'{"Command": "Unknown", "ErrorID": 1}\r\n'])
async def test_another_greeting_is_no_robot(greeting):
    robot = robot_of(FakeController(greeting=greeting))

    with pytest.raises(RemoteProtocolError):
        await robot.connect()
    assert not robot.connected


async def test_it_moves_again_after_connecting_again():
    fake = FakeController()
    robot = await connected(fake)
    await robot.move_joints(TARGET)
    fake.ends[-1].close()
    with pytest.raises(ConnectionLostError):
        await robot.read_joints()

    await robot.connect()
    await robot.move_joints(TARGET)

    assert fake.told.count("FRC_Initialize") == 2


@pytest.mark.parametrize(
    "target", [(0.0,) * 5, (0.0,) * 7, (), (float("nan"),) * 6, (float("inf"), 0, 0, 0, 0, 0), (100.0,) * 6]
)
async def test_an_absurd_target_never_reaches_the_robot(target):
    fake = FakeController()
    robot = await connected(fake)

    with pytest.raises(TargetRefusedError):
        await robot.move_joints(target)

    assert fake.told == ["FRC_ReadJointAngles"]


@pytest.mark.parametrize("speed", [0.0, -1.0, float("nan"), float("inf")])
async def test_an_absurd_speed_is_refused(speed):
    robot = robot_of(FakeController())

    with pytest.raises(ConfigurationError, match="speed"):
        await robot.set_limits(MotionLimits(tool_speed_mm_s=speed))
    with pytest.raises(ConfigurationError, match="speed"):
        await robot.set_limits(MotionLimits(orientation_speed_rad_s=speed))


@pytest.mark.parametrize(
    ("name", "value"),
    [("joint_3_from", "the floor"), ("signs", "1 1 -1"), ("joint_speeds_deg_s", 350), ("port", 0)],
)
def test_an_option_that_makes_no_sense_is_refused_by_name(name, value):
    with pytest.raises(ConfigurationError, match=name):
        PLUGIN.open({"host": "127.0.0.1", name: value}, None)
