"""What the arm sends at once, through all that a session puts around a driver, against what is told."""

import math
from dataclasses import replace
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest

from tests.contract.benches import Bench, registry
from tests.unit.service.sessions.contacts.fakes import CELL
from tests.unit.service.sessions.stand_ins import nothing_in_the_way
from tests.unit.service.sessions.tracker.fakes import IRB120, FakeClock
from truepose.domain.cell import Camera, DeviceEntry
from truepose.domain.robot import FramePlacement, JointRange
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.ballbar.service import BallbarSessions
from truepose.sessions.contact.service import ContactSessions
from truepose.sessions.devices import DeviceRegistry, MountedDevice
from truepose.sessions.engine.arm import Arm, Permission
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose.sessions.engine.ways import KnownWays
from truepose.sessions.service import SessionService
from truepose.sessions.tracker.service import TrackerSessions
from truepose.storage.records import SessionSetup
from truepose_drivers.api import JointReading, MotionGuard, MotionLimits
from truepose_drivers.guard import guarded

SLOW = MotionLimits(20.0, math.radians(3.0))
START = (0.0, 0.1, -0.2, 0.0, 0.3, 0.0)
TARGET = (0.8, 0.5, -0.4, 1.0, 0.3, -1.5)
WIDE = (JointRange(-7.0, 7.0),) * 6
CAMERA = Camera((2200.0, 0.0, 900.0), (0.0, 0.0, 0.0), 4, 0.032, 4.7e-4, 4.2e-4)
SETUPS = {
    "tracker": SessionSetup(CELL),
    "camera": SessionSetup(replace(CELL, camera=CAMERA)),
    "ballbar": SessionSetup(CELL),
    "contacts": SessionSetup(CELL),
}
ADDRESS = {"host": "127.0.0.1", "port": 9}
DRIVERS = {
    **{name: (name, ADDRESS) for name in registry().names("robot")},
    "abb_open_abb with a long tool": ("abb_open_abb", {**ADDRESS, "tool_mm": "150 0 400"}),
    "abb_open_abb read by EGM": ("abb_open_abb", {**ADDRESS, "egm_port": 6510}),
    "abb_open_abb watched by web services": ("abb_open_abb", {**ADDRESS, "rws_port": 9}),
    "abb_rws read by EGM": ("abb_rws", {**ADDRESS, "egm_port": 6510}),
}


def unconnected(named):
    """Return a driver behind its guard that nobody has asked anything."""
    name, options = DRIVERS[named]
    known = registry().plugin(name).options
    return registry().open(name, {key: value for key, value in options.items() if key in known})


def recorded(robot):
    """Have the driver itself, behind everything, note what it is sent, as a robot that arrives at once."""
    driver = robot._device

    class Recorded(type(driver)):
        connected = True

        async def move_joints(self, target_rad):
            self.sent.append(target_rad)

        async def set_limits(self, limits):
            self._limits = limits

        async def read_joints(self):
            return JointReading(self.sent[-1], 1e-4, self.time_s())

    driver.__class__ = Recorded
    driver.sent = [START]
    return driver


def rack_of(robot, clock):
    """Return a rack with this robot, and devices of every other kind that a session may want."""
    others = {kind: guarded("acme", kind, SimpleNamespace()) for kind in KINDS_BESIDE}
    mounted = [
        MountedDevice(DeviceEntry(kind, "any", {}), kind, "any", device)
        for kind, device in {"robot": robot, **others}.items()
    ]
    return DeviceRegistry(mounted, clock)


KINDS_BESIDE = ("tracker", "pose_tracker", "ballbar", "linear_gauge")


def cell_of(kind, rack, present=None):
    """Return the cell that a session of this kind is run on."""
    desk = SessionService(None, None, rack, present)
    sessions = {
        "tracker": lambda: TrackerSessions(desk, None, None)._cell(SETUPS[kind], SLOW, first_pass=False),
        "camera": lambda: TrackerSessions(desk, None, None)._cell(SETUPS[kind], SLOW, first_pass=False),
        "ballbar": lambda: BallbarSessions(desk, None, None)._cell(SETUPS[kind], SLOW),
        "contacts": lambda: ContactSessions(desk)._cell(SETUPS[kind], SLOW),
    }
    return sessions[kind]()


