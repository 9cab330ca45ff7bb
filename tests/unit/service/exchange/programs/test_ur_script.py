"""URScript: poses and configurations, the tool, and what is left alone."""

import pytest

from tests.helpers.exchange.robot_programs import named, read, reasons
from truepose.exchange.errors import UnreadableFileError
from truepose.exchange.programs.program import AT_THE_ORIGIN, Configuration, Frame
from truepose.messages.catalogue import catalogue, english


def program_of(*lines):
    return read("m.script", "\n".join(["def m():", *lines, "end", ""]).encode())


def test_lengths_are_in_metres_and_the_configuration_that_chooses_the_branch_stays_beside_the_pose():
    program = read("row.script")
    pose, near = named(program, "Waypoint_1_p").value, named(program, "Waypoint_1_p").near_rad

    assert pose.position_mm == pytest.approx((433.025361705, -467.959205379, 522.310714714), abs=1e-10)
    assert near == (1.9942498207092285, -1.66846146206, 1.93305045763, -0.271842316, 1.32090044, 0.0036344)
    assert "Waypoint_1_q" not in {target.name for target in program.targets}


def test_a_pose_is_that_of_the_tool_in_the_base():
    target = named(read("row.script"), "pts[0]")

    assert target.tool.pose.position_mm == (0.0, 0.0, 125.0)
    assert target.work_object == Frame("base", AT_THE_ORIGIN)


def test_a_tool_that_is_computed_is_not_known():
    program = program_of("set_tcp(pose_trans(a, b))", "movel(p[0,0,0,0,0,0])")

    assert program.targets[0].tool.pose is None


def test_a_tool_that_is_set_in_a_branch_is_not_known_behind_it():
    program = program_of(
        "set_tcp(p[0,0,1,0,0,0])", "if x:", "set_tcp(p[0,0,2,0,0,0])", "end", "movel(p[0,0,0,0,0,0])"
    )

    assert program.targets[0].tool is None


def test_a_tool_that_is_set_in_a_loop_may_hold_when_it_begins_again():
    program = program_of(
        "set_tcp(p[0,0,1,0,0,0])", "while True:", "movel(p[0,0,0,0,0,0])", "set_tcp(t)", "end"
    )

    assert program.targets[0].tool is None


def test_a_list_of_six_numbers_is_a_target_only_where_the_robot_moves_to_it():
    assert program_of("inertia=[1,2,3,4,5,6]", "set_payload(1.0, inertia)").targets == ()


def test_a_variable_that_is_given_twice_is_two_targets():
    program = program_of("a=p[0,0,.1,0,0,0]", "movel(a)", "a=p[0,0,.2,0,0,0]", "movel(a)")

    assert [target.value.position_mm[2] for target in program.targets] == [100.0, 200.0]


def test_a_variable_that_is_computed_later_is_left_alone():
    program = program_of("a=p[0,0,.1,0,0,0]", "movel(a)", "a=pose_add(a, b)", "movel(a)")

    assert program.targets == ()
    assert reasons(program)[2] == "the program changes the target in line 4"


def test_a_variable_may_be_called_like_the_head_of_a_routine():
    program = program_of("sec = 5", "movel(p[0,0,0,0,0,0])")

    assert len(program.targets) == 1


def test_no_depth_of_calls_ends_the_reader():
    program = program_of(f"movej({'get_inverse_kin(' * 40}p[0,0,0,0,0,0]{')' * 40})")

    assert reasons(program) == {2: "the position is computed at run time"}
    with pytest.raises(UnreadableFileError, match="line 2, column 806: brackets are nested too deeply"):
        program_of(f"movej({'get_inverse_kin(' * 5000}p[0,0,0,0,0,0]{')' * 5000})")


def test_a_line_to_joint_angles_is_to_a_configuration():
    (target,) = program_of("movel([0,0,0,0,0,1])").targets

    assert target.value == Configuration((0.0, 0.0, 0.0, 0.0, 0.0, 1.0))


def test_a_tool_that_is_set_by_a_name_is_told_by_its_line_in_every_language():
    (target,) = program_of("set_tcp(t)", "movel(p[0,0,0,0,0,0])").targets

    assert english(target.tool.shown) == target.tool.name
    assert catalogue("fr").spoken(target.tool.shown) == target.tool.name.replace("of line", "de la ligne")
