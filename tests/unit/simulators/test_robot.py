import numpy as np
import pytest

from truepose_simulators.cell.robot import Robot, SpeedLimits, TargetOutOfRangeError, check_range
from truepose_simulators.physics.robots import ARMS

ARM = ARMS["irb120"]
FAST = SpeedLimits(1e9, 1e9)


def make_robot(scatter_mm=0.0035):
    return Robot(ARM, np.zeros(6), scatter_mm, np.random.default_rng(1))


def degrees(*angles):
    return np.radians(np.array(angles, dtype=float))


def test_the_slowest_joint_sets_the_time_of_a_fast_motion():
    motion = make_robot().start([degrees(90, 0, 0, 0, 0, 42)], FAST, np.zeros(3), 0.0)

    assert motion.duration_s == pytest.approx(90 / 250, rel=1e-12)  # 250 deg/s: data sheet, axis 1


def test_the_tool_speed_sets_the_time_of_a_slow_motion():
    motion = make_robot().start([degrees(60, 0, 0, 0, 0, 0)], SpeedLimits(100.0, 1e9), np.zeros(3), 0.0)

    arc_mm = 374.0 * np.pi / 3
    # Eight chords of 7.5 deg are shorter than the arc by (7.5 deg)^2 / 24 = 0.07 %.
    assert motion.duration_s == pytest.approx(arc_mm / 100.0, rel=1e-3)


def test_the_orientation_speed_sets_the_time_of_a_turn_on_the_spot():
    limits = SpeedLimits(1e9, np.radians(20.0))

    motion = make_robot().start([degrees(0, 0, 0, 0, 0, 90)], limits, np.zeros(3), 0.0)

    assert motion.duration_s == pytest.approx(4.5, rel=1e-9)


def test_the_direction_of_each_joints_last_motion_is_remembered():
    robot = make_robot()
    for target in (degrees(10, -10, 0, 0, 0, 0), degrees(10, 0, 0, 5, 0, 0), degrees(5, 0, 0, 5, 0, 0)):
        robot.start([target], FAST, np.zeros(3), 0.0)

    assert robot.direction.tolist() == [-1, 1, 0, 1, 0, 0]


def test_scatter_is_drawn_anew_at_every_stop_and_only_there():
    robot = make_robot()
    robot.start([degrees(10, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 0.0)
    first = robot.scatter_mm
    robot.start([degrees(10, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 1.0)  # it already stands there
    same = robot.scatter_mm

    robot.start([degrees(11, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 2.0)

    assert np.array_equal(first, same)
    assert not np.array_equal(first, robot.scatter_mm)


def test_scatter_has_its_stated_size():
    robot = make_robot(scatter_mm=0.0035)
    drawn = []
    for angle in range(1, 1001):
        robot.start([degrees(angle / 100, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 0.0)
        drawn.append(robot.scatter_mm)

    # Standard deviation of 3000 draws is good to 1/sqrt(6000) = 1.3 %; four of these.
    assert np.std(drawn) == pytest.approx(0.0035, rel=0.052)


def test_under_way_the_joints_are_between_start_and_target():
    robot = make_robot()
    motion = robot.start([degrees(90, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 5.0)

    halfway = motion.joints_at(5.0 + motion.duration_s / 2)

    assert np.degrees(halfway[0]) == pytest.approx(45.0, abs=1e-9)
    assert robot.moving(5.0)
    assert not robot.moving(5.0 + motion.duration_s)


@pytest.mark.parametrize("target", [(165.1, 0, 0, 0, 0, 0), (0, 0, 70.1, 0, 0, 0), (0, 0, 0, 0, -120.1, 0)])
def test_a_target_outside_the_range_is_refused_with_joint_and_range(target):
    with pytest.raises(TargetOutOfRangeError, match=r"joint \d cannot go to .* deg: its range is"):
        check_range(ARM, degrees(*target))


def test_the_end_of_the_range_is_within_it():
    at_its_end = degrees(165, -110, 70, -160, 120, 400)

    assert check_range(ARM, at_its_end) is None


def test_equal_pieces_of_a_motion_end_in_one_stop():
    whole, pieces = make_robot(), make_robot()
    whole.start([degrees(12, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 0.0)
    for piece in (4, 8, 12):
        pieces.start([degrees(piece, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 0.0)

    assert np.array_equal(pieces.scatter_mm, whole.scatter_mm)
    assert np.array_equal(pieces.direction, whole.direction)


def test_a_halted_arm_stays_where_it_was():
    robot = make_robot()
    motion = robot.start([degrees(90, 0, 0, 0, 0, 0)], FAST, np.zeros(3), 1.0)
    middle_s = 1.0 + motion.duration_s / 2.0

    robot.halt(middle_s)
    later = robot.motion.joints_at(1e3)

    assert not robot.moving(middle_s)
    assert np.degrees(later[0]) == pytest.approx(45.0)
    robot.halt(1e3)
    assert np.array_equal(robot.target_rad, later)
