"""FANUC's count of the joints, there and back, and how slow a motion must be."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from truepose_drivers.api import MotionLimits
from truepose_drivers.arm_options import JointCounting, Pace

ROWS = json.loads((Path(__file__).parents[4] / "vectors" / "fanuc_orientations.json").read_text())["rows"]
ALPHA_DEG = (0.0, -90.0, 0.0, -90.0, 90.0, -90.0)  # of the shipped table of the LR Mate 200iC
OFFSET_DEG = (0.0, -90.0, 0.0, 0.0, 0.0, 0.0)
LIMITS = MotionLimits(500.0, math.radians(20.0))


def about_x(degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]])


def about_z(degrees):
    return np.roll(about_x(degrees), (-1, -1), (0, 1))


def about_y(degrees):
    return np.roll(about_x(degrees), (1, 1), (0, 1))


@pytest.mark.parametrize("row", ROWS, ids=lambda row: str(row["joints_deg"]))
def test_the_shipped_table_turns_as_fanucs_own_simulator_does(row):
    joints = JointCounting().of_robot(tuple(row["joints_deg"]))
    w, p, r = row["wpr_deg"]

    turned = np.eye(3)
    for alpha, offset, joint in zip(ALPHA_DEG, OFFSET_DEG, joints, strict=True):
        turned = turned @ about_x(alpha) @ about_z(joint + offset)

    assert turned == pytest.approx(about_z(r) @ about_y(p) @ about_x(w), abs=1e-7)


def test_joint_2_alone_keeps_the_forearms_inclination():
    start, leaning = (JointCounting().of_robot((0.0, angle, 30.0, 0.0, 0.0, 0.0)) for angle in (0.0, 40.0))

    assert (start[1] + start[2], leaning[1] + leaning[2]) == (-30.0, -30.0)


@pytest.mark.parametrize("from_horizontal", [True, False])
@given(joints=st.lists(st.floats(-360.0, 360.0), min_size=6, max_size=6))
def test_there_and_back_is_nothing(from_horizontal, joints):
    counting = JointCounting(from_horizontal=from_horizontal)

    there = counting.of_controller(tuple(joints))

    assert counting.of_robot(there) == pytest.approx(joints, abs=1e-12)
    assert counting.inclined(there) == pytest.approx(JointCounting().of_controller(tuple(joints)), abs=1e-12)


def test_an_arm_whose_robot_file_counts_as_the_controller_is_only_uncoupled():
    counting = JointCounting(signs=(1,) * 6)

    assert counting.of_robot((1.0, 20.0, 3.0, 4.0, 5.0, 6.0)) == (1.0, 20.0, 23.0, 4.0, 5.0, 6.0)


def test_joint_2_turns_no_tool_and_moves_it_all_the_same():
    pace = Pace(reach_mm=1000.0)

    assert pace.least_s((0.0, 90.0, 0.0, 0.0, 0.0, 0.0), LIMITS) == pytest.approx(500.0 * math.pi / 500.0)
    assert pace.least_s((90.0, 0.0, 0.0, 0.0, 0.0, 0.0), LIMITS) == pytest.approx(4.5)


@given(
    joints=st.lists(st.floats(-180.0, 180.0), min_size=6, max_size=6),
    steps=st.lists(st.floats(-1.0, 1.0), min_size=6, max_size=6),
)
def test_the_tool_never_turns_faster_than_its_limit(joints, steps):
    least_s = Pace(reach_mm=1e-6, tool_reach_mm=1e-6).least_s(steps, LIMITS)
    first, _, inclined, fourth, fifth, _ = joints
    # the axes that turn the tool, each in the frame of the one before, as the shipped robot has them
    frame = about_z(first)
    turning = steps[0] * frame[:, 2] - steps[2] * frame[:, 1]
    frame = frame @ about_y(-inclined)
    turning = turning - steps[3] * frame[:, 0]
    frame = frame @ about_x(-fourth)
    turning = turning - steps[4] * frame[:, 1]
    turning = turning - steps[5] * (frame @ about_y(-fifth))[:, 0]

    assert np.linalg.norm(turning) <= 20.0 * least_s * (1.0 + 1e-9) + 1e-9


def test_the_share_is_the_greatest_that_keeps_the_limits():
    assert Pace().share_percent((90.0, 0.0, 0.0, 0.0, 0.0, 0.0), LIMITS) == 5  # 20 of 350 deg/s: 5.7 %


def test_a_share_holds_whichever_way_the_controller_takes_joint_3():
    pace = Pace()

    # 40 deg of inclination in 0.1 s, or 20 deg between the links in less than joint 2 needs
    assert pace.at_full_speed_s((0.0, 20.0, -40.0, 0.0, 0.0, 0.0)) == pytest.approx(20.0 / 350.0)
    assert pace.at_full_speed_s((0.0, 20.0, 20.0, 0.0, 0.0, 0.0)) == pytest.approx(20.0 / 350.0)
    assert pace.at_full_speed_s((0.0, 0.0, 40.0, 0.0, 0.0, 0.0)) == pytest.approx(0.1)


def test_no_share_is_slow_enough_for_a_limit_below_one_percent():
    slow = MotionLimits(20.0, math.radians(3.0))

    assert Pace().share_percent((90.0, 0.0, 0.0, 0.0, 0.0, 0.0), slow) == 0


def test_an_arm_that_stands_there_already_is_moved_at_the_slowest():
    assert Pace().share_percent((0.0,) * 6, LIMITS) == 1


@given(steps=st.lists(st.floats(-180.0, 180.0), min_size=6, max_size=6))
def test_no_share_that_is_stated_breaks_the_limits(steps):
    pace = Pace()
    share = pace.share_percent(steps, LIMITS)
    if share:
        lasts_s = 100.0 * pace.at_full_speed_s(steps) / share
        assert lasts_s >= pace.least_s(steps, LIMITS) * (1.0 - 1e-6)
