import numpy as np
import pytest

from tests.helpers.reference import reference
from tests.unit.simulators.physics.dh_modified import MASSES, NOMINAL, frames, rotate, shift, torques
from truepose_simulators.cell.environment import CellClock
from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.physics.arm import CarriedMass, place_bodies
from truepose_simulators.physics.loads import gravity_torques, place_masses
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.recording.nominal_tables import NOMINAL_TABLES
from truepose_simulators.scenarios.file import load_scenario

# Positions of about 1e3 mm through some twenty products in double precision.
ROUNDING_MM = 1e-10
TOOL = CarriedMass(6, 2.7, (50.0, 25.0, 100.0))


@pytest.fixture
def joints_rad():
    return np.random.default_rng(3).uniform(-2.5, 2.5, (20, 6))


@pytest.mark.parametrize("name", NOMINAL)
def test_axes_read_off_the_drawing_place_the_flange_where_the_published_table_does(name, joints_rad):
    flanges = nominal_flange(ARMS[name], joints_rad)

    expected = [frames(NOMINAL[name], row)[-1] for row in joints_rad]
    assert flanges == pytest.approx(np.array(expected), abs=ROUNDING_MM)


@pytest.mark.parametrize("name", NOMINAL)
def test_gravity_torques_of_the_nominal_arm_follow_the_published_formula(name, joints_rad):
    no_errors = np.broadcast_to(np.eye(4), (8, 4, 4))

    bodies = place_bodies(ARMS[name], no_errors, joints_rad)
    found = gravity_torques(bodies, place_masses(bodies, ARMS[name].masses, TOOL, ()))

    expected = [torques(NOMINAL[name], MASSES[name], row) for row in joints_rad]
    # Torques of 1e5 N mm from levers that are rounded at 1e-10 mm.
    assert found == pytest.approx(np.array(expected), abs=1e-7)


def test_the_thesis_scenario_is_the_robot_of_its_tables(joints_rad):
    published = reference("thesis_irb120")
    turns = [rotate(axis, np.radians(angle)) for axis, angle in enumerate(published["base_deg"])]
    base = shift(*published["base_mm"]) @ turns[0] @ turns[1] @ turns[2]
    plant = Cell(load_scenario("irb120-thesis"), 1, CellClock(0)).plant

    placed = place_bodies(plant.arm, plant.errors, joints_rad).last_frame

    expected = np.array([frames(published["joints"], row, base)[-1] for row in joints_rad])
    # The scenario states motions with 9 decimals of a mm and rotations with 1e-13 rad, over 1 m.
    assert placed == pytest.approx(expected, abs=1e-8)
    assert plant.compliance_rad_per_n_mm == pytest.approx(published["compliance_rad_per_n_mm"], rel=1e-12)


def test_the_ur10_is_the_arm_of_its_makers_standard_table(joints_rad):
    """d, a [mm] and alpha [rad] of each row; Universal Robots, DH parameters, UR10."""
    maker = [
        (127.3, 0.0, np.pi / 2),
        (0.0, -612.0, 0.0),
        (0.0, -572.3, 0.0),
        (163.941, 0.0, np.pi / 2),
        (115.7, 0.0, -np.pi / 2),
        (92.2, 0.0, 0.0),
    ]

    expected = []
    for row in joints_rad:
        frame = np.eye(4)
        for angle, (d, a, alpha) in zip(row, maker, strict=True):
            frame = frame @ rotate(2, angle) @ shift(a, 0.0, d) @ rotate(0, alpha)
        expected.append(frame)

    assert nominal_flange(ARMS["ur10"], joints_rad) == pytest.approx(np.array(expected), abs=ROUNDING_MM)


def test_the_kr6_is_the_arm_of_its_published_axes(joints_rad):
    published, arm = reference("kr6r900"), ARMS["kr6r900"]
    expected = []
    for row in joints_rad:
        frame = np.eye(4)
        for (step, axis, *_), angle in zip(published["joints"], row, strict=True):
            at = int(np.flatnonzero(axis)[0])
            frame = frame @ shift(*step) @ rotate(at, angle * axis[at])
        expected.append(frame @ rotate(1, np.radians(published["flange_turn_about_y_deg"])))

    assert nominal_flange(arm, joints_rad) == pytest.approx(np.array(expected), abs=ROUNDING_MM)
    assert np.degrees(arm.limits_rad) == pytest.approx(np.array([joint[2] for joint in published["joints"]]))
    speeds = [np.degrees(joint.speed_rad_s) for joint in arm.joints]
    assert speeds == pytest.approx([joint[3] for joint in published["joints"]])


def test_the_ur10_is_loaded_as_its_table_of_masses_says(joints_rad):
    papers, no_errors = NOMINAL_TABLES["ur10"], np.broadcast_to(np.eye(4), (8, 4, 4))

    bodies = place_bodies(ARMS["ur10"], no_errors, joints_rad)
    found = gravity_torques(bodies, place_masses(bodies, ARMS["ur10"].masses, None, ()))

    expected = [torques(papers.rows, papers.masses, row) for row in joints_rad]
    assert found == pytest.approx(np.array(expected), abs=1e-7)
