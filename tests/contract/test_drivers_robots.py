"""What a robot driver promises, against the simulated controller."""

import math
from dataclasses import replace

import pytest

from tests.contract.benches import registry
from truepose_drivers.api import DeviceIdentity, MotionGuard, MotionLimits
from truepose_drivers.errors import ConnectionLostError, LinkError, TargetRefusedError
from truepose_simulators.faults.kinds import RobotRefuses

TARGET_RAD = tuple(map(math.radians, (10.0, -20.123456, 15.0, 30.0, 40.0, -50.0)))


@pytest.fixture(params=registry().names("robot"))
async def robot(bench, request):
    robot = bench.driver(request.param)
    await robot.connect()
    await robot.set_limits(MotionLimits())
    return robot


MOTIONS = {
    "abb_open_abb": (False, MotionGuard(longest_piece_s=1.0)),  # before it is known whose server it is
    "abb_rws": (True, MotionGuard(stops_unheard_s=1.0, speed_read_back=True)),
    "fanuc_mappdk": (False, MotionGuard(longest_piece_s=1.0)),
    "fanuc_rmi": (True, MotionGuard(longest_piece_s=0.8, speed_share=1.0)),
    "kuka_variable_proxy": (True, MotionGuard(stops_unheard_s=1.0)),
    "universal_robots": (True, MotionGuard(stops_unheard_s=1.0, speed_read_back=True)),
}
IDENTITIES = {
    "abb_open_abb": ("ABB", "IRB 120-3/0.6", "SIM-1", "5.61.0100"),
    "abb_rws": ("ABB", "IRB 120-3/0.6", "SIM-1", "6.08.01.00"),
    "fanuc_mappdk": ("FANUC", "IRB 120-3/0.6", "SIM-1", "V7.70P"),
    "fanuc_rmi": ("FANUC", "unknown", "unknown", "RMI 9.0"),  # all that the interface tells
    "kuka_variable_proxy": ("KUKA", "#IRB 120-3/0.6", "SIM-1", "KS V8.3.0 (simulated)"),
    "universal_robots": ("Universal Robots", "IRB 120-3/0.6", "SIM-1", "3.15.8.106339"),
}


@pytest.mark.parametrize("name", registry().names("robot"))
async def test_a_driver_says_what_becomes_of_a_motion_and_of_which_robot(bench, name):
    robot = bench.driver(name)
    assert (robot.can_stop_motion, robot.motion_guard) == MOTIONS[name]

    await robot.connect()

    assert await robot.identify() == DeviceIdentity(*IDENTITIES[name])


async def test_the_arm_goes_where_it_is_told(robot):
    await robot.move_joints(TARGET_RAD)
    reading = await robot.read_joints()

    # the protocol's own step, rounded either way; the simulated controller knows no other error
    tolerance_rad = 0.5 * reading.resolution_rad + 1e-7
    assert reading.joints_rad == pytest.approx(TARGET_RAD, abs=tolerance_rad, rel=0.0)


async def test_the_arm_rests_when_the_motion_returns(bench, robot):
    await robot.move_joints(TARGET_RAD)

    assert not bench.cell.robot.moving(bench.cell.clock.now_s)


async def test_a_slower_limit_takes_more_cell_time(bench, robot):
    durations_s = []

    for speed_rad_s in (0.349, 0.1745):
        await robot.set_limits(MotionLimits(tool_speed_mm_s=1e5, orientation_speed_rad_s=speed_rad_s))
        await robot.move_joints((0.0,) * 6)
        start_s = bench.cell.clock.now_s
        await robot.move_joints(TARGET_RAD)
        durations_s.append(bench.cell.clock.now_s - start_s)

    # half the speed takes longer; how much depends on the controller's own ramps
    assert durations_s[1] > 1.5 * durations_s[0] > 0.0


async def test_a_motion_that_cannot_be_made_is_an_error_and_the_link_comes_back(bench, robot):
    bench.cell.scenario = _dropping(bench.cell.scenario)
    bench.cell.faults.add(RobotRefuses(move=1))

    with pytest.raises((TargetRefusedError, LinkError), match="pendant"):
        await robot.move_joints(TARGET_RAD)
    await robot.connect()
    await robot.move_joints(TARGET_RAD)

    assert (await robot.read_joints()).joints_rad == pytest.approx(TARGET_RAD, abs=1e-3)


async def test_a_target_out_of_range_never_passes_in_silence(bench, robot):
    bench.cell.scenario = _dropping(bench.cell.scenario)

    with pytest.raises((TargetRefusedError, ConnectionLostError)):
        await robot.move_joints((math.radians(359.0), 0.0, 0.0, 0.0, 0.0, 0.0))


def _dropping(scenario):
    """The scenario with a controller that drops the connection instead of falling silent."""
    return replace(scenario, arm=replace(scenario.arm, refusal="drop"))
