import numpy as np
import pytest

from tests.helpers.ballbar.pose_device import ALL, CUPS, NESTS, lengths
from truepose.kinematics.frames import rotation_from_vector
from truepose.kinematics.pose_device import Pose, pose_of, recognise_assembly, solve
from truepose.kinematics.pose_device.cascade import sides

NOWHERE = Pose(np.full((3, 3), np.nan), np.full(3, np.nan))


def shifted(pose, shift_mm):
    return Pose(pose.rotation, pose.origin_mm + shift_mm)


@pytest.mark.parametrize("assembly", ALL[::5])
def test_the_mode_next_to_a_commanded_pose_is_recognised_with_its_margin(assembly):
    rng = np.random.default_rng(assembly.number)
    turn = rotation_from_vector(0.003 * rng.normal(size=3))
    attained = Pose(turn @ assembly.pose.rotation, assembly.pose.origin_mm + rng.normal(size=3))
    found = solve(assembly.design, CUPS, sides(NESTS), lengths(attained, assembly.legs))

    recognised = recognise_assembly(assembly.pose, [pose_of(NESTS, one) for one in found], NESTS)

    assert recognised is not None
    assert recognised.index == assembly.solution - 1
    assert recognised.distance_mm < 4.0  # 1 mm and 3 mrad at 220 mm
    assert recognised.margin_mm > 50.0


def test_a_robot_in_another_mode_than_planned_is_found_out():
    planned, reached = ALL[0], ALL[2]  # solutions 1 and 3 of one design: the same legs

    recognised = recognise_assembly(shifted(reached.pose, 1.0), [one.pose for one in ALL[:4]], NESTS)

    assert recognised.index == reached.solution - 1 != planned.solution - 1


def test_a_pose_far_from_all_solutions_is_recognised_as_none():
    assert recognise_assembly(shifted(ALL[0].pose, 20.0), [one.pose for one in ALL[:4]], NESTS) is None


def test_two_solutions_equally_near_are_recognised_as_none():
    pose = ALL[0].pose

    assert recognise_assembly(pose, [shifted(pose, 1.0), shifted(pose, -1.0)], NESTS) is None


def test_a_surer_arm_tells_solutions_apart_that_a_nominal_one_cannot():
    pose = ALL[0].pose
    near, next_to_it = shifted(pose, 0.05), shifted(pose, 0.8)

    assert recognise_assembly(pose, [next_to_it, near], NESTS) is None
    assert recognise_assembly(pose, [next_to_it, near], NESTS, arm_u_mm=0.1).index == 1


def test_without_a_solution_nothing_is_recognised():
    assert recognise_assembly(ALL[0].pose, [], NESTS) is None
    assert recognise_assembly(ALL[0].pose, [NOWHERE, NOWHERE], NESTS) is None


def test_a_single_solution_has_an_infinite_margin():
    pose = ALL[0].pose

    for candidates in ([pose], [NOWHERE, pose]):
        recognised = recognise_assembly(pose, candidates, NESTS)
        assert candidates[recognised.index] is pose
        assert recognised.margin_mm == np.inf
