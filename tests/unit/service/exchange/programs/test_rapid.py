"""RAPID modules of ABB: what is a target, in which frames, and what is left alone."""

import math
import tracemalloc

import pytest
from scipy.spatial.transform import Rotation

from tests.helpers.exchange.robot_programs import RAPID, line_of, named, read, reasons
from truepose.exchange.programs.program import Frame, Motion

UNUSED = (9e9,) * 6
POSE = b"[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"


def module(*lines):
    return b"\n".join([b"MODULE M", *lines, b"ENDMODULE", b""])


def routine(*lines, declared=(b"CONST robtarget p10:=" + POSE + b";",)):
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
            b"CONST robtarget p10:=" + POSE + b";",
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


def test_a_target_that_only_serves_to_compute_others_is_left_alone():
    program = routine(b"MoveL RelTool(p10,0,0,5),v100,fine,tool0;")

    assert program.targets == ()
    assert reasons(program) == {4: "its position is computed at run time"}


def test_a_target_that_nothing_here_moves_to_is_one_without_frames():
    (target,) = read("m.mod", module(b"CONST robtarget p10:=" + POSE + b";")).targets

    assert target.tool is None
    assert target.work_object is None


def test_a_target_in_two_work_objects_is_left_alone():
    program = routine(b"MoveL p10,v100,fine,tool0;", b"MoveL p10,v100,fine,tool0\\WObj:=wB;")

    assert program.targets == ()
    assert reasons(program)[2] == (
        "it is used with tool0 in wobj0 in line 4 and with tool0 in wB in line 5, and the same numbers "
        "cannot be correct for both"
    )


def test_a_frame_of_another_file_is_known_by_its_name_only():
    (target,) = routine(b"MoveL p10,v100,fine,tElse\\WObj:=WOBJ0;").targets

    assert target.tool == Frame("tElse")
    assert target.work_object.pose.position_mm == (0.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("declared", "words"),
    [
        (
            b'PERS wobjdata w:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];',
            "moved by another",
        ),
        (b'PERS wobjdata w:=[TRUE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];', "robot holds the work"),
    ],
)
def test_targets_in_a_work_object_that_moves_are_left_alone(declared, words):
    program = routine(
        b"MoveL p10,v100,fine,tool0\\WObj:=w;",
        declared=(b"CONST robtarget p10:=" + POSE + b";", declared),
    )

    assert program.targets == ()
    assert words in reasons(program)[5]


def test_targets_in_a_work_object_that_the_program_changes_are_left_alone():
    wobj = b'PERS wobjdata w:=[FALSE,TRUE,"",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'

    program = routine(
        b"w.uframe.trans.x:=found;",
        b"MoveL p10,v100,fine,tool0\\WObj:=w;",
        declared=(b"CONST robtarget p10:=" + POSE + b";", wobj),
    )

    assert reasons(program)[6] == "the program changes w in line 5"


def test_a_tool_that_stands_in_the_cell_is_told():
    tool = b"PERS tooldata t:=[FALSE,[[0,0,9],[1,0,0,0]],[1,[0,0,1],[1,0,0,0],0,0,0]];"

    program = routine(b"MoveL p10,v100,fine,t;", declared=(b"CONST robtarget p10:=" + POSE + b";", tool))

    assert reasons(program)[5] == "the tool t is stationary in the cell and the robot holds the workpiece"


def test_names_of_a_routine_are_its_own():
    program = read(
        "m.mod",
        module(
            b"CONST robtarget p10:=" + POSE + b";",
            b"PROC a()",
            b"CONST robtarget P10:=" + POSE.replace(b"1,2,3", b"7,7,7") + b";",
            b"MoveL p10,v100,fine,tool0;",
            b"ENDPROC",
            b"PROC b()",
            b"MoveL p10,v100,fine,tA;",
            b"ENDPROC",
        ),
    )

    assert [(t.value.position_mm[0], t.tool.name) for t in program.targets] == [(1.0, "tA"), (7.0, "tool0")]


def test_an_argument_hides_a_target_of_the_same_name():
    program = read(
        "m.mod",
        module(
            b"CONST robtarget p10:=" + POSE + b";",
            b"PROC a(robtarget p10)",
            b"MoveL p10,v100,fine,tool0;",
            b"ENDPROC",
        ),
    )

    assert reasons(program) == {4: "it is an argument of the routine"}
    assert program.targets[0].tool is None


def test_a_call_with_an_option_is_no_assignment():
    program = routine(b"place p10\\Speed:=v100;")

    assert reasons(program) == {
        4: "what it does with the target cannot be followed; corrected in the file: p10"
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


def test_targets_whose_numbers_have_names_are_left_alone():
    program = routine(
        declared=(b"CONST robtarget p10:=[[100+dx,0,0],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",)
    )

    assert program.targets == ()
    assert reasons(program) == {2: "some of its numbers are computed or given by name"}


def test_an_orientation_that_was_never_taught_is_left_alone():
    program = routine(
        declared=(b"CONST robtarget p10:=[[1,2,3],[0,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]];",)
    )

    assert reasons(program) == {2: "its orientation is not a unit quaternion"}


def test_motions_that_the_program_displaces_are_left_alone():
    program = routine(b"PDispSet poseDiff;", b"MoveL p10,v100,fine,tool0;", b"PDispOff;")

    assert program.targets == ()
    assert reasons(program) == {
        4: "it displaces the targets that follow",
        5: "it is displaced at run time",
    }


def test_motions_behind_the_end_of_a_displacement_are_not():
    program = routine(b"PDispSet poseDiff;", b"PDispOff;", b"MoveL p10,v100,fine,tool0;")

    assert [target.name for target in program.targets] == ["p10"]


def test_an_inline_target_in_a_work_object_that_moves_is_left_alone():
    wobj = b'PERS wobjdata w:=[FALSE,FALSE,"STN1",[[0,0,0],[1,0,0,0]],[[0,0,0],[1,0,0,0]]];'

    program = routine(b"MoveL " + POSE + b",v100,fine,tool0\\WObj:=w;", declared=(wobj,))

    assert program.targets == ()


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


def test_a_search_is_told_and_its_target_left_alone():
    program = routine(b"SearchL di1,pFound,p10,v100,tool0;")

    assert program.targets == ()
    assert reasons(program) == {4: "a search motion stops where its signal arrives"}


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
