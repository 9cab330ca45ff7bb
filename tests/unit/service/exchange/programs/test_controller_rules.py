"""Corrected targets run by controllers of another make: each arrives at the joints that were solved."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.exchange.drawn_programs import LANGUAGES, tried
from tests.helpers.identification.models import extended
from truepose.domain.robot import JointRange
from truepose.exchange.programs.controller_rules import (
    Confdata,
    Nearest,
    StatedBranch,
    StatusAndTurn,
    TargetContext,
)
from truepose.exchange.programs.formats import read_program
from truepose.exchange.programs.program import AT_THE_ORIGIN, ProgramOptions
from truepose.exchange.programs.program_correction import corrected_program
from truepose.exchange.robots.named import load_robot
from truepose.kinematics.inverse import branch_of
from truepose.messages.catalogue import english

IRB, KUKA = load_robot("abb-irb-120"), load_robot("kuka-kr-6-r900-sixx")
FANUC, UR = load_robot("fanuc-lr-mate-200ic"), load_robot("universal-robots-ur10")


@pytest.mark.parametrize("name", LANGUAGES)
def test_no_corrected_target_leads_its_controller_to_other_joints(name):
    count = tried(LANGUAGES[name], 30, seed=4)

    assert count.elsewhere == 0
    assert count.corrected + count.alone["left.turns"] > 15
    assert count.corrected > 6


@pytest.mark.parametrize(("size", "seed"), [(0.3, 5), (3.0, 6)])
def test_small_and_large_errors_are_kept_to_the_same_rule(size, seed):
    assert tried(LANGUAGES["RAPID"], 30, seed, size).elsewhere == 0


def corrected(robot, data, name, options=None):
    """A program after the correction by a model of this robot."""
    return corrected_program(extended(robot), read_program(data, name), options or ProgramOptions())


def stated(robot, joints):
    (branch,) = set(branch_of(robot, joints).tolist())
    return ProgramOptions(branch=branch)


def drawn_rapid(external="9E9,9E9,9E9,9E9,9E9,9E9"):
    data = LANGUAGES["RAPID"].write(IRB, np.radians([[20.0, 30, -25, 40, 50, 60]]))
    return data.replace(b"9E9,9E9,9E9,9E9,9E9,9E9", external.encode())


@pytest.mark.parametrize("external", ["0,9E9,9E9,9E9,9E9,9E9", "12.5,9E9,9E9,9E9,9E9,9E9"])
def test_a_target_with_an_external_axis_is_left_alone_with_the_reason(external):
    data = drawn_rapid(external)

    answer = corrected(IRB, data, "m.mod")

    assert answer.data == data
    assert "external axes" in english(answer.left_alone[0].reason)


@pytest.mark.parametrize(("external", "named"), [("12.5,9E9", False), ("9E9,9E9", True)])
def test_only_what_is_corrected_is_named_as_corrected_beside_what_is_left_alone(external, named):
    used = b"fine,t\\WObj:=w;\n    MoveL Offs(p0,0,0,50),v100,fine,t\\WObj:=w;"
    data = drawn_rapid(f"{external},9E9,9E9,9E9,9E9").replace(b"fine,t\\WObj:=w;", used)

    answer = corrected(IRB, data, "m.mod")

    (offset,) = [left for left in answer.left_alone if left.what.startswith("MoveL Offs")]
    assert english(offset.reason).endswith("corrected in the file: p0") is named
    assert ("p0" in {left.what for left in answer.left_alone}) is not named


def test_a_quadrant_follows_the_axis_that_a_correction_takes_across_its_border():
    joints = np.radians(np.tile([20.0, 30, -25, 40, 50, 60], (40, 1)))
    joints[:, 3] = np.radians(np.linspace(89.0, 91.0, 40))
    data = LANGUAGES["RAPID"].write(IRB, joints)

    answer = corrected(IRB, data, "m.mod")

    sent = LANGUAGES["RAPID"].taken(IRB, answer.data, joints)
    assert answer.found.solved.all()
    assert answer.left_alone == ()
    assert sent == pytest.approx(answer.found.joints_rad, abs=1e-6)
    assert (np.floor(sent[:, 3] / (np.pi / 2)) != np.floor(joints[:, 3] / (np.pi / 2))).any()


def test_the_turn_bits_of_a_kuka_follow_axes_through_zero():
    joints = np.radians(np.tile([0.0, -60.0, 80.0, 20.0, 40.0, 30.0], (20, 1)))
    joints[:, 0] = np.radians(np.linspace(-0.3, 0.3, 20))
    data = LANGUAGES["KRL"].write(KUKA, joints)

    answer = corrected(KUKA, data, "m.src", stated(KUKA, joints))

    sent = LANGUAGES["KRL"].taken(KUKA, answer.data, joints)
    assert answer.left_alone == ()
    assert sent == pytest.approx(answer.found.joints_rad, abs=1e-6)
    assert (np.sign(sent[:, 0]) != np.sign(joints[:, 0])).any()


def test_words_that_contradict_each_other_are_left_alone():
    joints = np.radians([[10.0, -60.0, 80.0, 20.0, 40.0, 30.0]])
    data = LANGUAGES["KRL"].write(KUKA, joints).replace(b"'B000010'", b"'B010010'")

    answer = corrected(KUKA, data, "m.src", stated(KUKA, joints))

    assert answer.data == data
    assert "branch and turns" in english(answer.left_alone[0].reason)


def test_one_stated_branch_is_not_taken_for_several_that_a_file_names():
    joints = np.radians([[10.0, 20, -10, 20, 40, 30], [15.0, 20, -10, 20, 40, 30]])
    data = LANGUAGES["FANUC LS"].write(FANUC, joints).replace(b"'N U T", b"'F U T", 1)

    answer = corrected(FANUC, data, "m.ls", stated(FANUC, joints))

    assert answer.data == data
    assert [left.reason.key for left in answer.left_alone] == ["left.many_branches"] * 2


def test_a_wrist_exactly_stretched_is_left_alone_where_its_turns_are_shared_in_another_way():
    joints = np.radians([[-16.0, 20.0, 10.0, 75.0, 0.0, -50.0]])
    data = LANGUAGES["RAPID"].write(IRB, joints)

    answer = corrected(IRB, data, "m.mod")

    assert answer.data == data
    assert [left.reason.key for left in answer.left_alone] == ["left.contradicts"]


def test_zeros_written_by_hand_stay_as_they_are():
    joints = np.radians([[-16.0, 20.0, 10.0, 75.0, 30.0, -50.0]])
    data = LANGUAGES["RAPID"].write(IRB, joints).replace(b"[-1,0,-1,", b"[0,0,0,")

    answer = corrected(IRB, data, "m.mod")

    assert answer.found.solved.all()
    assert answer.data != data
    assert b"[0,0,0," in answer.data


@pytest.mark.parametrize("turns", ["0, 0, 1", "0, -1, 0", "-1, 0, 0"])
def test_a_joint_beyond_half_a_turn_is_left_alone_where_it_is_only_counted(turns):
    joints = np.radians([[10.0, 20, -10, 20, 40, 30]])
    data = LANGUAGES["FANUC LS"].write(FANUC, joints).replace(b"T, 0, 0, 0", f"T, {turns}".encode())

    answer = corrected(FANUC, data, "m.ls", stated(FANUC, joints))

    assert answer.data == data
    assert "beyond half a turn" in english(answer.left_alone[0].reason)


def test_flags_of_a_yaskawa_beyond_half_a_turn_are_left_alone():
    joints = np.radians([[20.0, 30, -25, 40, 50, 60], [20.0, 30, -25, 40, 50, 260]])
    data = LANGUAGES["INFORM"].write(IRB, joints)

    answer = corrected(IRB, data, "m.jbi", replace(stated(IRB, joints), defined={"TOOL 0": AT_THE_ORIGIN}))

    assert answer.names == ("C00000",)
    assert [(left.what, left.reason.key) for left in answer.left_alone] == [("C00001", "left.turns")]


def test_a_pose_of_a_ur_is_reached_in_the_turn_of_the_joints_before():
    joints = np.radians([[20.0, -80, 70, -60, -90, 250]])
    data = LANGUAGES["URScript, moves"].write(UR, joints)

    answer = corrected(UR, data, "m.script", stated(UR, joints))

    assert answer.left_alone == ()
    assert np.degrees(answer.found.joints_rad[:, 5]) == pytest.approx([250.0, 250.0], abs=10.0)


def test_joints_before_in_another_branch_than_the_stated_one_are_a_contradiction():
    near = ANSWERS[1] + 0.1

    assert Nearest().taken(ANSWERS, TargetContext(0, before_rad=near), None) is None
    assert Nearest().taken(ANSWERS, TargetContext(1, before_rad=near), None) == pytest.approx(ANSWERS[1])


def test_an_axis_of_a_kuka_at_its_limit_is_within_it():
    limits = [JointRange(-np.pi, np.pi)] * 5 + [JointRange(np.radians(-350), np.radians(350))]
    at_limit = np.radians([10.0, 60, 80, 20, 40, -10 - 1e-7])
    answers = np.tile(at_limit, (8, 1))

    taken = StatusAndTurn().taken(answers, TargetContext(0, (0,)), limits)

    assert taken is not None
    assert np.degrees(taken[5]) == pytest.approx(350.0, abs=1e-3)


ANSWERS = np.full((8, 6), np.nan)
ANSWERS[0] = np.radians([170.0, -60, 80, -100, 40, -3])
ANSWERS[1] = np.radians([170.0, -60, 80, 80, -40, 177])
ANSWERS[2] = np.radians([170.0, -60, 80, 80, 0.1, 177])


@pytest.mark.parametrize(
    ("rule", "known", "degrees"),
    [
        (Confdata(), TargetContext(0, (1, -2, -1)), [170, -60, 80, -100, 40, -3]),
        (Confdata(), TargetContext(0, (1, 2, 3)), [170, -60, 80, 260, 40, 357]),
        (Confdata(), TargetContext(0, (1, -2, 0)), None),
        (Confdata(), TargetContext(0, (0, 0, 0)), [170, -60, 80, -100, 40, -3]),
        (Confdata(), TargetContext(2, (0, 0, 0)), None),
        (Confdata(), TargetContext(1, (1, 0, -3)), [170, -60, 80, 80, -40, -183]),
        (Confdata(), TargetContext(1, (1, 0, 13)), [170, -60, 80, 80, -40, 177 + 3 * 360]),
        (StatusAndTurn(), TargetContext(0, (0b101010,)), [170, -60, 80, -100, 40, -3]),
        (StatusAndTurn(), TargetContext(0, (0b000010,)), [170, -60, 80, 260, 40, 357]),
        (StatusAndTurn(), TargetContext(0, (0b111010,)), None),
        (StatedBranch(), TargetContext(1), [170, -60, 80, 80, -40, 177]),
        (
            Nearest(),
            TargetContext(-1, near_rad=np.radians([-180.0, -60, 80, 90, -40, 180])),
            [-190, -60, 80, 80, -40, 177],
        ),
        (Nearest(), TargetContext(0), [170, -60, 80, -100, 40, -3]),
    ],
)
def test_a_rule_takes_of_all_answers_the_one_that_its_words_name(rule, known, degrees):
    taken = rule.taken(ANSWERS, known, None)

    assert (taken is None) if degrees is None else np.degrees(taken) == pytest.approx(degrees)
