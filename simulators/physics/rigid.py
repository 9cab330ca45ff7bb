"""Rigid motions as 4x4 matrices, any number at once.

Source: K. M. Lynch, F. C. Park, Modern Robotics, 2017, chapters 3.2 (rotations) and 3.3 (screws).
"""

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]


def cross_matrix(vector: FloatArray) -> FloatArray:
    """Matrices K with K b = vector x b, shape (..., 3) -> (..., 3, 3)."""
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    rows = [[zero, -z, y], [z, zero, -x], [-y, x, zero]]
    matrix: FloatArray = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
    return matrix


def rotation(vector_rad: FloatArray) -> FloatArray:
    """Rotations about the rotation vectors [rad], shape (..., 3) -> (..., 3, 3) (Rodrigues)."""
    angle = np.linalg.norm(vector_rad, axis=-1)[..., np.newaxis, np.newaxis]
    k = cross_matrix(vector_rad)
    # sinc keeps both coefficients exact down to an angle of zero
    sine = np.sinc(angle / np.pi)
    versine = 0.5 * np.sinc(angle / (2.0 * np.pi)) ** 2
    turned: FloatArray = np.eye(3) + sine * k + versine * (k @ k)
    return turned


def motion(translation_mm: FloatArray, rotation_matrix: FloatArray) -> FloatArray:
    """Homogenous matrices from translations (..., 3) [mm] and rotations (..., 3, 3)."""
    shape = np.broadcast_shapes(translation_mm.shape[:-1], rotation_matrix.shape[:-2])
    result = np.zeros((*shape, 4, 4))
    result[..., :3, :3] = rotation_matrix
    result[..., :3, 3] = translation_mm
    result[..., 3, 3] = 1.0
    return result


def small_motion(six: FloatArray) -> FloatArray:
    """Motions from `[tx ty tz rx ry rz]` [mm, rad], shape (..., 6) -> (..., 4, 4).

    The rotation vector turns, then the translation moves along the axes before the rotation.
    """
    return motion(six[..., :3], rotation(six[..., 3:]))


def inverse(pose: FloatArray) -> FloatArray:
    """Inverse of rigid motions, shape (..., 4, 4)."""
    transposed = np.swapaxes(pose[..., :3, :3], -1, -2)
    return motion(-apply(transposed, pose[..., :3, 3]), transposed)


def apply(rotation_matrix: FloatArray, vector: FloatArray) -> FloatArray:
    """Turn vectors: (..., 3, 3) times (..., 3)."""
    turned: FloatArray = np.einsum("...ij,...j->...i", rotation_matrix, vector)
    return turned


def move(pose: FloatArray, point_mm: FloatArray) -> FloatArray:
    """Move points: (..., 4, 4) times (..., 3) [mm]."""
    return apply(pose[..., :3, :3], point_mm) + pose[..., :3, 3]


def from_quaternion(quaternion: FloatArray) -> FloatArray:
    """Rotation of a quaternion w, x, y, z of any length but zero, shape (4,) -> (3, 3)."""
    w, x, y, z = quaternion / np.linalg.norm(quaternion)
    k = cross_matrix(np.array([x, y, z]))
    turned: FloatArray = np.eye(3) + 2.0 * w * k + 2.0 * (k @ k)
    return turned


def to_quaternion(rotation_matrix: FloatArray) -> FloatArray:
    """Quaternion w, x, y, z with w >= 0 of a rotation, shape (3, 3) -> (4,).

    The largest eigenvector of Bar-Itzhack's matrix: no case distinction, no loss near half a turn.
    """
    (a, b, c), (d, e, f), (g, h, i) = rotation_matrix
    symmetric = np.array([
        [a + e + i, h - f, c - g, d - b],
        [h - f, a - e - i, b + d, c + g],
        [c - g, b + d, e - a - i, f + h],
        [d - b, c + g, f + h, i - a - e],
    ])
    quaternion: FloatArray = np.linalg.eigh(symmetric)[1][:, -1]
    return quaternion if quaternion[0] >= 0.0 else -quaternion
