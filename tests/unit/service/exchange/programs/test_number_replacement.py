"""Only the numbers of targets change, and they are written well enough."""

import math
import random

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from tests.helpers.exchange.robot_programs import PROGRAMS, read, without_numbers
from truepose.exchange.programs.number_replacement import rewritten
from truepose.exchange.programs.program import Configuration, Pose

N_POSES = 1000
FULL_MM = 1e-6  # what a file of full precision may lose
FULL_RAD = 1e-9  # 1e-6 mm at a metre

RAPID_TARGET = "CONST robtarget p{i}:=[[0,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\n"
FANUC_TARGET = """P[{i}]{{
   GP1:
\tUF : 0, UT : 1,\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =     0.000  mm,\tY =     0.000  mm,\tZ =     0.000  mm,
\tW =     0.000 deg,\tP =     0.000 deg,\tR =     0.000 deg
}};
"""
VAL3_TARGET = '<Value key="{i}" x="0" y="0" z="0" rx="0" ry="0" rz="0" fatherId="world[0]" />\n'
JSON_TARGET = '{{"x_mm": 0, "y_mm": 0, "z_mm": 0, "qw": 1, "qx": 0, "qy": 0, "qz": 0}}{comma}\n'
LISTS = {
    "l.mod": ("MODULE M\n", RAPID_TARGET, "ENDMODULE\n"),
    "l.dat": ("DEFDAT L\n", "DECL E6POS P{i}={{X 0,Y 0,Z 0,A 0,B 0,C 0,S 2,T 35}}\n", "ENDDAT\n"),
    "l.ls": ("/PROG L\n/MN\n/POS\n", FANUC_TARGET, "/END\n"),
    "l.script": ("", "movel(p[0,0,0,0,0,0], a=1.2, v=0.25)\n", ""),
    "l.json": ("[", JSON_TARGET, "]"),
    "l.nc": ("", "G1 X0 Y0 Z0 A0 B0 C0\n", ""),
    "l.jbi": (
        "/JOB\n//POS\n///POSTYPE ROBOT\n///RECTAN\n",
        "C{i}=0,0,0,0.0000,0.0000,0.0000\n",
        "//INST\nNOP\nEND\n",
    ),
    "l.dtx": ('<Database><Data name="p" type="pointRx">\n', VAL3_TARGET, "</Data></Database>\n"),
}
COARSE = {"l.ls": (3, 3), "l.jbi": (3, 4)}  # decimals of mm and deg


def list_of(name, n):
    head, target, tail = LISTS[name]
    targets = [target.format(i=i, comma="," if i < n - 1 else "") for i in range(n)]
    return (head + "".join(targets) + tail).encode()


def row(numbers):
    """A list of one target with its numbers as text."""
    keys = ("x_mm", "y_mm", "z_mm", "qw", "qx", "qy", "qz")
    parts = [f'"{key}": {text}' for key, text in zip(keys, numbers.split(","), strict=True)]
    return f"[{{{', '.join(parts)}}}]".encode()


def random_pose(draw):
    quaternion = [draw.gauss(0, 1) for _ in range(4)]
    norm = math.hypot(*quaternion)
    return Pose(tuple(draw.uniform(-3000, 3000) for _ in range(3)), tuple(q / norm for q in quaternion))


def random_poses(n, seed):
    draw = random.Random(seed)
    return {i: random_pose(draw) for i in range(n)}


def turn_between(first, second):
    """Angle [rad] between two orientations; well determined for small ones."""
    w, x, y, z = first
    a, b, c, d = second
    vector = (a * x - b * w - c * z + d * y, a * y + b * z - c * w - d * x, a * z - b * y + c * x - d * w)
    return 2 * math.asin(min(1.0, math.hypot(*vector)))


@pytest.mark.parametrize("name", PROGRAMS)
def test_the_same_numbers_give_the_same_bytes(name):
    program = read(name)

    written = rewritten(program, {i: target.value for i, target in enumerate(program.targets)})

    assert program.targets
    assert written == PROGRAMS[name]


