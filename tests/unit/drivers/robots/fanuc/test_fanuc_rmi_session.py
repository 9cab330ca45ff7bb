"""Sessions of the Remote Motion Interface: begun, lost, ended by others."""

import asyncio

import pytest

from tests.helpers.instruments.fixed_clock import FixedClock
from tests.helpers.instruments.memory_link import MemoryLink
from tests.unit.drivers.robots.fanuc.rmi_controller import (
    SILENT,
    TARGET,
    FakeController,
    connected,
    robot_of,
)
from truepose_drivers.errors import (
    ConnectFailedError,
    ConnectionLostError,
    RemoteProtocolError,
)
from truepose_drivers.fanuc_rmi.driver import RmiRobot
from truepose_drivers.fanuc_rmi.protocol import (
    Session,
    encode,
    encode_axes,
    reply,
    session,
)

pytestmark = pytest.mark.simulated_time


async def test_whoever_closes_says_so(fake, robot):
    await robot.close()
    await robot.close()

    assert fake.told.count("FRC_Disconnect") == 1


OTHER_END = b'{"Instruction": "FRC_JointMotionJRep", "ErrorID": 0, "SequenceID": 77}\r\n'


@pytest.mark.parametrize(
    ("says", "complaint"),
    [(lambda packet: encode(reply(packet)), r"30\.000 deg off"), (OTHER_END, "without a request")],
)
async def test_an_end_that_is_reported_elsewhere_or_of_another_motion_is_none(says, complaint):
    robot = await connected(FakeController(FRC_JointMotionJRep=says))

    with pytest.raises(RemoteProtocolError, match=complaint):
        await robot.move_joints(TARGET)
    assert not robot.connected


async def test_joints_that_are_stated_again_are_asked_for_again(fake, robot):
    tags = iter([5000, 5000, 5001])
    fake.replies["FRC_ReadJointAngles"] = lambda packet: encode(
        reply(packet, fields={"TimeTag": next(tags), "JointAngle": encode_axes(fake.axes_deg)})
    )

    await robot.read_joints()
    await robot.read_joints()

    assert list(tags) == []


async def test_older_joints_are_no_reading(fake, robot):
    await robot.read_joints()
    fake.time_ms -= 100

    with pytest.raises(RemoteProtocolError, match="older"):
        await robot.read_joints()
    assert not robot.connected


async def test_what_was_not_asked_is_noticed_before_the_next_question(fake, robot):
    await fake.ends[-1].send(b'{"Command": "FRC_ReadJointAngles", "ErrorID": 0}\r\n')

    with pytest.raises(RemoteProtocolError, match="without a request"):
        await robot.read_joints()


async def test_a_controller_that_ends_the_session_is_a_lost_one(fake, robot):
    await fake.ends[-1].send(encode(session(Session.TERMINATE)))

    with pytest.raises(ConnectionLostError, match="hour"):
        await robot.read_joints()
    assert not robot.connected


async def test_a_fault_between_two_motions_has_the_controller_initialised_anew(fake, robot):
    await robot.move_joints(TARGET)
    await fake.ends[-1].send(encode(session(Session.SYSTEM_FAULT, SequenceID=1)))
    await fake.ends[-1].send(encode(session(Session.ASCII_READY)))

    await robot.move_joints(TARGET)

    assert fake.told.count("FRC_Initialize") == 2


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


async def test_it_moves_again_after_connecting_again(fake, robot):
    await robot.move_joints(TARGET)
    fake.ends[-1].close()
    with pytest.raises(ConnectionLostError):
        await robot.read_joints()

    await robot.connect()
    await robot.move_joints(TARGET)

    assert fake.told.count("FRC_Initialize") == 2
