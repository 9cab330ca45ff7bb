"""What a robot states of its joints, against the ranges of the robot of this cell."""

import math
from dataclasses import replace

import pytest

from tests.unit.service.sessions.tracker.fakes import make_plan
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from truepose.domain.robot import JointRange
from truepose.domain.session import SessionState
from truepose.sessions.engine.robot import WatchfulRobot
from truepose_drivers.api import JointReading, MotionGuard
from truepose_drivers.errors import ImplausibleReadingError

RANGES = (JointRange(math.radians(-110.0), math.radians(70.0)),) * 6


class Controller:
    connected = True
    can_stop_motion = False
    motion_guard = MotionGuard(longest_piece_s=0.5)

    def __init__(self, *joints_deg: float) -> None:
        self._joints_rad = tuple(map(math.radians, joints_deg))

    async def read_joints(self) -> JointReading:
        return JointReading(self._joints_rad, 1e-4, 0.0)


@pytest.mark.parametrize("joint_deg", [-111.0, 0.0, 71.0])
async def test_a_joint_within_its_range_is_taken(joint_deg):
    robot = WatchfulRobot(Controller(0.0, joint_deg, 0.0, 0.0, 0.0, 0.0), RANGES)

    assert (await robot.read_joints()).joints_rad[1] == math.radians(joint_deg)


@pytest.mark.parametrize("joint_deg", [-111.1, 71.1, 700.0, math.nan])
async def test_a_joint_where_this_robot_has_none_is_no_reading(joint_deg):
    robot = WatchfulRobot(Controller(0.0, joint_deg, 0.0, 0.0, 0.0, 0.0), RANGES)

    with pytest.raises(ImplausibleReadingError, match=r"joint 2 .* from -110 to 70 deg"):
        await robot.read_joints()


async def test_a_robot_of_unknown_ranges_is_believed():
    assert await WatchfulRobot(Controller(700.0), None).read_joints()


def test_what_the_driver_says_of_its_motions_is_reached():
    assert WatchfulRobot(Controller(0.0), None).motion_guard == Controller.motion_guard


async def test_a_joint_out_of_range_has_the_session_wait_for_a_person(cell):
    a_turn = (JointRange(-2.0 * math.pi, 2.0 * math.pi),) * 6
    cell.cell = replace(cell.cell, robot_controller=WatchfulRobot(cell.robot, a_turn))
    read = cell.robot.read_joints
    wrong = []

    async def read_wrong_once() -> JointReading:
        reading = await read()
        if len(cell.journal.points) == 1 and not wrong:
            wrong.append(True)
            return JointReading((*reading.joints_rad[:5], 10.0), reading.resolution_rad, reading.time_s)
        return reading

    cell.robot.read_joints = read_wrong_once
    operator = PatientOperator()

    ended = await run_session(cell, make_plan(2), operator)

    assert ended is SessionState.FINISHED
    assert "joint 6" in operator.questions[1]
    assert [point.config for point in cell.journal.points] == [1, 2]