@pytest.mark.parametrize("name", PROGRAMS)
def test_nothing_changes_where_no_target_does(name):
    assert rewritten(read(name), {}) == PROGRAMS[name]


@given(seed=st.integers(0, 2**32), name=st.sampled_from(sorted(PROGRAMS)))
@settings(max_examples=60, deadline=None)
def test_whatever_the_numbers_only_those_of_targets_change(seed, name):
    program = read(name)
    draw = random.Random(seed)
    values = {}
    for index, target in enumerate(program.targets):
        if draw.random() < 0.7:
            match target.value:
                case Pose():
                    values[index] = random_pose(draw)
                case Configuration(joints):
                    values[index] = Configuration(tuple(draw.uniform(-6, 6) for _ in joints))

    again = read(name, rewritten(program, values))

    assert without_numbers(again) == without_numbers(program)
    assert [t.name for t in again.targets] == [t.name for t in program.targets]
    assert [t.branch for t in again.targets] == [t.branch for t in program.targets]
    assert [t.external for t in again.targets] == [t.external for t in program.targets]
    assert again.motions == program.motions
    assert again.left_alone == program.left_alone
    for index in set(range(len(program.targets))) - set(values):
        assert again.targets[index].value == program.targets[index].value


@pytest.mark.parametrize("name", sorted(set(LISTS) - set(COARSE)))
def test_a_thousand_poses_come_back(name):
    program = read(name, list_of(name, N_POSES))
    values = random_poses(N_POSES, seed=7)

    again = read(name, rewritten(program, values))

    assert len(again.targets) == N_POSES
    for index, wanted in values.items():
        found = again.targets[index].value
        assert math.dist(found.position_mm, wanted.position_mm) <= FULL_MM
        assert turn_between(found.quaternion, wanted.quaternion) <= FULL_RAD


@pytest.mark.parametrize("name", COARSE)
def test_a_thousand_poses_come_back_to_the_last_decimal_of_the_format(name):
    program = read(name, list_of(name, N_POSES))
    values = random_poses(N_POSES, seed=8)
    of_mm, of_deg = COARSE[name]

    again = read(name, rewritten(program, values))

    for index, wanted in values.items():
        position, rotation = again.targets[index].written
        assert position.values == tuple(round(value, of_mm) for value in wanted.position_mm)
        w, x, y, z = wanted.quaternion
        angles = Rotation.from_quat([x, y, z, w]).as_euler("xyz", degrees=True)
        other = (angles[0] + 180, 180 - angles[1], angles[2] + 180)
        off = min(
            max(abs(math.remainder(a - b, 360)) for a, b in zip(rotation.values, way, strict=True))
            for way in (angles, other)
        )
        assert off <= 0.5 * 10.0**-of_deg + 1e-9  # rounding, and degrees in doubles
        assert all(number.decimals <= of_deg for number in rotation.numbers)


@pytest.mark.parametrize(
    ("name", "target"),
    [
        ("j.mod", b"MODULE M\nCONST jointtarget j:=[[0,0,0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];\nENDMODULE\n"),
        ("j.src", b"DEF J( )\nPTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}\nEND\n"),
        ("j.script", b"movej([0,0,0,0,0,0])\n"),
        ("j.json", b'[{"q1_deg": 0, "q2_deg": 0, "q3_deg": 0, "q4_deg": 0, "q5_deg": 0, "q6_deg": 0}]'),
        (
            "j.dtx",
            b'<Database><Data name="j" type="joint">'
            b'<Value key="0" j1="0" j2="0" j3="0" j4="0" j5="0" j6="0"/></Data></Database>',
        ),
    ],
)
def test_joint_angles_come_back_to_a_tenth_of_a_nanoradian(name, target):
    program = read(name, target)
    wanted = Configuration((0.1, -1.23456789012, 2.0 / 3.0, -math.pi, 1e-4, math.pi / 7))

    (found,) = read(name, rewritten(program, {0: wanted})).targets

    assert found.value.joints_rad == pytest.approx(wanted.joints_rad, abs=1e-10)


