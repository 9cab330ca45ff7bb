"""Corrected programs: the real tool arrives, and only the numbers of its targets change."""

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import extended, model_of, plain_parameters
from truepose.correction import tool_nests_mm
from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError
from truepose.exchange.programs.correction_request import branch_of_words
from truepose.exchange.programs.formats import read_program
from truepose.exchange.programs.program import Configuration, Pose, ProgramOptions, TargetConventions
from truepose.exchange.programs.program_correction import corrected_program
from truepose.identification.model.estimates import structure_of, values_of
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import quaternion_from_rotation, rotation_from_quaternion
from truepose.kinematics.inverse import all_branches, branch_of
from truepose.messages.catalogue import english

JOINTS = np.radians([[20.0, 30.0, -25.0, 40.0, 50.0, 60.0], [-35.0, 15.0, 5.0, -70.0, 35.0, 10.0]])
TOOL = Pose((10.0, -20.0, 150.0), (0.9238795325112867, 0.0, 0.3826834323650898, 0.0))
REST = "[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]"
MODULE = """MODULE Weld
  ! corrected by nobody yet
  PERS tooldata tGun:=[TRUE,[[10,-20,150],[0.9238795325112867,0,0.3826834323650898,0]],
    [1,[0,0,50],[1,0,0,0],0,0,0]];
  CONST jointtarget jHome:=[[20,30,-25,40,50,60],{rest}];
  CONST robtarget pOne:=[[{x:.9f},{y:.9f},{z:.9f}],[{qw:.12f},{qx:.12f},{qy:.12f},{qz:.12f}],
    [0,0,0,{cfx}],{rest}];
  PROC main()
    MoveAbsJ jHome,v100,fine,tGun;
    MoveL pOne,v100,fine,tGun;  ! here
    MoveL Offs(pOne,0,0,50),v100,fine,tGun;
  ENDPROC
ENDMODULE
"""


def model(**changes):
    plain = model_of(IRB_120, *plain_parameters(IRB_120), **changes)
    return replace(plain, nominal_base=plain.base)


def with_backlash():
    robot = extended(IRB_120, "backlash")
    return replace(robot, nominal_base=robot.base)


def placed(rotation, position_mm):
    found = np.eye(4)
    found[:3, :3], found[:3, 3] = rotation, position_mm
    return found


def matrix(pose):
    return placed(rotation_from_quaternion(np.array(pose.quaternion)), pose.position_mm)


def nominal_flange(joints_rad):
    chain = nominal_chain(IRB_120, np.atleast_2d(joints_rad))
    return placed(chain.end_rotation[0], chain.end_origin[0])


def reached(robot, stops):
    """The chain of the robot as it truly is."""
    targets = Targets(stops, np.ones(len(stops), dtype=np.int64))
    return evaluate(structure_of(robot), values_of(robot), targets).chain


def real_flange(robot, joints_rad):
    """Where the flange truly is, in the base where the robot truly stands."""
    stops = Stops(np.zeros(1, dtype=np.int64), np.atleast_2d(joints_rad))
    chain = reached(robot, stops)
    base = placed(chain.base_rotation[0], chain.base_origin[0])
    return np.linalg.inv(base) @ placed(chain.end_rotation[0], chain.end_origin[0])


def module():
    place = nominal_flange(JOINTS[1]) @ matrix(TOOL)
    x, y, z = place[:3, 3]
    qw, qx, qy, qz = quaternion_from_rotation(place[:3, :3])
    cfx = (0, 1, 2, 3, 6, 7, 4, 5)[branch_of(IRB_120, JOINTS[1:])[0]]
    return MODULE.format(x=x, y=y, z=z, qw=qw, qx=qx, qy=qy, qz=qz, cfx=cfx, rest=REST).encode()


def controller_joints(pose, near_rad):
    """What the controller answers to a pose of the tool."""
    branches = all_branches(IRB_120, matrix(pose) @ np.linalg.inv(matrix(TOOL)))
    apart = np.abs(np.mod(branches - near_rad + np.pi, 2 * np.pi) - np.pi).max(axis=1)
    return branches[np.nanargmin(apart)]


