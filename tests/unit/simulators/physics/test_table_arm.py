import numpy as np
import pytest

from tests.unit.simulators.physics.dh_modified import MASSES, NOMINAL, frames, rotate, shift, torques
from truepose_simulators.cell.robot import nominal_flange
from truepose_simulators.physics.arm import link_motions, place_bodies
from truepose_simulators.physics.loads import gravity_torques, place_masses
from truepose_simulators.physics.robots import ARMS
from truepose_simulators.physics.table_arm import (
    ArmTable,
    FrameMass,
    RowErrors,
    TableRow,
    draw_arm,
    link_motion,
)

# Positions of about 1e3 mm through some twenty products in double precision.
ROUNDING_MM = 1e-10


def table_of(name, rows=None, masses=()):
    stated = NOMINAL[name] if rows is None else rows
    return ArmTable(
        name=name,
        rows=tuple(
            TableRow(np.radians(alpha), a, np.radians(offset), d, *(sign or (1,)))
            for alpha, a, offset, d, *sign in stated
        ),
        masses=tuple(FrameMass(frame, kg, centre) for frame, kg, centre in masses),
        limits_rad=None,
        calibration_rad=None,
        gear_ratio=None,
        typical_compliance_rad_per_n_mm=None,
    )


@pytest.fixture
def joints_rad():
    return np.random.default_rng(3).uniform(-2.5, 2.5, (20, 6))


@pytest.mark.parametrize("name", NOMINAL)
def test_an_arm_drawn_from_its_table_is_the_arm_read_off_the_drawing(name, joints_rad):
    drawn, read = draw_arm(table_of(name)), ARMS[name]

    assert nominal_flange(drawn, joints_rad) == pytest.approx(nominal_flange(read, joints_rad), abs=1e-9)
    for ours, theirs in zip(drawn.joints, read.joints, strict=True):
        assert ours.direction == pytest.approx(theirs.direction, abs=1e-12)
        assert ours.point_mm == pytest.approx(theirs.point_mm, abs=1e-9)


@pytest.mark.parametrize("name", NOMINAL)
def test_its_masses_load_the_joints_as_the_published_formula_says(name, joints_rad):
    arm = draw_arm(table_of(name, masses=MASSES[name]))
    no_errors = np.broadcast_to(np.eye(4), (8, 4, 4))

    bodies = place_bodies(arm, no_errors, joints_rad)
    found = gravity_torques(bodies, place_masses(bodies, arm.masses, None, ()))

    expected = [torques(NOMINAL[name], MASSES[name], row) for row in joints_rad]
    assert found == pytest.approx(np.array(expected), abs=1e-7)  # levers rounded at 1e-10 mm


def test_a_joint_that_counts_backwards_turns_the_other_way(joints_rad):
    signs = np.array([1, -1, 1, -1, -1, 1])
    rows = [(*row, int(sign)) for row, sign in zip(NOMINAL["irb120"], signs, strict=True)]

    backwards = nominal_flange(draw_arm(table_of("irb120", rows)), joints_rad * signs)

    forwards = nominal_flange(draw_arm(table_of("irb120")), joints_rad)
    assert backwards == pytest.approx(forwards, abs=ROUNDING_MM)


@pytest.mark.parametrize("sign", [1, -1])
def test_link_motions_are_the_errors_of_the_rows_however_large(joints_rad, sign):
    rows = [(*row, sign) for row in NOMINAL["lrmate200ic"]]
    table = table_of("lrmate200ic", rows)
    rng = np.random.default_rng(5)
    errors = [RowErrors(*(rng.standard_normal(5) * (0.1, 20.0, 0.1, 0.1, 20.0))) for _ in rows]
    motions = np.zeros((8, 6))
    motions[1:7] = [link_motion(row, error) for row, error in zip(table.rows, errors, strict=True)]
    arm = draw_arm(table)

    placed = place_bodies(arm, link_motions(arm, motions), joints_rad).last_frame

    expected = [row_by_row(table.rows, errors, sign * angles) for angles in joints_rad]
    assert placed == pytest.approx(np.array(expected), abs=ROUNDING_MM)


def row_by_row(rows, errors, turns_rad):
    """RotX TransX RotY RotZ TransZ, nominal and erroneous quantities added up."""
    frame = np.eye(4)
    for row, error, turn in zip(rows, errors, turns_rad, strict=True):
        frame = frame @ rotate(0, row.alpha_rad + error.alpha_rad) @ shift(row.a_mm + error.a_mm, 0, 0)
        frame = frame @ rotate(1, error.beta_rad) @ rotate(2, turn + row.offset_rad + error.theta_rad)
        frame = frame @ shift(0, 0, row.d_mm + error.d_mm)
    return frame


def test_row_by_row_without_errors_is_the_published_table(joints_rad):
    rows, no_errors = table_of("irb120").rows, [RowErrors()] * 6

    expected = frames(NOMINAL["irb120"], joints_rad[0])[-1]

    assert row_by_row(rows, no_errors, joints_rad[0]) == pytest.approx(expected, abs=ROUNDING_MM)


def test_what_no_table_states_limits_nothing():
    arm = draw_arm(table_of("irb120"))

    assert arm.limits_rad == pytest.approx(np.tile([-2 * np.pi, 2 * np.pi], (6, 1)))
    assert arm.gear_ratio == (np.inf,) * 6