def duration_s(start, target, tool_mm=(0.0, 0.0, 0.0)):
    """How long a point of the tool takes along the straight motion of the joints, looked at closely."""
    chain = nominal_chain(IRB120, FramePlacement(), np.linspace(start, target, 400))
    path_mm = np.linalg.norm(np.diff(chain.points(np.array(tool_mm)), axis=0), axis=1).sum()
    turns = np.swapaxes(chain.rotation[-1][:-1], 1, 2) @ chain.rotation[-1][1:]
    angles = np.arccos(np.clip((np.trace(turns, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
    return float(max(path_mm / SLOW.tool_speed_mm_s, angles.sum() / SLOW.orientation_speed_rad_s))


async def moved(robot, driver, speed):
    """Move far; returns the motions that arrive at the driver."""
    clock = FakeClock()
    driver.time_s = lambda: clock.time_s
    allowed = Permission(SessionState.RUNNING, stop_requested=False, question=None)
    arm = Arm(
        robot,
        clock,
        IRB120,
        WIDE,
        0.00035,
        lambda now_s: allowed,
        KnownWays(nothing_in_the_way),
        wall_s=lambda: clock.time_s,
    )
    await arm.set_limits(speed)
    await arm.move(TARGET)
    assert driver.sent[-1] == TARGET
    return tuple(pairwise(driver.sent))


async def require_told(kind, robot):
    """Assert that the arm sends what people are told; returns what it sent at once, and what was told."""
    driver = recorded(robot)
    offered = driver.motion_guard
    rack = rack_of(robot, FakeClock())
    in_cell = cell_of(kind, rack).robot_controller
    before = rack.motion_notice
    rack.lend(1, in_cell)

    motions = await moved(in_cell, driver, SLOW)
    longest_s = max(duration_s(start, end, offered.speed_point_mm) for start, end in motions)

    assert in_cell.motion_guard == offered != MotionGuard()
    assert rack.motion_notice == before
    if offered.longest_piece_s is None:
        assert len(driver.sent) == 2
        assert f"stops the arm by itself within {offered.stops_unheard_s:g} s" in english(before)
    else:
        told = f"for up to {offered.longest_piece_s:g} s"
        known = ", longer if the override" if offered.speed_share else ", longer at less than 100 % override"
        assert told + known in english(before)
        # the speed of the flange changes a little between two of the looks along the way
        assert longest_s <= 1.05 * offered.longest_piece_s
    return longest_s, len(driver.sent) - 1, before


@pytest.mark.parametrize("kind", SETUPS)
@pytest.mark.parametrize("named", DRIVERS)
async def test_of_a_controller_that_has_not_said_who_it_is_the_arm_sends_what_people_are_told(named, kind):
    await require_told(kind, unconnected(named))


@pytest.mark.parametrize("kind", SETUPS)
@pytest.mark.parametrize("name", registry().names("robot"))
async def test_of_a_controller_that_answers_the_arm_sends_what_people_are_told(name, kind):
    bench = Bench("socket")
    await bench.listen()
    try:
        robot = bench.driver(name)
        await robot.connect()
        await robot.identify()
        await require_told(kind, robot)
    finally:
        await bench.close()


def turned_down(driver):
    """Have the controller tell, from the fourth motion on, that somebody has set its override to 25 %."""
    if hasattr(driver, "_companion"):
        driver._companion._speed_percent = 25.0
    else:
        driver._override_percent = 25


@pytest.mark.parametrize("kind", SETUPS)
@pytest.mark.parametrize("named", ["fanuc_rmi", "abb_open_abb watched by web services"])
async def test_an_override_that_is_turned_down_on_the_way_shortens_what_is_sent_from_then_on(named, kind):
    robot = unconnected(named)
    driver = recorded(robot)
    in_cell = cell_of(kind, rack_of(robot, FakeClock())).robot_controller
    move, guard = type(driver).move_joints, driver.motion_guard

    async def moved_and_turned_down(self, target_rad):
        await move(self, target_rad)
        if len(self.sent) == 4:
            turned_down(self)

    type(driver).move_joints = moved_and_turned_down
    motions = await moved(in_cell, driver, SLOW)

    times_s = [
        max(duration_s(start, end, guard.speed_point_mm), guard.takes_s(start, end) if guard.takes_s else 0.0)
        for start, end in motions
    ]
    assert in_cell.motion_guard.speed_share == 0.25
    # the speed of the flange changes a little between two of the looks along the way
    assert max(times_s[:3]) <= 1.05 * guard.longest_piece_s
    assert max(times_s[3:]) <= 1.05 * guard.longest_piece_s * 0.25


@pytest.mark.parametrize("kind", SETUPS)
@pytest.mark.parametrize("name", ["fanuc_mappdk", "fanuc_rmi"])
async def test_a_controller_that_goes_more_slowly_than_it_may_is_sent_shorter_pieces(name, kind):
    robot = unconnected(name)
    driver = recorded(robot)
    in_cell = cell_of(kind, rack_of(robot, FakeClock())).robot_controller

    motions = await moved(in_cell, driver, MotionLimits(250.0, math.radians(20.0)))

    guard = driver.motion_guard
    assert max(guard.takes_s(start, end) for start, end in motions) <= 1.001 * guard.longest_piece_s
