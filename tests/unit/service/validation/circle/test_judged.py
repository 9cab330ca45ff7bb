"""The circle test: what is planted in a joint is found on its circle, and nothing where nothing is."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.circles import (
    measured_circles,
    points_of,
    read_on,
    there_and_back,
    turned,
)
from tests.helpers.domain.robots import IRB_120
from truepose.domain.errors import ConfigurationError
from truepose.messages.catalogue import english
from truepose.validation.circle_test import circle_test

_ANGLES = there_and_back(-150, 150, 10)
_DIRECTION = np.sign(np.diff(_ANGLES, prepend=-151)).astype(np.int64)
_U_MM = 0.01


def one(joint, angles_deg=_ANGLES, **read):
    """The only circle of a test of one joint of an IRB 120."""
    return only(turned(joint, angles_deg), **read)


def only(joints_rad, **read):
    (found,) = circle_test(read_on(IRB_120, joints_rad, **read)).circles
    return found


def bent(joint, angles_deg, error_rad):
    """Where the joints stand whose joint errs by so much."""
    joints = turned(joint, angles_deg)
    joints[:, joint - 1] += error_rad
    return joints


@pytest.mark.parametrize("joint", range(1, 7))
def test_a_perfect_robot_has_no_errors_and_it_says_so(joint):
    found = one(joint)

    for errors in (found.errors.tangential_mm, found.errors.radial_mm, found.errors.axial_mm):
        assert np.abs(errors).max() < 1e-8  # mm; positions of half a metre are rounded at 1e-13
    assert found.is_noise
    assert not found.curve.gain.is_seen
    assert not any(wave.is_seen for wave in found.curve.waves)
    assert not found.backlash_rad.is_seen


@pytest.mark.parametrize("joint", range(1, 7))
def test_what_a_joint_does_wrong_is_found_on_its_circle(joint):
    angles = np.radians(_ANGLES)
    error = 4e-4 * angles + 5e-4 * np.cos(2.0 * (angles - 0.3)) - 1e-4 * _DIRECTION

    found = one(joint, true_rad=bent(joint, _ANGLES, error))

    assert found.curve.gain.value == pytest.approx(4e-4, rel=1e-3)
    first, second = found.curve.waves
    assert first.amplitude_rad.value < 1e-6
    assert (second.order, second.amplitude_rad.value) == (2, pytest.approx(5e-4, rel=1e-3))
    assert second.phase_rad == pytest.approx(0.3, abs=1e-3)
    assert found.backlash_rad.value == pytest.approx(2e-4, rel=1e-3)
    assert found.angular_range_rad.value == pytest.approx(np.ptp(error), rel=1e-6)
    assert found.tangential_range_mm.value == pytest.approx(np.ptp(error) * found.errors.radius_mm, rel=1e-6)
    assert not found.is_noise


def test_errors_are_against_the_place_at_zero():
    found = one(1, true_rad=bent(1, _ANGLES, 1e-3 * np.cos(np.radians(_ANGLES))))
    zero = np.argmin(np.abs(found.errors.angle_rad))

    assert found.errors.zero_rad == pytest.approx(0.0)
    assert found.errors.angular_rad[zero] == pytest.approx(0.0, abs=1e-9)
    assert found.errors.angular_rad.min() == pytest.approx(1e-3 * (np.cos(np.radians(150)) - 1.0), rel=1e-3)


def test_without_a_reading_at_zero_the_nearest_takes_its_place():
    found = one(1, np.arange(-49.0, 50.0, 7.0)[:-1] + 3.0)

    assert np.degrees(found.errors.zero_rad) == pytest.approx(3.0)


def test_from_one_side_no_backlash_is_stated():
    found = one(2, np.arange(-60.0, 61.0, 5.0))

    assert found.backlash_rad is None
    assert found.curve.gain is not None


_SHUFFLED = np.random.default_rng(1).permutation(len(_ANGLES))


@pytest.mark.parametrize(
    "told",
    [{"direction": np.outer(_DIRECTION, np.arange(6) == 2)[_SHUFFLED]}, {"time_s": _SHUFFLED.astype(float)}],
    ids=["direction", "time"],
)
def test_the_table_says_from_which_side_where_the_order_does_not(told):
    stands = bent(3, _ANGLES, -1e-4 * _DIRECTION)[_SHUFFLED]

    found = only(turned(3, _ANGLES)[_SHUFFLED], true_rad=stands, **told)

    assert found.backlash_rad.value == pytest.approx(2e-4, rel=1e-3)


def test_who_states_a_gain_does_not_say_that_no_error_is_seen():
    """Some 4 u of a gain, which all errors of a short arc together hide."""
    angles = there_and_back(-40, 40, 4)
    stands = bent(5, angles, 4e-4 * np.radians(angles))
    tests = [one(5, angles, true_rad=stands, scatter_mm=_U_MM, seed=seed) for seed in range(20)]

    gained = [test for test in tests if test.curve.gain.is_seen]

    assert any(test.curve.noise_chance > 0.01 for test in gained)
    assert not any(test.is_noise for test in gained)


def test_readings_that_state_no_uncertainty_are_judged_by_their_own_scatter():
    told, silent = (one(1, scatter_mm=0.01, u_mm=u_mm) for u_mm in (1e-6, 0.0))

    assert silent.errors.angular_rad == pytest.approx(told.errors.angular_rad, abs=1e-12)
    assert silent.circle.radius_uncertainty_mm == pytest.approx(told.circle.radius_uncertainty_mm)


def test_the_axis_is_no_part_of_a_range_whose_ends_lie_side_by_side():
    """Over a short arc the axis is hardly known, but it shifts the errors of both ends alike."""
    angles = np.arange(-30.0, 30.1, 5.0)
    error = 2e-3 * ((angles == 5.0) - 1.0 * (angles == 10.0))
    drawn = [
        one(1, angles, true_rad=bent(1, angles, error), scatter_mm=_U_MM, u_mm=_U_MM, seed=seed)
        for seed in range(200)
    ]

    ranges = np.array([found.angular_range_rad.value for found in drawn])
    stated = np.median([found.angular_range_rad.standard_uncertainty for found in drawn])
    # 200 draws know a scatter to 5 %; the steps' own part in the fitted circle adds a few more
    assert np.std(ranges) == pytest.approx(stated, rel=0.2)


def test_a_gross_reading_is_set_aside_and_named():
    points = read_on(IRB_120, turned(1, _ANGLES), scatter_mm=_U_MM)
    points.position_mm[7] += (0.3, 0.4, 0.5)

    (found,) = circle_test(points).circles

    assert found.set_aside == (8,)
    assert 8 not in found.config
    assert found.radial_range_mm < 0.1


def test_an_arc_too_short_for_a_circle_is_withheld_in_a_sentence():
    (refused,) = circle_test(
        read_on(IRB_120, turned(1, there_and_back(-1.5, 1.5, 0.25)), scatter_mm=_U_MM)
    ).withheld

    assert refused.joint == 1
    assert english(refused.reason).startswith("An arc of 3 deg is too short: its radius of ")


def test_a_nest_on_the_axis_tells_nothing_of_the_joint():
    places = np.random.default_rng(1).normal(scale=_U_MM, size=(len(_ANGLES), 3))

    (refused,) = circle_test(points_of(turned(6, _ANGLES), places)).withheld

    assert refused.reason.key == "circles.near"


@pytest.mark.parametrize("places", [np.zeros((7, 3)), np.outer(np.arange(7.0), [10.0, 0.0, 0.0])])
def test_one_place_and_a_line_are_no_circles(places):
    test = circle_test(points_of(turned(1, np.arange(0.0, 70.0, 10.0)), places))

    assert test.circles == ()
    assert english(test.withheld[0].reason)


def test_three_angles_are_too_few():
    (refused,) = circle_test(read_on(IRB_120, turned(1, there_and_back(-60, 60, 60)))).withheld

    assert english(refused.reason) == "Angles measured: 3. A circle needs four."


def test_a_table_in_which_all_joints_move_is_no_circle_test():
    joints = np.random.default_rng(1).uniform(-1.0, 1.0, (30, 6))

    with pytest.raises(ConfigurationError, match="move one joint at a time"):
        circle_test(read_on(IRB_120, joints))


def test_joints_and_nests_are_told_apart_wherever_the_others_stand():
    stand = np.radians([20.0, -10.0, 30.0, 0.0, 40.0, 15.0])
    parts = [turned(joint, there_and_back(-60, 60, 10)) + stand for joint in (1, 2, 5)]
    joints = np.vstack(parts)
    places = read_on(IRB_120, joints).position_mm
    nests = np.repeat([1, 2], len(joints))

    found = circle_test(
        points_of(np.vstack([joints, joints]), np.vstack([places, places + 1.0]), nest=nests)
    ).circles

    assert [(one.joint, one.nest) for one in found] == [(1, 1), (1, 2), (2, 1), (2, 2), (5, 1), (5, 2)]
    assert {len(one.config) for one in found} == {25}


def test_measured_circles_close_to_the_noise_of_the_reflectors(measured_data):
    """Six stops a joint, one direction: ranges are there, waves and backlash are not."""
    if not (measured_data / "single-axis-circles").is_dir():
        pytest.skip("TRUEPOSE_DATA has no folder single-axis-circles")
    test = circle_test(measured_circles(measured_data))
    by_joint = {joint: [one for one in test.circles if one.joint == joint] for joint in range(1, 7)}

    # Reflector 1 is 1.7 mm beside axes 4 and 6.
    assert [(one.joint, one.nest, one.reason.key) for one in test.withheld] == [
        (4, 1, "circles.near"),
        (6, 1, "circles.near"),
    ]
    assert [len(by_joint[joint]) for joint in range(1, 7)] == [3, 3, 3, 2, 3, 2]
    for one in test.circles:
        assert (one.backlash_rad, one.curve.waves) == (None, ())
        # As in Table 2.3: noise, 0.050 mm there; distances of the reflectors scatter by 0.030-0.038 mm here.
        assert one.radial_range_mm < 0.06
        assert one.axial_range_mm < 0.10
    # Reflectors of one body must tell the same angle: within 3 uncertainties of two ranges.
    for circles in by_joint.values():
        for other in circles[1:]:
            first = circles[0].angular_range_rad
            assert abs(other.angular_range_rad.value - first.value) < 3.0 * np.hypot(
                first.standard_uncertainty, other.angular_range_rad.standard_uncertainty
            )
    # Joint 2 carries the whole arm: the largest tangential error, as in the table.
    largest = {
        joint: max(one.tangential_range_mm.value for one in found) for joint, found in by_joint.items()
    }
    assert max(largest, key=largest.get) == 2
    assert largest[2] == pytest.approx(1.79, abs=0.01)


def test_the_others_may_stand_elsewhere_for_each_joint():
    """As a plan has them that keeps a reflector in sight."""
    rests = np.radians([[0, 0, 0, 0, 0, 0], [60, 10, -30, 20, 40, -50], [-20, 30, 0, 0, 70, 10]])
    joints = []
    for joint, rest in zip((2, 4, 2), rests, strict=True):
        rows = turned(joint, there_and_back(-40, 40, 5))
        rest[joint - 1] = 0.0
        joints.append(rows + rest)

    test = circle_test(read_on(IRB_120, np.vstack(joints)))

    assert [one.joint for one in test.circles] == [2, 2, 4]
    assert test.withheld == ()
    for one in test.circles:
        angles_deg = np.degrees(one.errors.angle_rad)
        assert (angles_deg.min(), angles_deg.max()) == (pytest.approx(-40.0), pytest.approx(40.0))
        assert one.tangential_range_mm.value < 1e-6


def test_of_a_circle_that_gross_readings_left_at_three_angles_nothing_is_said():
    angles = [10.0] * 12 + [-50.0, -20.0, 20.0, 45.0]
    joints = turned(1, angles)
    points = read_on(IRB_120, joints, scatter_mm=0.01)
    places = points.position_mm.copy()
    places[12:] += 5.0 * np.random.default_rng(2).standard_normal((4, 3))

    test = circle_test(replace(points, position_mm=places))

    assert test.circles == ()
    assert "Angles measured: 3." in english(test.withheld[0].reason)
