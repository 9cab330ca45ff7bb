"""KRL of KUKA: targets of data lists and of programs, their frames, and what is left alone."""

import math

import pytest

from tests.helpers.exchange.robot_programs import named, read, reasons
from truepose.exchange.programs.program import AT_THE_ORIGIN, Configuration, Frame
from truepose.messages.catalogue import catalogue, english

POSE = b"{X 1.0,Y 2.0,Z 3.0,A 0.0,B 0.0,C 0.0}"
MOVED = b"$BASE=EK(MACHINE_DEF[2].ROOT,MACHINE_DEF[2].MECH_TYPE,POSER)"


def routine(*lines):
    return read("m.src", b"\n".join([b"DEF M( )", b"E6POS P1", b"P1=" + POSE, *lines, b"END", b""]))


def test_a_point_of_an_inline_form_has_numbers_and_branch_and_stands_in_the_frames_of_its_data():
    (target,) = read("row.dat").targets

    assert (target.name, target.branch) == ("XP1", "S 2, T 3")
    assert target.value.position_mm == (214.483856, 193.590897, 1005.80865)
    assert target.tool.name == "TOOL_DATA[2]"
    assert target.tool.pose.position_mm == (0.0, 0.0, 200.0)
    assert target.work_object == Frame("$NULLFRAME", AT_THE_ORIGIN)


def test_targets_of_a_program_stand_in_the_frames_that_hold_there():
    target = named(read("row.src"), "PTS[1]")

    assert target.tool == Frame("TOOL_DATA[1]")  # only named here
    assert target.work_object.pose.position_mm == (1000.0, 0.0, 500.0)
    assert target.branch == "S 'B110', T 'B010011'"


@pytest.mark.parametrize(
    ("written", "turns"),
    [
        ("'b010011'", [(19, 2)]),
        ("'B010011'", [(19, 2)]),
        ("'h13'", [(19, 16)]),
        ("19", [(19, 10)]),
        ("'b01_1'", []),
        ("'b2'", []),
    ],
)
def test_turns_are_counted_in_bits_whatever_their_letters(written, turns):
    text = f"DEFDAT M\nDECL E6POS P={{X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T {written}}}\nENDDAT\n"
    (target,) = read("m.dat", text.encode()).targets

    assert [(number.value, number.base) for number in target.turns] == turns


def test_axes_are_a_configuration_and_other_axes_are_kept():
    target = named(read("row.src"), "HOME")

    assert [math.degrees(angle) for angle in target.value.joints_rad] == pytest.approx([0, -90, 90, 0, 0, 0])
    assert target.external == (12.0,)


def test_elements_of_an_array_in_a_data_list_are_targets():
    program = read(
        "m.dat", b"DEFDAT M\nDECL E6POS PTS[2]\nPTS[1]=" + POSE + b"\nPTS[2]=" + POSE + b"\nENDDAT\n"
    )

    assert [target.name for target in program.targets] == ["PTS[1]", "PTS[2]"]


def test_a_frame_that_nothing_moves_to_is_no_target():
    assert "OFFS" not in {target.name for target in read("row.src").targets}


def test_a_frame_that_the_program_moves_to_is_one():
    program = routine(b"FRAME F", b"F=" + POSE, b"LIN F")

    assert named(program, "F").value.position_mm == (1.0, 2.0, 3.0)


def test_what_is_said_of_the_speed_of_a_motion_changes_no_point():
    program = routine(b"SLIN P1 WITH $VEL.CP=0.5, $BASE=BASE_DATA[3]")

    assert named(program, "P1").work_object == Frame("BASE_DATA[3]")


def test_numbers_of_tool_and_base_may_be_given_by_a_call():
    program = routine(b"BAS (#TOOL,4 )", b"BAS (#BASE,0 )", b"LIN P1")

    assert named(program, "P1").tool == Frame("TOOL_DATA[4]")
    assert named(program, "P1").work_object == Frame("$NULLFRAME", AT_THE_ORIGIN)


@pytest.mark.parametrize(
    ("lines", "told"),
    [
        (
            (b"P1.Z=P1.Z+10", b"LIN P1"),
            {3: "the program changes the target in line 4", 4: "the position is computed at run time"},
        ),
        (
            (b"$BASE=BASE_DATA[1]", b"LIN P1", b"$BASE=BASE_DATA[2]", b"LIN P1"),
            {
                3: "the target is used with BASE_DATA[1] in line 5 and with BASE_DATA[2] in line 7, and the "
                "same numbers cannot be correct for both"
            },
        ),
        ((MOVED, b"LIN P1"), {5: "the base is moved by another mechanical unit"}),
    ],
    ids=["it is changed", "two bases", "a base that another machine moves"],
)
def test_a_point_that_numbers_cannot_correct_is_none_and_told(lines, told):
    program = routine(*lines)

    assert program.targets == ()
    assert reasons(program) == told


B1, B2 = b"$BASE=BASE_DATA[1]", b"$BASE=BASE_DATA[2]"


@pytest.mark.parametrize(
    ("lines", "base"),
    [
        ((B1, b"IF $IN[1] THEN", B2, b"ENDIF", b"LIN P1"), None),
        ((B1, b"LOOP", b"LIN P1", B2, b"ENDLOOP"), None),
        ((B1, b"LOOP", b"LIN P1", b"ENDLOOP"), Frame("BASE_DATA[1]")),
    ],
    ids=["set in a branch", "set in the loop that begins again", "not touched by the loop"],
)
def test_a_base_is_known_where_no_branch_and_no_loop_may_have_set_another(lines, base):
    assert named(routine(*lines), "P1").work_object == base


def test_an_inline_point_in_a_base_that_another_machine_moves_is_left_alone():
    program = routine(MOVED, b"LIN " + POSE)

    assert [target.name for target in program.targets] == ["P1"]


def test_what_is_set_in_one_routine_is_not_known_in_another():
    data = b"\n".join([b"DEF A( )", b"$BASE=BASE_DATA[1]", b"END", b"DEF B( )", b"LIN " + POSE, b"END", b""])

    (target,) = read("m.src", data).targets

    assert target.work_object is None


def test_axes_may_be_given_where_the_motion_stands():
    (target,) = read("m.src", b"DEF M( )\nPTP {E6AXIS: A1 1,A2 2,A3 3,A4 4,A5 5,A6 6}\nEND\n").targets

    assert isinstance(target.value, Configuration)


def test_bases_that_have_no_name_are_told_by_their_lines_in_every_language():
    program = routine(
        b"$BASE={X 1,Y 0,Z 0,A 0,B 0,C 0}", b"LIN P1", b"$BASE={X 2,Y 0,Z 0,A 0,B 0,C 0}", b"LIN P1"
    )
    (left,) = program.left_alone

    assert "$BASE of line 4" in english(left.reason)
    assert "$BASE of line 6" in english(left.reason)
    assert "$BASE de la ligne 4" in catalogue("fr").spoken(left.reason)
    assert "of line" not in catalogue("fr").spoken(left.reason)
