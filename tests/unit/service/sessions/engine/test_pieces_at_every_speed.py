"""Whatever a session does, no motion takes longer at once than people are told, at the speed in force."""

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.unit.service.sessions.ballbar import fakes as ballbar
from tests.unit.service.sessions.ballbar.sessions import make_plan as make_ballbar_plan
from tests.unit.service.sessions.contacts import fakes as contacts
from tests.unit.service.sessions.tracker.fakes import IRB120, FakeCell, make_plan, make_stop
from tests.unit.service.sessions.tracker.operators import PatientOperator, run_session
from tests.unit.service.sessions.tracker.test_camera_sessions import CAMERA, SHOWN, FakeCamera
from truepose.domain.robot import FramePlacement
from truepose.domain.session import SessionState
from truepose.messages.catalogue import english
from truepose.sessions.contact.runner import ContactRunner
from truepose.sessions.engine.arm import WallPace
from truepose.sessions.engine.interlocks import motion_notice
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose_drivers.api import MotionGuard, MotionLimits

TOLD = MotionGuard(longest_piece_s=1.0)
PROBE = contacts.planned()
WIRES = replace(
    PROBE, loop="wires", stops=tuple(replace(stop, way_rad=stop.way_rad[-1:]) for stop in PROBE.stops)
)
REDUCED = MotionLimits(20.0, math.radians(3.0))  # of a cell


@pytest.fixture(autouse=True)
def _motions_take_wall_time(monkeypatch):
    """Have the cell keep the time of the wall, as a real one does, although its clock costs none."""
    monkeypatch.setattr(WallPace, "look", lambda pace, cell_s: None)


def duration_s(start, target, speed):
    """How long the flange takes along the straight motion of the joints, looked at closely."""
    chain = nominal_chain(IRB120, FramePlacement(), np.linspace(start, target, 100))
    path_mm = np.linalg.norm(np.diff(chain.origin[-1], axis=0), axis=1).sum()
    turns = np.swapaxes(chain.rotation[-1][:-1], 1, 2) @ chain.rotation[-1][1:]
    angles = np.arccos(np.clip((np.trace(turns, axis1=1, axis2=2) - 1.0) / 2.0, -1.0, 1.0))
    return float(max(path_mm / speed.tool_speed_mm_s, angles.sum() / speed.orientation_speed_rad_s))


def timed(robot):
    """Have a robot ask for pieces; returns a list that each motion is put into: speed, and time [s]."""
    robot.motion_guard, move, motions = TOLD, robot.move_joints, []

    async def noted(target_rad):
        motions.append((robot.limits, duration_s(robot.joints, target_rad, robot.limits)))
        await move(target_rad)

    robot.move_joints = noted
    return motions


async def with_a_tracker(limits):
    cell = FakeCell()
    cell.cell = replace(cell.cell, speed_limits=limits)
    motions = timed(cell.robot)
    return await run_session(cell, make_plan(2)), motions


async def with_a_camera(limits):
    cell = FakeCell()
    cell.cell = replace(
        cell.cell, tracker=FakeCamera(cell), camera=CAMERA, nests=SHOWN, fixed_nests=(), speed_limits=limits
    )
    motions = timed(cell.robot)
    stops = tuple(make_stop(config, 4) for config in (1, 2))
    return await run_session(cell, make_plan(stops=stops, measures="poses")), motions


async def with_a_ballbar(limits):
    bench = ballbar.Bench(make_ballbar_plan((1,), stable_s=0.2, settle_s=0.1), speed_limits=limits)
    bench.robot.motion_s = 0.0
    motions = timed(bench.robot)
    async with bench:
        await bench.start()
        await bench.until(None)
        return await bench.running, motions


def of_closed_loops(plan):
    async def with_gauges(limits):
        bench = contacts.Bench()
        motions = timed(bench.robot)
        bench.robot.joints = (0.6, *bench.robot.joints[1:])  # the first motion comes from anywhere
        runner = ContactRunner(plan, bench.cell(speed_limits=limits), bench.journal)
        return await PatientOperator().attend_from_the_start(runner), motions

    return with_gauges


SESSIONS = {
    "tracker": with_a_tracker,
    "camera": with_a_camera,
    "ballbar": with_a_ballbar,
    "probe": of_closed_loops(PROBE),
    "probe that creeps": of_closed_loops(replace(PROBE, touch_speed_mm_s=1.0)),
    "wires": of_closed_loops(WIRES),
}


@pytest.mark.parametrize("limits", [None, REDUCED], ids=["as planned", "in a slow cell"])
@pytest.mark.parametrize("kind", SESSIONS)
async def test_no_motion_takes_longer_at_once_than_people_are_told(kind, limits):
    state, motions = await SESSIONS[kind](limits)

    assert state is SessionState.FINISHED
    assert "for up to 1 s, longer at less than 100 % override" in english(motion_notice(TOLD))
    # the speed of the flange changes a little between two of the looks along the way
    assert max(took_s for _, took_s in motions) <= 1.05 * TOLD.longest_piece_s
    slow = {speed.tool_speed_mm_s for speed, _ in motions}
    assert len(slow) == (2 if kind.startswith("probe") else 1)
