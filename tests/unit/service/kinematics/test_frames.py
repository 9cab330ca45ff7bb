import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from truepose.domain.robot import FramePlacement
from truepose.kinematics.frames import (
    angles_xyz,
    cross,
    placement_of,
    placement_rotation,
    placement_translation,
    poses_of,
    quaternion_from_rotation,
    rigid_alignment,
    rotation_from_quaternion,
    rotation_from_vector,
    rotation_xyz,
    turned_axes,
    vector_from_rotation,
)

ANGLE = st.floats(-3.0, 3.0)


@given(ANGLE, st.floats(-1.5, 1.5), ANGLE)
def test_angles_come_back_from_the_rotation_they_made(rx, ry, rz):
    rotation = rotation_xyz(rx, ry, rz)

    assert rotation_xyz(*angles_xyz(rotation)) == pytest.approx(rotation, abs=1e-12)
    assert rotation == pytest.approx(Rotation.from_euler("XYZ", [rx, ry, rz]).as_matrix(), abs=1e-12)


@pytest.mark.parametrize("off_rad", [0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1e-6, 1e-4])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_at_and_near_the_gimbal_lock_the_rotation_is_still_right(off_rad, sign):
    rotation = rotation_xyz(0.4, sign * (np.pi / 2 - off_rad), 0.3)

    # rounding alone: a robot on a wall loses nothing
    assert rotation_xyz(*angles_xyz(rotation)) == pytest.approx(rotation, abs=1e-14)


def test_at_the_gimbal_lock_the_last_angle_is_zero():
    assert angles_xyz(rotation_xyz(0.4, np.pi / 2, 0.3)) == pytest.approx((0.7, np.pi / 2, 0.0), abs=1e-9)


@given(st.tuples(ANGLE, ANGLE, ANGLE).map(np.array).filter(lambda v: np.linalg.norm(v) < 3.0))
def test_rotation_vectors_agree_with_an_independent_library(vector):
    rotation = rotation_from_vector(vector)

    assert rotation == pytest.approx(Rotation.from_rotvec(vector).as_matrix(), abs=1e-12)
    assert vector_from_rotation(rotation) == pytest.approx(vector, abs=1e-12)


@pytest.mark.parametrize("off_rad", [0.0, 1e-15, 1e-12, 1e-10, 1e-8, 1e-6, 1e-3])
@pytest.mark.parametrize("axis", [(0, 0, 1), (1, 0, 0), (-0.6, 0.0, 0.8), (0.36, -0.8, -0.48)])
def test_at_and_near_half_a_turn_a_rotation_vector_still_has_its_axis_and_angle(off_rad, axis):
    vector = (np.pi - off_rad) * np.array(axis)

    found = vector_from_rotation(rotation_from_vector(vector))

    # nearer to half a turn than rounding, v and -v are the same rotation
    same = found if off_rad > 1e-14 or found @ vector > 0.0 else -found
    assert same == pytest.approx(vector, abs=1e-14)


def test_quaternions_have_w_first():
    random = Rotation.random(5, rng=np.random.default_rng(1))
    quaternion = np.roll(random.as_quat(), 1, axis=1)

    assert rotation_from_quaternion(quaternion) == pytest.approx(random.as_matrix(), abs=1e-12)


@pytest.mark.parametrize("largest", range(4))
def test_a_quaternion_comes_back_from_its_rotation_whichever_part_is_the_largest(largest):
    quaternion = np.array([0.2, -0.3, 0.1, -0.25])
    quaternion[largest] = 0.9
    quaternion /= np.linalg.norm(quaternion)

    assert quaternion_from_rotation(rotation_from_quaternion(quaternion)) == pytest.approx(quaternion)
    assert quaternion_from_rotation(rotation_from_quaternion(-quaternion)) == pytest.approx(quaternion)


def test_a_placement_is_its_translation_and_its_rotation():
    placement = FramePlacement(10.0, -20.0, 30.0, 0.1, -0.2, 0.3)

    rotation, translation = placement_rotation(placement), placement_translation(placement)
    again = placement_of(rotation, translation)

    assert rotation == pytest.approx(Rotation.from_euler("XYZ", [0.1, -0.2, 0.3]).as_matrix())
    assert translation.tolist() == [10.0, -20.0, 30.0]
    assert vars_of(again) == pytest.approx(vars_of(placement))
    pose = poses_of(rotation[None], translation[None])[0]
    assert pose @ [0.0, 0.0, 0.0, 1.0] == pytest.approx([10.0, -20.0, 30.0, 1.0])
    assert pose[:3, :3].tolist() == rotation.tolist()


def vars_of(placement):
    return [getattr(placement, name) for name in ("x_mm", "y_mm", "z_mm", "rx_rad", "ry_rad", "rz_rad")]


def test_each_of_three_angles_turns_a_frame_about_its_axis():
    angles, step = np.array([[0.3, -0.7, 1.1], [-2.0, 0.4, 0.0]]), 1e-6

    rotation, axes = turned_axes(angles)

    assert rotation == pytest.approx(np.stack([rotation_xyz(*one) for one in angles]))
    for k, axis in enumerate(axes):
        ahead, _ = turned_axes(angles + step * np.eye(3)[k])
        turned = vector_from_rotation(ahead @ np.swapaxes(rotation, 1, 2)) / step
        assert axis == pytest.approx(turned, abs=1e-8)


def test_cross_products_agree_with_numpy():
    first, second = np.random.default_rng(2).normal(size=(2, 7, 4, 3))

    assert cross(first, second) == pytest.approx(np.cross(first, second), abs=1e-14)


def test_alignment_finds_the_motion_between_two_clouds_and_never_a_mirror():
    rng = np.random.default_rng(3)
    points, rotation = rng.normal(size=(8, 3)) * 500.0, rotation_xyz(0.3, -0.8, 2.0)
    flat = points * np.array([1.0, 1.0, 0.0])  # a plane, in which a mirror fits as well

    for cloud in (points, flat):
        found, shift = rigid_alignment(cloud, cloud @ rotation.T + [1.0, 2.0, 3.0])

        assert found == pytest.approx(rotation, abs=1e-9)
        assert shift == pytest.approx([1.0, 2.0, 3.0], abs=1e-9)
    assert np.linalg.det(rigid_alignment(points, points * [1.0, 1.0, -1.0])[0]) == pytest.approx(1.0)


def test_a_point_without_weight_does_not_move_the_alignment():
    points = np.random.default_rng(4).normal(size=(6, 3)) * 100.0
    spoilt = points.copy()
    spoilt[0] += 50.0

    rotation, shift = rigid_alignment(points, spoilt, np.array([0.0, 1, 1, 1, 1, 1]))

    assert rotation == pytest.approx(np.eye(3), abs=1e-12)
    assert shift == pytest.approx(np.zeros(3), abs=1e-10)
