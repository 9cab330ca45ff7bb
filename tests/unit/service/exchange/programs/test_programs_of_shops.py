"""What every reader says of the program of its language that shops have: motions, turns, what it leaves."""

import pytest
from scipy.spatial.transform import Rotation

from tests.helpers.exchange.robot_programs import PROGRAMS, line_of, named, read, reasons

CHOSEN = "the array element is selected at run time"
UNTRACED = "how this statement uses the target cannot be traced"
ARC = "an arc passes through points that are not targets"
RELATIVE = "the motion is relative to the robot's current position"
LEFT = {
    "row.mod": {
        b"MoveJ Offs(pPick": "the position is computed at run time; corrected in the file: pPick",
        b"MoveL pRow{i}": f"{CHOSEN}; corrected in the file: pRow{{1}}, pRow{{2}}",
        b"MoveL pNow": "the position is computed at run time",
        b"MoveC pPick,pRow{2}": f"{ARC}; corrected in the file: pPick, pRow{{2}}",
        b"MoveL *": "the target is not written out (*)",
        b"place pPick": f"{UNTRACED}; corrected in the file: pPick",
        b"MoveL pWhere": "the target is an argument of the routine",
        b"MoveL pElsewhere": "the target is not declared in this file",
        b"robtarget pShift": "the program changes the target in line 31",
        b"pShift.trans.z:=": "the position is computed at run time",
    },
    "row.src": {
        b"PTP XP1": "the target is not declared in this file",
        b"LIN PTS[2]:OFFS": "the position is computed at run time; corrected in the file: PTS[2]",
        b"LIN PTS[I]": f"{CHOSEN}; corrected in the file: PTS[1], PTS[2]",
        b"LIN {X 100}": "the target does not state Y, Z, A, B, C; these keep their previous values",
        b"LIN_REL": RELATIVE,
        b"CIRC PTS[1],PTS[2]": f"{ARC}; corrected in the file: PTS[1], PTS[2]",
        b"LIN HERE": "the position is computed at run time",
        b"MOVEIT(": f"{UNTRACED}; corrected in the file: PTS[1]",
    },
    "row.dat": {
        b"E6POS XP2": "the robot holds the workpiece and the tool is stationary",
    },
    "row.ls": {
        b"CNT50 Offset,PR[1]": "the target is displaced at run time; corrected in the file: P[2: approach]",
        b"C P[3]": ARC,
        b"L PR[1]": "its position register is not in the file",
        b"L P[R[1]]": CHOSEN,
        b"L P[8]": "the target is not declared in this file",
        b"FINE INC": f"{RELATIVE}; corrected in the file: P[2: approach]",
        b"P[5]{": "the target was never taught",
        b"P[7]{": "the program changes the target in line 20",
    },
    "row.script": {
        b"movel(pose_trans": "the position is computed at run time; corrected in the file: pts[0], pts[1]",
        b"movel(pts[i])": f"{CHOSEN}; corrected in the file: pts[0], pts[1]",
        b"d2r(5)": "the position is computed at run time",
        b"movec(": f"{ARC}; corrected in the file: pts[0], pts[1]",
        b"movel(other)": "the target is not declared in this file",
        b"servoj(": "the motion is controlled at run time",
        b"grip(": f"{UNTRACED}; corrected in the file: pts[0], pts[1]",
    },
    "row.json": {},
    "row.nc": {
        b"N40": "the target does not state Y, Z, A, B, C; these keep their previous values",
        b"N50": ARC,
        b"N90": RELATIVE,
        b"G28": "this statement moves to a fixed position of the machine",
    },
    "row.jbi": {
        b"C00000=-1": "its values are in pulses, and the job does not state the number of pulses per degree",
        b"MOVL C00002 V=100.0": "the target is displaced at run time",
        b"MOVL P[I000]": CHOSEN,
        b"IMOV P003": f"{RELATIVE}; corrected in the file: P00003",
        b"MOVC C00002": ARC,
    },
    "row.dtx": {
        b'key="1" x="5"': "the target does not state y, z, rx, ry, rz",
    },
}


