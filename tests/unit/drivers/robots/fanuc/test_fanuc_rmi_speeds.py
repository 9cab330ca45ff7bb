"""How fast and in which pieces an arm is moved over the Remote Motion Interface."""

import math

import pytest

from tests.unit.drivers.robots.fanuc.rmi_controller import (
    FakeController,
    begun,
    connected,
    refusal,
    replace_status,
)
from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import (
    DeviceRefusedError,
    TargetRefusedError,
)
from truepose_drivers.fanuc_rmi import protocol
from truepose_drivers.fanuc_rmi.protocol import (
    encode,
    reply,
)

pytestmark = pytest.mark.simulated_time


async def test_no_piece_takes_longer_than_it_may_go_on_alone(fake, robot):
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert {packet.fields["Speed"] for packet in fake.motions} == {5}
    assert "FRC_SetOverRide" not in fake.told  # 17.5 of 350 deg/s: within 20 deg/s
    steps = [packet.fields["JointAngle"]["J1"] for packet in fake.motions]
    assert len(steps) == math.ceil(90.0 / 17.5 / 0.8)
    assert max(b - a for a, b in zip([0.0, *steps], steps, strict=False)) <= 17.5 * 0.8
    assert steps[-1] == pytest.approx(90.0)


async def test_a_low_override_makes_pieces_shorter(fake, robot):
    fake.status = replace_status(fake.status, override_percent=10)
    await robot.set_limits(MotionLimits(1e5, math.radians(20.0)))

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert len(fake.motions) == math.ceil(90.0 / 1.75 / 0.8)


async def test_an_override_that_somebody_lowers_on_the_way_makes_the_pieces_shorter_from_there(fake, robot):
    moving = await begun(robot, fake, 20.0)
    before = len(fake.motions)
    fake.status = replace_status(fake.status, override_percent=50)
    await moving

    ends = [packet.fields["JointAngle"]["J1"] for packet in fake.motions]
    steps = [b - a for a, b in zip([0.0, *ends], ends, strict=False)]
    assert min(steps[:before]) > 17.5 * 0.4
    assert max(steps[before + 1 :]) <= 17.5 * 0.5 * 0.8 + 1e-9
    assert ends[-1] == pytest.approx(90.0)


async def test_the_override_that_somebody_set_is_told_and_not_the_drivers_own(fake, robot):
    fake.status = replace_status(fake.status, override_percent=80)
    await robot.identify()
    told = [robot.motion_guard.speed_share]

    moving = await begun(robot, fake, 2.0)
    told.append(robot.motion_guard.speed_share)
    fake.status = replace_status(fake.status, override_percent=30)
    await moving

    assert fake.overrides[0] == 57  # 2.0 of 3.5 deg/s
    assert [*told, robot.motion_guard.speed_share] == [0.8, 0.8, 0.3]


async def test_an_override_that_somebody_raises_keeps_no_motion_above_its_limits_and_is_left_to_them(
    fake, robot
):
    fake.status = replace_status(fake.status, override_percent=80)

    moving = await begun(robot, fake, 2.0)
    fake.status = replace_status(fake.status, override_percent=100)
    await moving

    assert fake.overrides == [57, 57, 100]  # 2.0 of 3.5 deg/s, once more, and what somebody had set


@pytest.mark.parametrize(
    ("fake", "override_percent", "limits", "complaint"),
    [
        (FakeController(), 1, MotionLimits(1e5, math.radians(4.0)), "raise the speed limits"),  # endless
        (
            FakeController(FRC_SetOverRide=lambda packet: encode(reply(packet))),
            100,
            MotionLimits(1e5, math.radians(2.0)),
            "override of 57 %",  # is not kept
        ),
        (FakeController(), 100, MotionLimits(0.01, math.radians(3.0)), "cannot move as slowly"),
    ],
)
async def test_a_motion_that_no_speed_or_override_makes_right_is_refused(
    fake, override_percent, limits, complaint
):
    fake.status = replace_status(fake.status, override_percent=override_percent)
    robot = await connected(fake)
    await robot.set_limits(limits)

    with pytest.raises(DeviceRefusedError, match=complaint):
        await robot.move_joints((math.pi, 0.0, 0.0, 0.0, 0.0, 0.0))
    assert fake.motions == []


async def test_a_limit_below_the_slowest_share_is_kept_by_a_lower_override_for_so_long(fake, robot):
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert {packet.fields["Speed"] for packet in fake.motions} == {1}
    assert fake.overrides == [57, 100]  # 2.0 of 3.5 deg/s
    assert len(fake.motions) == math.ceil(90.0 / (3.5 * 0.57) / 0.8)
    assert fake.told.index("FRC_SetOverRide") < fake.told.index("FRC_JointMotionJRep")


async def test_an_override_that_the_driver_lowered_comes_back_after_a_refusal():
    fake = FakeController(FRC_JointMotionJRep=refusal(protocol.BAD_POSITION_DATA))
    robot = await connected(fake)
    await robot.set_limits(MotionLimits(1e5, math.radians(2.0)))

    with pytest.raises(TargetRefusedError):
        await robot.move_joints((math.pi / 2, 0.0, 0.0, 0.0, 0.0, 0.0))

    assert fake.overrides == [57, 100]
