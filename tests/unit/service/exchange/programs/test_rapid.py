"""RAPID modules of ABB: what is a target, in which frames, and what is left alone."""

import math
import tracemalloc

import pytest
from scipy.spatial.transform import Rotation

from tests.helpers.exchange.robot_programs import RAPID, line_of, named, read, reasons
from truepose.exchange.programs.program import Frame, Motion

UNUSED = (9e9,) * 6
POSE = b"[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


P10 = b"CONST robtarget p10:=" + POSE + b";"
WOBJ = b'PERS wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'
CARRIED = WOBJ.replace(b'FALSE,TRUE,""', b'FALSE,FALSE,"STN1"')
STANDING = b"PERS tooldata t:=[FALSE,[[0,0,9],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"
IN_W = b"MoveL p10,v100,fine,tool0\\WObj:=w;"


def module(*lines):
    return b"\n".join([b"MODULE M", *lines, b"ENDMODULE", b""])


def routine(*lines, declared=(P10,)):
    return read("m.mod", module(*declared, b"PROC main()", *lines, b"ENDPROC"))


def test_a_target_has_its_numbers_branch_and_external_axes():
    target = named(read("row.mod"), "pPick")

    assert target.value.position_mm == (600.0, 500.0, 225.3)
    assert target.value.quaternion == pytest.approx((math.sqrt(0.5), 0, math.sqrt(0.5), 0), abs=1e-15)
    assert target.branch == "1, -1, 0, 0"
    assert target.external == UNUSED
    assert target.line == line_of(RAPID, b"robtarget pPick:=")


def test_a_target_stands_in_the_frames_of_the_motion_to_it():
    target = named(read("row.mod"), "pPick")

    assert target.tool.name == "tGrip"
    assert target.tool.pose.position_mm == (97.4, 0.0, 223.1)
    assert math.hypot(*target.tool.pose.quaternion) == pytest.approx(1.0, abs=1e-15)
    assert target.work_object.name == "wTable"
    assert target.work_object.pose.position_mm == (300.0, 800.0, 230.0)


def test_the_object_frame_stands_in_the_user_frame():
    x, y, z, w = Rotation.from_euler("z", 90, degrees=True).as_quat()
    user = f"[[100,0,0],[{w:.9f},{x:.9f},{y:.9f},{z:.9f}]]".encode()

    program = routine(
        b"MoveL p10,v100,fine,tool0\\WObj:=w;",
        declared=(
            P10,
            b'PERS wobjdata w:=[FALSE,TRUE,"",' + user + b",[[10,0,0],[1,0,0,0]]];",
        ),
    )

    assert named(program, "p10").work_object.pose.position_mm == pytest.approx((100, 10, 0), abs=1e-6)


def test_elements_of_an_array_are_targets():
    program = read("row.mod")

    assert named(program, "pRow{1}").value.position_mm == (1.0, 2.0, 3.0)
    assert named(program, "pRow{2}").value.position_mm == (-4.5, 5.0, 60.0)
    assert named(program, "pRow{2}").external == (12.5, *UNUSED[1:])


def test_arrays_of_two_dimensions_have_two_indices():
    array = b"CONST robtarget p{2,1}:=[[" + POSE + b"],[" + POSE + b"]];"

    program = routine(b"MoveL p{2,1},v100,fine,tool0;", declared=(array,))

    assert [target.name for target in program.targets] == ["p{1,1}", "p{2,1}"]
    assert program.motions == (Motion(4, 1, "line", None),)


def test_a_joint_target_is_a_configuration_without_frames():
    target = named(read("row.mod"), "jHome")

    degrees = [math.degrees(angle) for angle in target.value.joints_rad]
    assert degrees == pytest.approx([0, -30, 30, 0, 90, 1e-5], abs=1e-12)
    assert target.tool is None
    assert target.work_object is None


def test_an_inline_target_is_called_by_its_line():
    line = line_of(RAPID, b"\\Conc, [[7,8,9]")

    assert named(read("row.mod"), f"line {line}").value.position_mm == (7.0, 8.0, 9.0)


def test_a_target_that_the_program_changes_is_none():
    assert "pShift" not in {target.name for target in read("row.mod").targets}


def test_a_target_that_nothing_here_moves_to_is_one_without_frames():
    (target,) = read("m.mod", module(P10)).targets

    assert target.tool is None
    assert target.work_object is None


def test_a_frame_of_another_file_is_known_by_its_name_only():
    (target,) = routine(b"MoveL p10,v100,fine,tElse\\WObj:=WOBJ0;").targets

    assert target.tool == Frame("tElse")
    assert target.work_object.pose.position_mm == (0.0, 0.0, 0.0)


def test_names_of_a_routine_are_its_own():
    own = P10.replace(b"p10", b"P10").replace(b"1,2,3", b"7,7,7")
    first = b"PROC a()", own, b"MoveL p10,v100,fine,tool0;", b"ENDPROC"
    second = b"PROC b()", b"MoveL p10,v100,fine,tA;", b"ENDPROC"

    program = read("m.mod", module(P10, *first, *second))

    assert [(t.value.position_mm[0], t.tool.name) for t in program.targets] == [(1.0, "tA"), (7.0, "tool0")]


def test_an_argument_hides_a_target_of_the_same_name():
    lines = b"PROC a(robtarget p10)", b"MoveL p10,v100,fine,tool0;", b"ENDPROC"

    program = read("m.mod", module(P10, *lines))

    assert reasons(program) == {4: "the target is an argument of the routine"}
    assert program.targets[0].tool is None