def test_joint_angles_of_a_fanuc_program_have_three_decimals():
    program = read("row.ls")
    wanted = Configuration(
        tuple(math.radians(angle) for angle in (1.23456, -2.5, 0.0004, 3, 4.1235, 5.99999))
    )

    again = read("row.ls", rewritten(program, {0: wanted}))

    assert again.targets[0].written[0].values == (
        1.235,
        -2.5,
        0.0,
        3.0,
        4.123,
        6.0,
    )  # 4.1235 is below in binary
    assert b"J1=    1.235 deg" in again.data
    assert b"J3=    0.000 deg" in again.data


AS_IT_WAS = (1.0, 0.0, 0.0, 0.0)
HALF = math.sqrt(0.5)
NUMBERS = {
    "as many decimals as it had or needs": (
        "1.2000,5,7,1,0,0,0",
        Pose((1.5, 6.0, 7.123456789), AS_IT_WAS),
        "1.5000,6,7.123457,1,0,0,0",
    ),
    "its text where it is the same to its last decimal": (
        "1e2,-0,7,1,0,0,0",
        Pose((100.0000001, 1e-9, 8.0), (1.0, 0.0, 0.0, 1e-15)),
        "1e2,-0,8,1,0,0,0",
    ),
    "no sign where it is zero": ("1,1,1,1,0,0,0", Pose((-1e-9, 1.0, 1.0), AS_IT_WAS), "0,1,1,1,0,0,0"),
    "its text in the same rotation": (
        "1,1,1,0.7071,0,0.7071,0",
        Pose((1.0, 1.0, 1.0), (-HALF, 0.0, -HALF, 0.0)),
        "1,1,1,0.7071,0,0.7071,0",
    ),
    "the sign of its quaternion": (
        "1,1,1,-0.5,-0.5,-0.5,-0.5",
        Pose((2.0, 1.0, 1.0), (0.5, 0.5, 0.5, 0.5)),
        "2,1,1,-0.5,-0.5,-0.5,-0.5",
    ),
}


@pytest.mark.parametrize("kept", NUMBERS)
def test_what_is_written_of_a_number(kept):
    before, pose, after = NUMBERS[kept]

    assert rewritten(read("n.json", row(before)), {0: pose}) == row(after)


def test_a_small_turn_changes_angles_a_little_even_where_they_are_beyond_half_a_turn():
    program = read("n.nc", b"G1 X0 Y0 Z0 A190 B100 C-185\n")
    pose = program.targets[0].value
    x, y, z, w = (Rotation.from_euler("ZYX", [190.01, 100.0, -185.0], degrees=True)).as_quat()

    written = rewritten(program, {0: Pose(pose.position_mm, (w, x, y, z))})

    assert written == b"G1 X0 Y0 Z0 A190.01 B100 C-185\n"


@pytest.mark.parametrize("sign", [1, -1])
def test_a_rotation_vector_beyond_half_a_turn_stays_there(sign):
    program = read("n.script", b"movel(p[0,0,0,0,3.2,0])\n")
    x, y, z, w = sign * Rotation.from_rotvec([0, 3.25, 0]).as_quat()

    written = rewritten(program, {0: Pose((0.0, 0.0, 0.0), (w, x, y, z))})

    assert written == b"movel(p[0,0,0,0,3.25,0])\n"


@pytest.mark.parametrize(
    ("index", "value"),
    [
        (0, Configuration((0.0,) * 6)),
        (1, Configuration((0.0,) * 5)),
        (1, Pose((0.0, 0.0, 0.0), (1.0, 0.0, 0.0, 0.0))),
        (0, Pose((0.0, math.nan, 0.0), (1.0, 0.0, 0.0, 0.0))),
        (0, Pose((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))),
    ],
)
def test_a_value_that_is_no_value_of_the_target_is_refused(index, value):
    program = read("n.script", b"movel(p[0,0,0,0,3.2,0])\nmovej([0,0,0,0,0,0])\n")

    with pytest.raises(ValueError, match=program.targets[index].name):
        rewritten(program, {index: value})
