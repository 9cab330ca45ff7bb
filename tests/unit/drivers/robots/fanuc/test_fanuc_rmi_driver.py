"""The conversation of the Remote Motion Interface, against a scripted controller that lives in memory."""

import asyncio
import math

import pytest

from tests.unit.drivers.robots.fanuc.rmi_controller import (
    SHOWN_DEG,
    SILENT,
    TARGET,
    FakeController,
    begun,
    connected,
    refusal,
    replace_status,
)
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import (
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
    TargetRefusedError,
)
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.protocol import (
    Session,
    encode,
    reply,
    session,
)

pytestmark = pytest.mark.simulated_time


async def test_a_target_goes_out_as_the_controller_counts_and_comes_back_as_the_robot_file_does(fake, robot):
    await robot.move_joints(TARGET)
    reading = await robot.read_joints()

    assert fake.axes_deg[:6] == pytest.approx(SHOWN_DEG)
    assert reading.joints_rad == pytest.approx(TARGET, abs=1e-8)
    assert math.degrees(reading.resolution_rad) == pytest.approx(0.001)
    assert reading.time_s == 12.5


async def test_the_controller_is_initialised_for_the_first_motion_and_not_before(fake, robot):
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


async def test_instructions_are_counted_on_from_where_the_controller_stands(fake, robot):
    fake.status = replace_status(fake.status, next_sequence=41)

    await robot.move_joints(TARGET)

    assert fake.motions[0].fields["SequenceID"] == 41


async def test_a_program_that_another_session_left_is_ended_first(fake, robot):
    fake.status = replace_status(fake.status, running=True)

    await robot.move_joints(TARGET)

    assert fake.told[1:4] == ["FRC_GetStatus", "FRC_Abort", "FRC_Initialize"]


async def test_faults_are_reset_only_where_the_controller_cannot_be_initialised_otherwise():
    fake = FakeController(FRC_Initialize=refusal(protocol.INVALID_STATE))

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
    ("change", "words"), [({"pendant_on": True}, "pendant off"), ({"single_step": True}, "single-step")]
)
async def test_an_arm_in_a_persons_hands_is_not_moved(fake, robot, change, words):
    fake.status = replace_status(fake.status, **change)

    with pytest.raises(NotInitialisedError, match=words):
        await robot.move_joints(TARGET)
    assert "FRC_Initialize" not in fake.told


async def test_a_fault_between_two_pieces_ends_the_motion(fake, robot):
    moving = await begun(robot, fake, 20.0)
    await fake.ends[-1].send(encode(session(Session.SYSTEM_FAULT, SequenceID=2)))

    with pytest.raises(NotInitialisedError, match="stopped during the motion"):
        await moving
    assert len(fake.motions) < 5
    assert fake.told.count("FRC_Initialize") == 1


async def test_additional_axes_stay_where_they_are(fake, robot):
    fake.axes_deg = (*(0.0,) * 6, 123.5, 7.0, 0.0)

    await robot.move_joints(TARGET)

    assert fake.axes_deg[6:] == (123.5, 7.0, 0.0)


async def test_a_refused_target_is_named_as_the_pendant_shows_it_and_the_next_one_is_taken():
    fake = FakeController(FRC_JointMotionJRep=refusal(protocol.BAD_DESTINATION))
    robot = await connected(fake)

    with pytest.raises(TargetRefusedError, match=r"10\.000, 20\.000, 30\.000.*cannot be reached.*SRVO-002"):
        await robot.move_joints(TARGET)
    del fake.replies["FRC_JointMotionJRep"]
    fake.told.clear()
    await robot.move_joints(TARGET)

    assert fake.told[:3] == ["FRC_GetStatus", "FRC_Abort", "FRC_Initialize"]
    assert fake.axes_deg[:6] == pytest.approx(SHOWN_DEG)


async def test_a_controller_on_hold_is_no_refused_target():
    robot = await connected(FakeController(FRC_JointMotionJRep=refusal(protocol.IN_HOLD)))

    with pytest.raises(NotInitialisedError, match="aborted"):
        await robot.move_joints(TARGET)
    assert robot.connected


async def test_a_fault_on_the_way_is_told_at_once_and_its_late_reply_is_nothing():
    fake = FakeController(FRC_JointMotionJRep=encode(session(Session.SYSTEM_FAULT, SequenceID=1)))
    robot = await connected(fake)

    with pytest.raises(NotInitialisedError, match=r"stopped during the motion.*fault"):
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

    with pytest.raises(NoReplyError, match="does not respond"):
        await moving

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


async def test_joints_that_are_not_told_are_no_reading(fake, robot):
    fake.replies["FRC_ReadJointAngles"] = refusal(protocol.INVALID_STATE)

    with pytest.raises(DeviceRefusedError, match="not ready"):
        await robot.read_joints()
    assert robot.connected


async def test_joints_are_read_between_the_pieces_of_a_motion(fake, robot):
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    moving = asyncio.create_task(robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0)))
    while not fake.motions:
        await asyncio.sleep(0)
    under_way = (await robot.read_joints()).joints_rad[0]
    await moving

    assert 0.0 < under_way < 1.0


async def test_two_motions_at_once_go_one_after_the_other(fake, robot):
    await asyncio.gather(robot.move_joints(TARGET), robot.move_joints((0.0,) * 6))

    assert [packet.fields["SequenceID"] for packet in fake.motions] == list(range(1, len(fake.motions) + 1))
    assert fake.axes_deg[:6] == pytest.approx((0.0,) * 6)