def test_joints_and_poses_of_a_rapid_module_bring_the_real_tool_where_it_was_meant():
    robot, program = model(), read_program(module(), "weld.mod")

    again = read_program(corrected_program(robot, program).data, "weld.mod")

    home, one = (target.value for target in again.targets)
    assert isinstance(home, Configuration)
    assert real_flange(robot, home.joints_rad) == pytest.approx(nominal_flange(JOINTS[0]), abs=2e-3)
    sent = controller_joints(one, JOINTS[1])
    assert real_flange(robot, sent) == pytest.approx(nominal_flange(JOINTS[1]), abs=2e-3)
    assert np.abs(sent - JOINTS[1]).max() > 1e-3


def test_nothing_but_numbers_of_targets_changes_and_what_is_left_is_listed():
    data = module()

    answer = corrected_program(model(), read_program(data, "weld.mod"))

    assert answer.names == ("jHome", "pOne")
    assert answer.found.solved.all()
    before, after = data.decode().splitlines(), answer.data.decode().splitlines()
    assert [k for k, (a, b) in enumerate(zip(before, after, strict=True), start=1) if a != b] == [5, 6]
    assert after[4].startswith("  CONST jointtarget jHome:=[[")
    assert after[4].endswith("],[9E+09,9E+09,9E+09,9E+09,9E+09,9E+09]];")
    assert [(left.line, left.what.split("(")[0]) for left in answer.left_alone] == [(11, "MoveL Offs")]


def test_a_robot_without_errors_leaves_every_byte():
    nothing = replace(model(), parameters=(), effects=(), covariance=np.zeros((0, 0)))
    data = module()

    assert corrected_program(nothing, read_program(data, "weld.mod")).data == data


def test_targets_meant_in_the_world_are_reached_there():
    robot = model()
    robot = replace(
        robot, base=replace(robot.base, x_mm=2.0, y_mm=-3.0, z_mm=1.0, rx_rad=0.0, ry_rad=0.0, rz_rad=0.0)
    )
    program = read_program(module(), "weld.mod")

    answer = corrected_program(robot, program, ProgramOptions(meant=TargetConventions.WORLD))

    arrived = reached(robot, Stops(np.arange(2), answer.found.joints_rad))
    meant = [nominal_flange(joints)[:3, 3] for joints in JOINTS]
    assert arrived.end_origin == pytest.approx(np.array(meant), abs=2e-3)


def test_the_side_from_which_a_straight_program_comes_makes_up_for_backlash():
    robot = with_backlash()
    there = "CONST jointtarget a:=[[0,0,0,0,30,0],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    back = "CONST jointtarget b:=[[10,20,-10,5,40,20],[9E9,9E9,9E9,9E9,9E9,9E9]];"
    moves = "PROC main()\nMoveAbsJ a,v100,fine,tool0;\nMoveAbsJ b,v100,fine,tool0;\nENDPROC\n"
    program = read_program(f"MODULE M\n{there}\n{back}\n{moves}ENDMODULE\n".encode(), "m.mod")

    found = corrected_program(robot, program).found

    known = Stops(
        np.zeros(1, dtype=np.int64), found.joints_rad[1:], direction=np.array([[1, 1, -1, 1, 1, 1]])
    )
    arrived = reached(robot, known)
    base = placed(arrived.base_rotation[0], arrived.base_origin[0])
    wanted = base @ nominal_flange(np.radians([10, 20, -10, 5, 40, 20]))
    assert arrived.end_origin[0] == pytest.approx(wanted[:3, 3], abs=1e-3)
    turns = found.joints_rad - np.radians([[0, 0, 0, 0, 30, 0], [10, 20, -10, 5, 40, 20]])
    assert found.moved_rad == pytest.approx(np.abs(turns).max(axis=1))  # from the controller's own answer
    assert (found.moved_rad > 1e-4).all()


def test_a_tool_that_the_file_only_names_is_asked_for_and_taken():
    data = module().replace(b"  PERS tooldata tGun", b"  PERS tooldata tOther")
    program = read_program(data, "weld.mod")

    without = corrected_program(model(), program)
    defined = corrected_program(model(), program, ProgramOptions(defined={"TGUN": TOOL}))

    assert without.names == ("jHome",)
    assert any("tGun is not declared in this file" in english(left.reason) for left in without.left_alone)
    assert defined.names == ("jHome", "pOne")


def test_a_tool_that_the_file_does_not_name_is_refused():
    program = read_program(module(), "weld.mod")

    with pytest.raises(ConfigurationError, match=r"names no tool or work object tGum; it names .*tGun"):
        corrected_program(model(), program, ProgramOptions(defined={"tGum": TOOL}))


