"""LS programs of FANUC: positions, their frames, and what is left alone."""

import math

import pytest

from tests.helpers.exchange.robot_programs import FANUC, line_of, named, read, reasons
from truepose.exchange.programs.program import AT_THE_ORIGIN, Frame

POSITION = """P[1]{{
   GP1:
\tUF : {frame}, UT : {frame},\t\tCONFIG : 'N U T, 0, 0, 0',
\tX =   100.000  mm,\tY =   200.000  mm,\tZ =   300.000  mm,
\tW =     0.000 deg,\tP =     0.000 deg,\tR =     0.000 deg{more}
}};
"""


def program_of(instruction, frame=1, more=""):
    text = f"/PROG M\n/MN\n   1:{instruction} ;\n/POS\n{POSITION.format(frame=frame, more=more)}/END\n"
    return read("m.ls", text.encode())


def test_a_position_has_its_numbers_branch_and_comment_and_names_its_frames():
    target = named(read("row.ls"), "P[2: approach]")

    assert target.value.position_mm == (-1371.166, 2539.539, -538.77)
    assert target.branch == "N U T, 0, 0, 0"
    assert target.line == line_of(FANUC, b'P[2:"approach"]')
    assert target.tool == Frame("UTOOL 2")
    assert target.work_object == Frame("UFRAME 1")


def test_the_frames_0_are_those_of_the_robot_and_the_one_that_is_in_use_is_not_known():
    (zero,) = program_of("L P[1] 100mm/sec FINE", frame=0).targets
    (in_use,) = program_of("L P[1] 100mm/sec FINE", frame="F").targets

    assert zero.tool == Frame("UTOOL 0", AT_THE_ORIGIN)
    assert zero.work_object == Frame("UFRAME 0", AT_THE_ORIGIN)
    assert (in_use.tool, in_use.work_object) == (None, None)


def test_joint_angles_are_a_configuration_and_other_axes_are_kept():
    target = named(read("row.ls"), "P[1: Höhe]")

    degrees = [math.degrees(angle) for angle in target.value.joints_rad]
    assert degrees == pytest.approx([25, -50, 60, -35, -0.045, 50], abs=1e-12)
    assert target.external == (100.0, 0.0)


@pytest.mark.parametrize(
    ("between", "before"),
    [("DO[1]=ON", 0), ("WAIT .50(sec)", 0), ("!remark", 0), ("CALL GRIP", None), ("AUFRUF GREIF", None)],
)
def test_only_what_runs_straight_on_tells_where_a_motion_begins(between, before):
    program = program_of(f"J P[1] 100% FINE ;\n   2:  {between} ;\n   3:L P[1] 100mm/sec FINE")

    assert [motion.before for motion in program.motions] == [None, before]


def test_a_remark_moves_nothing():
    assert program_of("!L P[1] 100mm/sec FINE INC").left_alone == ()


@pytest.mark.parametrize(
    ("modifier", "words"),
    [
        ("Tool_Offset,PR[2]", "displaced"),
        ("COORD", "coordinated with a group that moves the work"),
        ("Search[X]", "a search motion stops"),
    ],
)
def test_a_motion_that_is_changed_while_it_runs_is_told(modifier, words):
    program = program_of(f"L P[1] 100mm/sec FINE {modifier}")

    assert program.targets == ()
    assert words in reasons(program)[3]


def test_a_program_for_two_arms_is_left_alone():
    second = "\n   GP2:\n\tUF : 0, UT : 1,\n\tX = 1.000 mm, Y = 1.000 mm, Z = 1.000 mm"

    program = program_of("L P[1] 100mm/sec FINE", more=second)

    assert program.targets == ()
    assert reasons(program)[5] == "its second motion group is another arm, which moves with this one"


def test_axes_that_are_lengths_are_no_joint_angles():
    text = "/PROG M\n/MN\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\n\tJ1= 1.000 deg,\tJ2= 2.000 mm\n};\n/END\n"

    assert reasons(read("m.ls", text.encode())) == {4: "one of its joint values is a length"}
