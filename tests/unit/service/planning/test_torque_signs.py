"""Gears loaded from one side: judged by torques that are worked out by hand."""

from dataclasses import replace

import numpy as np

from truepose.exchange.cells.file import cell_given
from truepose.planning.prediction.robots_and_cells import of_cell
from truepose.planning.prediction.tracker import promised_session
from truepose.planning.workspace.space import are_loaded_one_way

LR_MATE = of_cell(cell_given("fanuc-lr-mate-200ic")).space
FORWARDS, BACKWARDS = [0, 40, 0, 0, 0, 0], [0, -40, 0, 0, 0, 0]


def torque_by_hand(space, joint, joints_rad):
    """Torque of the weight about an axis: all masses beyond it by their lever, by products of matrices."""
    frames = [np.eye(4)]
    for row, q in zip(space.robot.joints, joints_rad, strict=True):
        ca, sa, c, s = (
            f(x) for x in (row.alpha_rad, row.sign * q + row.theta_offset_rad) for f in (np.cos, np.sin)
        )
        step = [
            [c, -s, 0, row.a_mm],
            [s * ca, c * ca, -sa, -sa * row.d_mm],
            [s * sa, c * sa, ca, ca * row.d_mm],
            [0, 0, 0, 1],
        ]
        frames.append(frames[-1] @ step)
    axis, origin = frames[joint][:3, 2], frames[joint][:3, 3]
    weights = [
        (np.array([0, 0, -9.81 * mass.mass_kg]), (frames[mass.frame] @ [*mass.centre_of_gravity_mm, 1.0])[:3])
        for mass in space.robot.masses
        if mass.frame >= joint
    ]
    return sum(axis @ np.cross(centre - origin, weight) for weight, centre in weights)


def test_an_arm_that_leans_over_to_the_other_side_is_left_out():
    mostly_forwards = np.radians([FORWARDS] * 8 + [BACKWARDS])
    still = replace(LR_MATE, approach_offset_rad=None)

    assert torque_by_hand(still, 2, mostly_forwards[0]) > 0.0 > torque_by_hand(still, 2, mostly_forwards[-1])
    assert are_loaded_one_way(still, mostly_forwards).tolist() == [True] * 8 + [False]


def test_a_gear_that_is_loaded_from_either_side_alike_limits_nothing():
    both = np.radians([FORWARDS, BACKWARDS] * 4)

    assert are_loaded_one_way(replace(LR_MATE, approach_offset_rad=None), both).all()


def test_where_masses_are_unknown_all_are_taken():
    unknown = replace(LR_MATE, robot=replace(LR_MATE.robot, masses=()))

    assert are_loaded_one_way(unknown, np.radians([FORWARDS] * 8 + [BACKWARDS])).all()


def test_a_plan_keeps_the_sign_at_every_stop_and_approach():
    free = promised_session(LR_MATE, 30, n_candidates=400).joints_rad
    kept = promised_session(LR_MATE, 30, n_candidates=400, one_sided=True).joints_rad

    def signs(joints_rad, joint):
        ends = np.concatenate([joints_rad, joints_rad + LR_MATE.approach_offset_rad])
        return {bool(torque_by_hand(LR_MATE, joint, q) > 0.0) for q in ends}

    for joint in (2, 3):
        assert signs(free, joint) == {True, False}
        assert len(signs(kept, joint)) == 1
