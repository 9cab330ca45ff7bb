"""Table 2.3 of the thesis (A. Nubiola, 2014) on the simulated robot: the same joints err by as much."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.circles import points_of, there_and_back, turned
from truepose.validation.circle_test import circle_test
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.recording import RecordingRequest
from truepose_simulators.recording.campaign import record_at
from truepose_simulators.recording.plan import Stops
from truepose_simulators.scenarios.file import load_scenario
from truepose_simulators.scenarios.scenario import ToolSetup

_SWEEPS_DEG = {
    1: (-60, 60, 5),
    2: (-40, 40, 1),
    3: (-40, 40, 1),
    4: (-155, 155, 5),
    5: (-90, 90, 5),
    6: (-400, 400, 1),
}
# Printed there: tangential range [mm], angular range [deg], backlash [deg].
_TABLE_2_3 = {
    1: (0.114, 0.013, 0.004),
    2: (1.363, 0.116, 0.002),
    3: (0.912, 0.098, 0.004),
    4: (0.445, 0.207, 0.037),
    5: (0.606, 0.153, 0.017),
    6: (0.156, 0.072, 0.037),
}
# The end-effector of the table, and the only reflector on it.
_TOOL = ToolSetup(
    nests_mm=((-114.4, -46.2, 124.5),),
    facing=((1.0, 0.0, 0.0),),
    mass_kg=2.75,
    centre_of_gravity_mm=(-31.0, -13.0, 85.0),
)


@pytest.fixture(scope="module")
def circles():
    angles = {joint: there_and_back(*sweep) for joint, sweep in _SWEEPS_DEG.items()}
    joints = np.vstack([turned(joint, one) for joint, one in angles.items()])
    # Every joint comes to its lower end from 0, downwards.
    step = [turned(joint, np.sign(np.diff(one, prepend=one[0] + 1))) for joint, one in angles.items()]
    direction = np.sign(np.vstack(step))
    n = len(joints)
    stops = Stops(
        np.degrees(joints),
        direction,
        7.0 * np.arange(n),
        np.ones(n),
        np.ones(n, dtype=np.int64),
        np.zeros(n, dtype=np.int64),
    )
    scenario = replace(load_scenario("irb120-everyday"), tool=_TOOL)
    cell = Cell(scenario, 1, CellClock(0))
    recorded, _ = record_at(cell, stops, RecordingRequest(configurations=n, validation=0))
    read = recorded.calibration.readings
    points = points_of(joints, read.position_mm, read.u_mm.mean(), direction=direction.astype(np.int64))
    test = circle_test(points)
    assert test.withheld == ()
    return {one.joint: one for one in test.circles}


def test_the_errors_of_every_joint_are_as_large_as_in_the_table(circles):
    for joint, (tangential_mm, angular_deg, backlash_deg) in _TABLE_2_3.items():
        one = circles[joint]
        seen = (
            one.tangential_range_mm.value / tangential_mm,
            np.degrees(one.angular_range_rad.value) / angular_deg,
            np.degrees(one.backlash_rad.value) / backlash_deg,
        )
        # Another arm of the same type: of one size means within a factor of three. Joint 6 of this one has
        # errors of its own, on top of the springs of joints 4 and 6 (see the test of a sagging arm).
        most = 5.0 if joint == 6 else 3.0
        assert all(1.0 / 3.0 < ratio < most for ratio in seen), (joint, seen)


def test_the_joints_stand_in_the_order_of_the_table(circles):
    """Joints 2, 3 and 5 err most on their circles, by gravity; 1 and 6 least; the wrist has the backlash."""
    tangential = {joint: one.tangential_range_mm.value for joint, one in circles.items()}
    gap = {joint: one.backlash_rad.value for joint, one in circles.items()}

    assert min(tangential[joint] for joint in (2, 3, 5)) > max(tangential[joint] for joint in (1, 4, 6))
    assert tangential[4] > tangential[6]
    assert min(gap[joint] for joint in (4, 5, 6)) > 2.0 * max(gap[joint] for joint in (1, 2, 3))


def test_radial_and_axial_errors_are_smaller_than_the_tangential_ones(circles):
    for joint in (2, 3, 5):
        one = circles[joint]
        assert max(one.radial_range_mm, one.axial_range_mm) < 0.6 * one.tangential_range_mm.value
    # 0.050 mm in the thesis; the simulated tracker scatters by 0.0156 mm per axis.
    assert np.std(circles[1].errors.radial_mm) < 0.03
