"""A program of several files: what the others tell of the targets of one."""

import pytest

from tests.helpers.exchange.robot_programs import KRL, KRL_DATA, named, reasons, without_numbers
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.programs.formats import read_program
from truepose.exchange.programs.number_replacement import rewritten
from truepose.exchange.programs.program import Frame, Motion, Pose
from truepose.messages.catalogue import english

POINTS = b"""DEFDAT ROW
DECL E6POS P1={X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0,S 2,T 3}
DECL E6POS P2={X 4.0,Y 5.0,Z 6.0,A 0.0,B 0.0,C 0.0,S 2,T 3}
ENDDAT
"""
TOOLS = b"""MODULE Tools(SYSMODULE)
  PERS tooldata tGrip:=[TRUE,[[0,0,100],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];
  CONST robtarget pHere:=[[9,9,9],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
ENDMODULE
"""
PICK = b"""MODULE Pick
  CONST robtarget pPick:=[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];
  PROC main()
    MoveJ pHere,v100,fine,tGrip;
    MoveL pPick,v100,fine,tGrip;
  ENDPROC
ENDMODULE
"""


def points(*lines):
    return read_program(
        POINTS, "row.dat", beside={"row.src": b"\n".join([b"DEF ROW( )", *lines, b"END", b""])}
    )


def test_the_program_tells_how_the_points_of_a_data_list_are_used():
    program = points(b"$TOOL=TOOL_DATA[1]", b"$BASE=BASE_DATA[2]", b"PTP P1", b"LIN P2")

    assert [(t.tool, t.work_object) for t in program.targets] == [
        (Frame("TOOL_DATA[1]"), Frame("BASE_DATA[2]"))
    ] * 2
    assert program.motions == (
        Motion(4, 0, "joints", None, "row.src"),
        Motion(5, 1, "line", 0, "row.src"),
    )


def test_a_point_that_the_program_changes_is_left_alone():
    program = points(b"P1.Z=P1.Z+10", b"LIN P1")

    assert [target.name for target in program.targets] == ["P2"]
    assert reasons(program) == {2: "the program changes the target in line 2 of row.src"}


def test_what_the_program_leaves_alone_is_told_where_it_uses_points_of_the_list():
    program = points(b"LIN P1", b"LIN P1:{Z 5}", b"LIN_REL {Z 5}")

    (left,) = program.left_alone
    assert (left.line, left.what, left.file) == (3, "LIN P1:{Z 5}", "row.src")
    assert english(left.reason) == "the position is computed at run time; corrected in the file: P1"


def test_targets_of_the_files_beside_are_not_among_the_answer():
    program = read_program(KRL_DATA, "row.dat", beside={"row.src": KRL})

    assert [target.name for target in program.targets] == ["XP1"]
    assert named(read_program(KRL, "row.src", beside={"row.dat": KRL_DATA}), "PTS[1]")


def test_a_tool_may_be_declared_in_another_module():
    program = read_program(PICK, "pick.mod", beside={"tools.sys": TOOLS})

    (target,) = program.targets
    assert target.tool.pose.position_mm == (0.0, 0.0, 100.0)
    assert program.motions == (Motion(5, 0, "line", None),)  # where it begins is no target of this file


def test_a_tool_that_two_modules_declare_is_only_known_by_its_name():
    program = read_program(
        PICK, "pick.mod", beside={"a.sys": TOOLS, "b.sys": TOOLS.replace(b"0,0,100", b"0,0,90")}
    )

    assert program.targets[0].tool == Frame("tGrip")


def test_only_the_file_itself_is_written():
    program = read_program(PICK, "pick.mod", beside={"tools.sys": b"\xef\xbb\xbf" + TOOLS})

    written = rewritten(program, {0: Pose((7.0, 2.0, 3.0), (1.0, 0.0, 0.0, 0.0))})

    assert written == PICK.replace(b"[[1,2,3]", b"[[7,2,3]")
    assert without_numbers(program).startswith(b"MODULE Pick")


def test_a_broken_file_beside_is_named():
    with pytest.raises(UnreadableFileError) as refused:
        read_program(PICK, "pick.mod", beside={"tools.sys": b"MODULE Tools\nCONST num a:=[1;\nENDMODULE\n"})

    assert str(refused.value) == "tools.sys, line 2, column 14: the bracket [ that begins here is not closed."


def test_files_beside_do_not_matter_where_a_program_is_one_file():
    program = read_program(b"movel(p[0,0,0,0,0,0])\n", "m.script", beside={"n.script": b"movel(p["})

    assert len(program.targets) == 1