def test_a_call_with_an_option_is_no_assignment():
    program = routine(b"place p10\\Speed:=v100;")

    assert reasons(program) == {
        4: "how this statement uses the target cannot be traced; corrected in the file: p10"
    }


def test_a_literal_that_is_assigned_is_a_target_too():
    program = routine(
        b"p20:=" + POSE.replace(b"1,2,3", b"4,5,6") + b";",
        b"MoveL p20,v100,fine,tool0;",
        declared=(b"VAR robtarget p20:=" + POSE + b";",),
    )

    assert [target.value.position_mm for target in program.targets] == [(1.0, 2.0, 3.0), (4.0, 5.0, 6.0)]
    assert program.motions == ()  # which of the two is not told by the text alone


def test_a_question_about_a_target_moves_nothing():
    program = routine(b"MoveL p10,v100,fine,tool0;", b"IF p10.trans.x > 5 THEN", b"Stop;", b"ENDIF")

    assert program.left_alone == ()


def test_motions_behind_the_end_of_a_displacement_are_not():
    program = routine(b"PDispSet poseDiff;", b"PDispOff;", b"MoveL p10,v100,fine,tool0;")

    assert [target.name for target in program.targets] == ["p10"]


ALONE = {
    "it only serves to compute others": (
        [P10],
        [b"MoveL RelTool(p10,0,0,5),v100,fine,tool0;"],
        {4: "the position is computed at run time"},
    ),
    "two work objects": (
        [P10],
        [b"MoveL p10,v100,fine,tool0;", b"MoveL p10,v100,fine,tool0\\WObj:=wB;"],
        {
            2: "the target is used with tool0 in wobj0 in line 4 and with tool0 in wB in line 5, and the "
            "same numbers cannot be correct for both"
        },
    ),
    "a work object that another unit moves": (
        [P10, CARRIED],
        [IN_W],
        {5: "the work object w is moved by another mechanical unit"},
    ),
    "an inline target in one": (
        [CARRIED],
        [IN_W.replace(b"p10", POSE)],
        {4: "the work object w is moved by another mechanical unit"},
    ),
    "a work object that the robot holds": (
        [P10, WOBJ.replace(b"FALSE", b"TRUE")],
        [IN_W],
        {5: "the robot holds the work object w"},
    ),
    "a work object that the program changes": (
        [P10, WOBJ],
        [b"w.uframe.trans.x:=found;", IN_W],
        {6: "the program changes w in line 5"},
    ),
    "a tool that stands in the cell": (
        [P10, STANDING],
        [b"MoveL p10,v100,fine,t;"],
        {5: "the tool t is stationary in the cell and the robot holds the workpiece"},
    ),
    "numbers that have names": (
        [P10.replace(b"1,2,3", b"100+dx,0,0")],
        [],
        {2: "some of the target's numbers are computed or given by name"},
    ),
    "an orientation that was never taught": (
        [P10.replace(b"[1,0,0,0]", b"[0,0,0,0]")],
        [],
        {2: "its orientation is not a unit quaternion"},
    ),
    "a motion that the program displaces": (
        [P10],
        [b"PDispSet poseDiff;", b"MoveL p10,v100,fine,tool0;", b"PDispOff;"],
        {4: "this statement displaces the targets that follow", 5: "the target is displaced at run time"},
    ),
    "a search": (
        [P10],
        [b"SearchL di1,pFound,p10,v100,tool0;"],
        {4: "a search motion stops where its signal arrives"},
    ),
}


@pytest.mark.parametrize("case", ALONE)
def test_a_target_that_numbers_cannot_correct_is_none_and_told(case):
    declared, lines, told = ALONE[case]

    program = routine(*lines, declared=declared)

    assert program.targets == ()
    assert reasons(program) == told


@pytest.mark.parametrize(
    ("call", "path"),
    [
        (b"MoveLDO p10,v100,fine,tA\\WObj:=w,do1,1;", "line"),
        (b"TriggL p10,v100,gunon,fine,tA\\WObj:=w;", "line"),
        (b"TriggJ p10,v100,gunon\\T2:=gunoff,fine,tA\\WObj:=w;", "joints"),
        (b"ArcL p10,v100,seam1,weld1,weave1,fine,tA\\WObj:=w;", "line"),
        (b"SpotL p10,v100,gun1,spot1,tA\\WObj:=w;", "line"),
        (b'MoveLSync p10,v100,fine,tA\\WObj:=w,"proc";', "line"),
    ],
)
def test_instructions_that_do_more_than_move_say_their_tool_in_its_place(call, path):
    program = routine(call)

    (target,) = program.targets
    assert (target.tool.name, target.work_object.name) == ("tA", "w")
    assert [motion.path for motion in program.motions] == [path]


@pytest.mark.parametrize("declared", [True, False])
def test_a_long_module_is_read_without_all_of_its_words_in_memory(declared):
    """The words of a text weigh a hundred times the text."""
    rest = "[9E9,9E9,9E9,9E9,9E9,9E9]"
    targets = [f"[[{k % 90}.1,30.25,-25.5,40.5,50.125,60.75],{rest}]" for k in range(300)]
    data = "".join(f"CONST jointtarget j{k}:={text};\n" for k, text in enumerate(targets) if declared)
    moved = (f"j{k}" if declared else text for k, text in enumerate(targets))
    moves = "".join(f"MoveAbsJ {one},v100,fine,tool0;\n" for one in moved)
    module = f"MODULE M\n{data}PROC main()\n{moves}ENDPROC\nENDMODULE\n".encode()
    read("m.mod", module)  # what is imported on the way

    tracemalloc.start()
    program = read("m.mod", module)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()

    assert len(program.targets) == len(program.motions) == 300
    assert peak < 40 * len(module)
