"""The probe of six degrees of freedom behind the simulated emScon server, in bytes packed by hand."""

import math
import struct

import numpy as np
import pytest

from tests.unit.simulators.instruments.trackers.emscon_server import NO_DISTANCE, OK, Server, answer
from truepose_simulators.cell.robot import SpeedLimits
from truepose_simulators.errors import ScenarioError
from truepose_simulators.faults.kinds import BeamBroken, TrackerBlinded
from truepose_simulators.instruments.accuracy import ProbeSetup
from truepose_simulators.instruments.tracker import in_tracker_frame
from truepose_simulators.physics.rigid import register
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import ToolSetup

STATIONARY_6D = 6
DEGREE, INCH = 1, 5
VALID, ANGLE_OUT_OF_RANGE, DISTANCE_OUT_OF_RANGE = 1, 16, 64


async def server_with(make_cell, probe=None, **changes) -> Server:
    server = Server(make_cell("irb120-probe", probe=probe or ProbeSetup(), **changes))
    await server.start()
    await server.ask(24, struct.pack("<i", STATIONARY_6D))
    return server


def true_pose(cell) -> np.ndarray:
    """The frame of the tool's nests in the tracker's, shape (4, 4)."""
    places = in_tracker_frame(cell.tracker.frame, cell.nests_at_mm(cell.clock.now_s))
    return register(np.array(cell.scenario.tool.nests_mm), places)


def rotation_of(quaternion) -> np.ndarray:
    """As the public ROS client of such trackers computes it: scalar first, columns are the probe's axes."""
    q0, q1, q2, q3 = quaternion
    return np.array([
        [q0**2 + q1**2 - q2**2 - q3**2, 2 * (q1 * q2 - q0 * q3), 2 * (q1 * q3 + q0 * q2)],
        [2 * (q1 * q2 + q0 * q3), q0**2 - q1**2 + q2**2 - q3**2, 2 * (q2 * q3 - q0 * q1)],
        [2 * (q1 * q3 - q0 * q2), 2 * (q3 * q2 + q0 * q1), q0**2 - q1**2 - q2**2 + q3**2],
    ])


def about(axis: int, angle: float) -> np.ndarray:
    turned = np.eye(3)
    i, j = [(1, 2), (2, 0), (0, 1)][axis]
    turned[i, i] = turned[j, j] = math.cos(angle)
    turned[i, j], turned[j, i] = -math.sin(angle), math.sin(angle)
    return turned


async def measured(server) -> tuple[tuple, tuple]:
    """Members of the packet: the whole numbers, then the 41 others."""
    accepted, packet = await server.ask(49)
    assert accepted == answer(49)
    assert struct.unpack_from("<iII", packet) == (376, 4, OK)
    return struct.unpack_from("<9i", packet, 12), struct.unpack_from("<41d", packet, 48)


async def test_a_pose_is_that_of_the_tool_as_the_public_client_reads_it(make_cell):
    server = await server_with(make_cell, noise=False)

    whole, values = await measured(server)

    true = true_pose(server.cell)
    assert whole == (STATIONARY_6D, 0, 0, VALID, 1, 0, 0, 0, 0)
    assert values[:3] == pytest.approx(true[:3, 3], abs=1e-9)
    assert rotation_of(values[17:21]) == pytest.approx(true[:3, :3], abs=1e-12)
    x, y, z = values[21:24]
    assert about(0, x) @ about(1, y) @ about(2, z) == pytest.approx(true[:3, :3], abs=1e-12)


async def test_poses_scatter_as_stated(make_cell):
    server = await server_with(make_cell)
    true = true_pose(server.cell)

    packets = [(await measured(server))[1] for _ in range(200)]

    off_mm = np.array([values[:3] for values in packets]) - true[:3, 3]
    stated_mm = np.array(packets[0][3:6])
    # 200 readings: the scatter is known to 5 %, four of that; the two-face error is 1 um here
    assert off_mm.std(axis=0) == pytest.approx(stated_mm, rel=0.2)
    turns = [rotation_of(values[17:21]) @ true[:3, :3].T for values in packets]
    angles = [math.acos((np.trace(turn) - 1.0) / 2.0) for turn in turns]
    assert math.sqrt(np.mean(np.square(angles))) == pytest.approx(packets[0][27], rel=0.2)
    assert packets[0][27] == pytest.approx(math.sqrt(3.0) * 6e-5)


