import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from truepose_simulators.physics.rigid import (
    from_quaternion,
    inverse,
    move,
    rotation,
    small_motion,
    to_quaternion,
)

# Products of a few rotations in double precision: some 1e-16 each, a hundred of them at most.
ROUNDING = 1e-14


@pytest.mark.parametrize("size_rad", [0.0, 1e-12, 1e-4, 1.0, np.pi - 1e-6])
def test_a_rotation_vector_turns_as_an_independent_library_says(size_rad):
    vectors = size_rad * np.array([[1.0, 0.0, 0.0], [0.6, -0.48, 0.64]])

    turned = rotation(vectors)

    assert turned == pytest.approx(Rotation.from_rotvec(vectors).as_matrix(), abs=ROUNDING)


def test_a_motion_and_its_inverse_leave_a_point_where_it_was():
    poses = small_motion(np.random.default_rng(1).normal(size=(5, 6)))
    point = np.array([100.0, -20.0, 3.0])

    back = move(inverse(poses), move(poses, point))

    assert back == pytest.approx(np.broadcast_to(point, (5, 3)), abs=1e-12)


def test_quaternions_survive_half_turns_about_any_axis():
    axes = np.array([[1.0, 0, 0], [0, 1, 0], [0, 0, 1], [0.6, 0.0, 0.8]])

    for axis in axes:
        turned = rotation(np.pi * axis)
        assert from_quaternion(to_quaternion(turned)) == pytest.approx(turned, abs=ROUNDING)


def test_quaternions_agree_with_an_independent_library():
    reference = Rotation.random(50, rng=np.random.default_rng(2))

    quaternions = np.array([to_quaternion(matrix) for matrix in reference.as_matrix()])

    expected = reference.as_quat(canonical=True, scalar_first=True)
    assert quaternions == pytest.approx(expected, abs=1e-13)