@pytest.mark.parametrize("name", LEFT)
def test_what_numbers_cannot_correct_is_left_alone_and_told_once(name):
    program = read(name)

    assert reasons(program) == {line_of(PROGRAMS[name], text): reason for text, reason in LEFT[name].items()}
    assert len(program.left_alone) == len(LEFT[name])


MOTIONS = {
    "row.mod": [
        ("jHome", "joints", None),
        ("pPick", "line", None),  # behind Offs
        ("line 23", "line", "pPick"),  # an output between does not move the robot
        ("pRow{1}", "line", None),  # behind the loop
        ("pRow{2}", "line", "pRow{1}"),
    ],
    "row.src": [
        ("HOME", "joints", None),
        ("PTS[1]", "line", None),  # behind a point of another file
        ("PTS[2]", "line", None),  # behind a computed one
        ("line 25", "joints", None),
        ("line 27", "line", None),
    ],
    "row.ls": [
        ("P[1: Höhe]", "joints", None),
        ("P[2: approach]", "line", None),  # behind an offset
        ("P[6]", "line", "P[2: approach]"),
        ("P[6]", "line", None),  # behind a jump
    ],
    "row.script": [
        ("Waypoint_1_p", "joints", None),
        ("pts[0]", "line", "Waypoint_1_p"),
        ("line 19", "joints", None),
    ],
    "row.nc": [("line 3", "joints", None), ("line 4", "line", "line 3"), ("line 8", "line", None)],
    "row.jbi": [("C00001", "line", None), ("P00003", "line", "C00001"), ("C00004", "joints", "P00003")],
    "row.json": [],  # a list tells no order
}


@pytest.mark.parametrize("name", MOTIONS)
def test_motions_follow_each_other_as_far_as_the_text_is_straight(name):
    program = read(name)
    names = [target.name for target in program.targets]

    told = [(names[m.target], m.path, None if m.before is None else names[m.before]) for m in program.motions]

    assert told == MOTIONS[name]


@pytest.mark.parametrize(
    ("name", "target", "expected"),
    [
        ("row.dat", "XP1", Rotation.from_euler("ZYX", [6.59456158, -23.4313526, 9.77940178], degrees=True)),
        ("row.ls", "P[2: approach]", Rotation.from_euler("xyz", [-175.187, -34.176, 8.232], degrees=True)),
        ("row.script", "Waypoint_1_p", Rotation.from_rotvec([1.500318891221, 0.521427297251, 0.530987])),
        ("row.jbi", "C00001", Rotation.from_euler("xyz", [-179.9371, 0.0009, -0.0221], degrees=True)),
        ("row.dtx", "pPick[0]", Rotation.from_euler("XYZ", [135.407, 80.416, 46.453], degrees=True)),
    ],
)
def test_a_rotation_turns_about_the_axes_of_its_language(name, target, expected):
    w, x, y, z = named(read(name), target).value.quaternion

    assert (Rotation.from_quat([x, y, z, w]) * expected.inv()).magnitude() < 1e-12


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("m.mod", "MODULE M\nPROC main()\nSetDO do1,1;\nENDPROC\nENDMODULE\n"),
        ("m.src", "DEF M( )\n$OUT[1]=TRUE\nWAIT SEC 1.0\nEND\n"),
        ("m.ls", "/PROG M\n/MN\n   1:  DO[1]=ON ;\n/POS\n/END\n"),
        ("m.script", "def m():\ntextmsg('movej([0,0,0,0,0,0])')\n# movej([0,0,0,0,0,0])\nend\n"),
    ],
)
def test_a_program_without_targets_has_none(name, text):
    program = read(name, text.encode())

    assert (program.targets, program.motions, program.left_alone) == ((), (), ())
