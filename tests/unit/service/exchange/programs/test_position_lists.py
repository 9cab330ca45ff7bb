"""Lists of targets: tables, JSON, G-code, INFORM and VAL3."""

import math

import pytest
from scipy.spatial.transform import Rotation

from tests.helpers.exchange.robot_programs import named, read, reasons
from truepose.exchange.programs.formats import read_program
from truepose.exchange.programs.program import AT_THE_ORIGIN, Configuration, Frame

WORLD = Frame("world", AT_THE_ORIGIN)


def test_a_row_is_a_pose_in_the_world_with_its_nominal_answer():
    row = '"x_mm": 1, "y_mm": 2, "z_mm": 3, "qw": 0.7071, "qx": 0, "qy": 0.7071, "qz": 0'
    (target,) = read("n.json", f'[{{{row}, "q1_deg": 10, "q2_deg": 20}}]'.encode()).targets

    assert target.value.position_mm == (1.0, 2.0, 3.0)
    assert target.value.quaternion == pytest.approx((math.sqrt(0.5), 0, math.sqrt(0.5), 0), abs=1e-15)
    assert target.near_rad == pytest.approx((math.radians(10), math.radians(20)), abs=1e-15)


def test_a_row_of_joint_angles_is_a_configuration():
    (target,) = read("n.json", b'[{"q1_deg": 180, "q2_deg": -90}]').targets

    assert target.value == Configuration((math.pi, -math.pi / 2))


def test_an_object_of_json_is_a_row():
    first, second = read("row.json").targets

    assert (first.name, first.line, first.tool) == ("p1 {[", 2, Frame("flange", AT_THE_ORIGIN))
    assert (second.name, second.line, second.tool.name) == ("line 4", 4, "nest 2")
    assert second.value.position_mm == (100.5, 200.0, -3.0)
    assert second.work_object == WORLD


@pytest.mark.parametrize(
    ("angles", "expected"),
    [
        ("zyx", Rotation.from_euler("ZYX", [10, 20, 30], degrees=True)),
        ("xyz", Rotation.from_euler("XYZ", [10, 20, 30], degrees=True)),
        ("fixed xyz", Rotation.from_euler("xyz", [10, 20, 30], degrees=True)),
    ],
)
def test_angles_of_g_code_turn_about_what_is_said(angles, expected):
    (target,) = read_program(b"G1 X1 Y2 Z3 A10 B20 C30\n", "n.nc", angles=angles).targets

    w, x, y, z = target.value.quaternion
    assert (Rotation.from_quat([x, y, z, w]) * expected.inv()).magnitude() < 1e-12


def test_a_block_with_all_words_is_a_target():
    program = read("row.nc")

    assert [target.name for target in program.targets] == ["line 3", "line 4", "line 8"]
    assert program.targets[0].value.position_mm == (10.0, 20.5, 30.0)
    assert program.targets[1].value.position_mm == (11.0, 21.0, 31.0)
    assert [target.work_object for target in program.targets] == [None, None, Frame("G54")]


def test_inches_are_inches_when_read_and_when_written():
    (target,) = read("n.nc", b"G20\nG1 X1 Y-2 Z0.5 A0 B0 C0\n").targets

    assert target.value.position_mm == pytest.approx((25.4, -50.8, 12.7), abs=1e-12)


def test_a_block_behind_a_shifted_zero_is_left_alone():
    program = read("n.nc", b"G92 X0 Y0 Z0\nG1 X1 Y2 Z3 A0 B0 C0\n")

    assert program.targets == ()
    assert reasons(program) == {2: "the zero was shifted in an earlier block"}


def test_a_dwell_is_no_motion():
    assert read("n.nc", b"G1 F100\nG4 X1.5\n").left_alone == ()


def test_a_block_with_variables_is_left_alone():
    assert reasons(read("n.nc", b"G1 X#1 Y2 Z3 A0 B0 C0\n")) == {1: "the position is computed at run time"}


def test_positions_of_a_job_stand_in_their_frames():
    target = named(read("row.jbi"), "C00001")

    assert target.value.position_mm == (1057.372, -422.436, 620.0)
    assert (target.tool, target.work_object) == (Frame("TOOL 1"), Frame("USER 2"))
    assert target.branch == "1,0,0,0,0,0,0,0"


@pytest.mark.parametrize(
    ("file", "name", "expected"),
    [
        ("row.jbi", "C00004", [10, 20, 30, 40, 50, 60]),
        ("row.dtx", "jHome[0]", [0, 10, 90.5, 0, -10, 0]),
    ],
)
def test_angles_of_joints_are_a_configuration(file, name, expected):
    target = named(read(file), name)

    degrees = [math.degrees(angle) for angle in target.value.joints_rad]
    assert degrees == pytest.approx(expected)


def test_the_seventh_axis_of_an_arm_is_no_part_of_a_pose():
    data = b"/JOB\n//POS\n///POSTYPE ROBOT\n///RECTAN\nC0=1,2,3,0,0,0,5\n//INST\nEND\n"

    assert "a seven-axis arm" in reasons(read("m.jbi", data))[5]


def test_points_of_val3_hang_on_frames():
    target = named(read("row.dtx"), "pPick[0]")

    assert target.value.position_mm == (-36.802, -6.159, 500.0)
    assert target.branch == "shoulder lefty, elbow epositive, wrist wpositive"
    assert target.work_object.name == "fPart[0]"
    assert target.work_object.pose.position_mm == (100.0, 0.0, 5.0)


def test_frames_that_hang_on_each_other_have_no_place():
    data = (
        b'<Database><Data name="f" type="frame"><Value key="0" fatherId="f[1]"/>'
        b'<Value key="1" fatherId="f[0]"/></Data>'
        b'<Data name="p" type="pointRx"><Value key="0" x="1" y="2" z="3" rx="0" ry="0" rz="0"'
        b' fatherId="f[0]"/></Data></Database>'
    )

    (target,) = read("m.dtx", data).targets

    assert target.work_object == Frame("f[0]")
