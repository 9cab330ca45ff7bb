import numpy as np
import pytest

from tests.unit.simulators.physics.circumstances import stops
from truepose_simulators.physics.arm import place_bodies
from truepose_simulators.physics.effects import Deflection
from truepose_simulators.physics.rigid import move
from truepose_simulators.physics.true_robot import NoEquilibriumError, Plant, find_rest

NESTS_MM = np.array([[0.0, 0.0, 125.0], [75.0, 93.675, 215.0], [150.0, 0.0, 125.0]])


def potential_energy_n_mm(plant, angles_rad):
    """Weight times height of every mass, of n configurations."""
    bodies = place_bodies(plant.arm, plant.errors, angles_rad)
    energy = np.zeros(len(angles_rad))
    for mass in plant.arm.masses:
        centre = move(bodies.placements[:, mass.joint], np.array(mass.centre_of_gravity_mm))
        energy += 9.81 * mass.mass_kg * centre[:, 2]
    tool = move(bodies.last_frame, np.array(plant.tool_mass.centre_of_gravity_mm))
    return energy + 9.81 * plant.tool_mass.mass_kg * tool[:, 2]


@pytest.fixture
def plant(make_cell):
    return make_cell("irb120-tilted", seed=5).plant


@pytest.fixture
def joints_rad():
    return np.random.default_rng(7).uniform(-1.5, 1.5, (8, 6))


def test_the_torque_about_every_axis_is_the_slope_of_the_potential_energy(plant, joints_rad):
    step_rad = 1e-4

    rest = find_rest(plant, (), stops(joints_rad))

    for joint in range(6):
        step = step_rad * np.eye(6)[joint]
        ahead = potential_energy_n_mm(plant, rest.angles_rad + step)
        behind = potential_energy_n_mm(plant, rest.angles_rad - step)
        slope = (ahead - behind) / (2 * step_rad)
        # Central difference: h^2/6 of the third derivative, 1e-8/6 * 5e4 N mm, and 1e-16 * 1e5 / h rounding.
        assert rest.torque_n_mm[:, joint] == pytest.approx(-slope, abs=1e-3)


def test_at_rest_gravity_and_springs_have_the_least_energy(plant, joints_rad):
    rest = find_rest(plant, (), stops(joints_rad))
    wound_rad = rest.angles_rad - joints_rad
    spring = 1.0 / plant.compliance_rad_per_n_mm

    def total(angles):
        stored = 0.5 * ((angles - joints_rad) ** 2 * spring).sum(axis=1)
        return stored + potential_energy_n_mm(plant, angles)

    assert np.abs(wound_rad).max() > 1e-4  # the springs do something: more than 0.006 deg
    least = total(rest.angles_rad)
    for step in 1e-5 * np.random.default_rng(1).normal(size=(20, 6)):
        assert (total(rest.angles_rad + step) > least).all()


def test_every_gearbox_winds_up_by_its_compliance_times_the_torque_that_truly_acts(plant, joints_rad):
    rest = find_rest(plant, (), stops(joints_rad))

    wound = plant.compliance_rad_per_n_mm * rest.torque_n_mm
    # The loop ends when torques repeat to 1e-4 N mm; the softest spring makes 1e-10 rad of it.
    assert rest.angles_rad - joints_rad == pytest.approx(wound, abs=1e-10)


def test_torques_of_the_deflected_arm_differ_from_those_of_the_undeflected_one(plant, joints_rad):
    stiff = Plant(plant.arm, plant.motions, np.zeros(6), plant.tool_mass)

    difference = find_rest(plant, (), stops(joints_rad)).torque_n_mm - (
        find_rest(stiff, (), stops(joints_rad)).torque_n_mm
    )

    # Second order of the springs: 1e4 N mm/rad of torque change times 1e-3 rad of deflection.
    assert 1.0 < np.abs(difference).max() < 500.0


def test_the_artefact_is_rigid(plant, joints_rad):
    positions = find_rest(plant, (), stops(joints_rad)).nest_positions(NESTS_MM)

    sides = np.linalg.norm(positions - np.roll(positions, 1, axis=1), axis=2)
    expected = np.linalg.norm(NESTS_MM - np.roll(NESTS_MM, 1, axis=0), axis=1)
    assert sides == pytest.approx(np.broadcast_to(expected, sides.shape), abs=1e-10)


def test_many_configurations_at_once_rest_where_each_rests_alone(plant, joints_rad):
    together = find_rest(plant, (), stops(joints_rad)).nest_positions(NESTS_MM)

    alone = [find_rest(plant, (), stops(row[np.newaxis])).nest_positions(NESTS_MM)[0] for row in joints_rad]
    # A group goes on until its last member has settled: 1e-4 N mm, 1e-10 rad, over 1 m.
    assert together == pytest.approx(np.array(alone), abs=2e-7)


def test_an_arm_of_rubber_finds_no_rest(plant, joints_rad):
    rubber = Plant(plant.arm, plant.motions, np.full(6, 1e-3), plant.tool_mass)

    with pytest.raises(NoEquilibriumError, match="gearboxes are too compliant"):
        find_rest(rubber, (), stops(joints_rad))


class BaseShift:
    """A change of the base after 100 s, written for this test: the port for motions."""

    def deflect(self, conditions, loads):
        motions = np.zeros((len(conditions), 8, 6))
        motions[:, 0, 0] = np.where(conditions.time_s >= 100.0, 0.5, 0.0)
        return Deflection(motions=motions)


def test_an_effect_may_move_base_links_and_tool(plant, joints_rad):
    times = np.where(np.arange(8) < 4, 0.0, 100.0)
    before = find_rest(plant, (), stops(joints_rad)).nest_positions(NESTS_MM)

    after = find_rest(plant, (BaseShift(),), stops(joints_rad, time_s=times)).nest_positions(NESTS_MM)

    assert after[:4] == pytest.approx(before[:4], abs=2e-7)
    moved = after[4:] - before[4:]
    assert moved == pytest.approx(np.broadcast_to([0.5, 0.0, 0.0], moved.shape), abs=2e-7)