async def test_poses_are_shown_in_the_units_that_were_set(make_cell):
    server = await server_with(make_cell, noise=False)
    _, in_mm = await measured(server)

    await server.ask(5, struct.pack("<5i", INCH, DEGREE, 0, 0, 0))
    _, shown = await measured(server)

    assert np.array(shown[:17]) * 25.4 == pytest.approx(
        np.array(in_mm[:17]) * np.array([1] * 7 + [1 / 25.4] * 3 + [1] * 4 + [1 / 25.4] * 3)
    )
    assert shown[17:21] == in_mm[17:21]
    assert np.radians(shown[21:28]) == pytest.approx(in_mm[21:28])


async def test_the_probe_turns_with_the_arm(make_cell):
    server = await server_with(make_cell, noise=False)
    _, before = await measured(server)

    joints = np.radians((20.0, 10.0, -10.0, 30.0, 20.0, 40.0))
    await server.cell.move_robot([joints], SpeedLimits(), np.zeros(3))
    _, after = await measured(server)

    assert after[:3] == pytest.approx(true_pose(server.cell)[:3, 3], abs=1e-9)
    assert not np.allclose(before[17:21], after[17:21], atol=0.05)


@pytest.mark.parametrize(
    ("probe", "status"),
    [
        (ProbeSetup(acceptance_deg=1.0, facing=(0.0, 0.0, -1.0)), ANGLE_OUT_OF_RANGE),
        (ProbeSetup(reach_mm=1000.0), DISTANCE_OUT_OF_RANGE),
    ],
)
async def test_a_probe_that_is_out_of_range_is_not_vouched_for(make_cell, probe, status):
    server = await server_with(make_cell, probe)

    whole, _ = await measured(server)

    assert whole[3] & status
    assert not whole[3] & VALID


async def test_a_hidden_probe_is_not_measured_and_found_again(make_cell):
    server = await server_with(make_cell)
    now_s = server.cell.clock.now_s
    server.cell.add_fault(TrackerBlinded(until_s=now_s + 1.0))

    assert await server.ask(49) == [answer(49, NO_DISTANCE)]
    await server.cell.clock.sleep(1.0)

    assert len(await server.ask(49)) == 2


async def test_a_beam_that_breaks_is_an_error_packet_and_the_next_pose_is_good(make_cell):
    server = await server_with(make_cell)
    server.cell.add_fault(BeamBroken(reading=1))

    assert await server.ask(49) == [answer(49), struct.pack("<iIII", 16, 1, 49, NO_DISTANCE)]
    assert len(await server.ask(49)) == 2


async def test_the_probe_and_its_compensations_are_told(make_cell):
    server = await server_with(make_cell)

    (probe,) = await server.ask(103)

    assert struct.unpack_from("<iIIIiiiii", probe) == (356, 0, 103, OK, 1, 1, 4711, 5, 4)
    assert probe[36:100].decode("utf-16-le").rstrip("\0") == "T-Mac"
    for command in (104, 108, 111):
        assert await server.ask(command) == [answer(command, OK, struct.pack("<i", 1))]


async def test_points_are_measured_as_before_once_the_mode_is_that_of_points(make_cell):
    server = await server_with(make_cell)

    await server.ask(24, struct.pack("<i", 0))
    await server.go_to_fixed_nest(1)

    _, result = await server.ask(49)
    assert struct.unpack_from("<iI", result) == (156, 2)


async def test_a_tracker_without_probe_measures_no_poses(make_cell):
    server = Server(make_cell())

    (refused,) = await server.ask(24, struct.pack("<i", STATIONARY_6D))

    assert struct.unpack_from("<III", refused, 4) == (0, 24, 2)


@pytest.mark.parametrize(
    "wrong", [{"rotation_rad": -1.0}, {"acceptance_deg": 0.0}, {"reach_mm": 0.0}, {"facing": (0.0, 0.0, 0.0)}]
)
def test_an_impossible_probe_is_refused(wrong):
    with pytest.raises(ScenarioError, match=next(iter(wrong))):
        ProbeSetup(**wrong)


def test_a_tool_without_three_nests_carries_no_probe(make_cell):
    two = ToolSetup(nests_mm=((0.0, 0.0, 1.0), (1.0, 0.0, 0.0)), facing=((0.0, 0.0, 1.0),) * 2)

    with pytest.raises(ScenarioError, match="give three"):
        Server(make_cell("irb120-probe", tool=two))


def test_the_scenario_file_shows_every_key():
    assert load_scenario("irb120-probe").probe == ProbeSetup()