OF_A_FANUC = (
    b"/PROG A\n/MN\n   1:J P[1] 20% FINE ;\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\n"
    b"\tJ1= 10.000 deg, J2= 20.000 deg, J3= 10.000 deg,\n"
    b"\tJ4= 0.000 deg, J5= 40.000 deg, J6= 0.000 deg\n};\n/END\n"
)


def test_joints_of_a_fanuc_are_left_alone_because_they_count_from_the_horizontal():
    answer = corrected_program(model(), read_program(OF_A_FANUC, "a.ls"))

    assert answer.names == ()
    assert answer.data == OF_A_FANUC
    assert "from the horizontal" in english(answer.left_alone[0].reason)


def test_stated_to_count_from_the_horizontal_joints_of_a_fanuc_are_corrected():
    shown = np.radians([10.0, 20.0, 10.0, 0.0, 40.0, 0.0])
    own = shown - np.array([0.0, 0.0, shown[1], 0.0, 0.0, 0.0])  # axes 2 and 3 of an IRB 120 point alike

    answer = corrected_program(model(), read_program(OF_A_FANUC, "a.ls"), ProgramOptions(coupled=True))

    again = read_program(answer.data, "a.ls").targets[0].value.joints_rad
    sent = answer.found.joints_rad[0]
    assert answer.left_alone == ()
    assert answer.found.moved_rad[0] < np.radians(2.0)
    assert sent == pytest.approx(own, abs=np.radians(2.0))
    assert again == pytest.approx(sent + sent[1] * np.eye(6)[2], abs=np.radians(6e-4))


def test_a_program_of_an_arm_with_other_joints_is_refused():
    with pytest.raises(ConfigurationError, match=r"jHome in line 5 has 6 joints, the model has 7"):
        seven = replace(model(), robot=replace(IRB_120, joints=(*IRB_120.joints, IRB_120.joints[-1])))
        corrected_program(seven, read_program(module(), "weld.mod"))


@pytest.mark.parametrize(
    ("words", "branch"),
    [
        ("0, 0, 0, 0", 0),
        ("-1, 0, 1, 1", 1),
        ("0, 0, 0, 2", 2),
        ("0, 0, 0, 6", 4),  # behind axis 1, behind the lower arm: the elbow is up
        ("0, 0, 0, 4", 6),
        ("back/down/flip", 7),
        ("N U T, 0, 0, 0", None),
        ("", None),
    ],
)
def test_the_branch_is_taken_from_words_that_are_understood(words, branch):
    assert branch_of_words(words) == branch


def test_a_list_in_json_is_corrected_also_where_a_nest_of_the_tool_shall_be():
    robot = model()
    place = nominal_flange(JOINTS[1])
    qw, qx, qy, qz = quaternion_from_rotation(place[:3, :3]).tolist()
    x, y, z = (place[:3, 3] + place[:3, :3] @ tool_nests_mm(robot)[0]).tolist()
    near = {f"q{joint}_deg": angle for joint, angle in enumerate(np.degrees(JOINTS[1]), start=1)}
    row = {"x_mm": x, "y_mm": y, "z_mm": z, "qw": qw, "qx": qx, "qy": qy, "qz": qz, **near}

    answer = corrected_program(robot, read_program(json.dumps([{**row, "nest": 1}]).encode(), "l.json"))

    assert answer.left_alone == ()
    assert real_flange(robot, answer.found.joints_rad[0]) == pytest.approx(place, abs=2e-3)


def test_a_nest_that_the_tool_does_not_have_is_told():
    row = {"x_mm": 1, "y_mm": 2, "z_mm": 3, "qw": 1, "qx": 0, "qy": 0, "qz": 0, "nest": 99}

    answer = corrected_program(model(), read_program(json.dumps([row]).encode(), "l.json"))

    assert english(answer.left_alone[0].reason) == "its tool nest 99 is not declared in this file: define it"


def test_a_program_corrected_by_a_model_with_backlash_says_what_is_not_known_of_its_approaches():
    cautions = corrected_program(with_backlash(), read_program(module(), "weld.mod")).cautions

    assert any("backlash" in english(caution) for caution in cautions)
    assert corrected_program(model(), read_program(module(), "weld.mod")).cautions == ()
