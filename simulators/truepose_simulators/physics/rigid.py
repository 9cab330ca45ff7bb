"""Rigid motions as 4x4 matrices, any number at once, and the one that brings points onto others best.

Source: K. M. Lynch, F. C. Park, Modern Robotics, 2017, chapters 3.2 (rotations) and 3.3 (screws); W. Kabsch,
Acta Cryst. A 32, 1976, 922-923 (registration).
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
    """Homogeneous matrices from translations (..., 3) [mm] and rotations (..., 3, 3)."""
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
    """Quaternions w, x, y, z with w >= 0 of rotations, shape (..., 3, 3) -> (..., 4).

    The largest eigenvector of Bar-Itzhack's matrix: no case distinction, no loss near half a turn.
    """
    (a, b, c), (d, e, f), (g, h, i) = np.moveaxis(rotation_matrix, (-2, -1), (0, 1))
    symmetric = np.array([
        [a + e + i, h - f, c - g, d - b],
        [h - f, a - e - i, b + d, c + g],
        [c - g, b + d, e - a - i, f + h],
        [d - b, c + g, f + h, i - a - e],
    ])
    quaternion = np.linalg.eigh(np.moveaxis(symmetric, (0, 1), (-2, -1)))[1][..., -1]
    positive: FloatArray = np.where(quaternion[..., :1] >= 0.0, quaternion, -quaternion)
    return positive


def to_rotation_vector(rotation_matrix: FloatArray) -> FloatArray:
    """Rotation vectors [rad] of rotations, of half a turn too, shape (..., 3, 3) -> (..., 3)."""
    quaternion = to_quaternion(rotation_matrix)
    sine = np.linalg.norm(quaternion[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, quaternion[..., :1])
    # The vector is angle / sine times the vector part; without a turn that ratio tends to 2.
    ratio = np.divide(angle, sine, out=np.full_like(angle, 2.0), where=sine > 0.0)
    vector: FloatArray = ratio * quaternion[..., 1:]
    return vector


def to_six(pose: FloatArray) -> FloatArray:
    """`[tx ty tz rx ry rz]` of which `small_motion` makes these motions, shape (..., 4, 4) -> (..., 6)."""
    return np.concatenate([pose[..., :3, 3], to_rotation_vector(pose[..., :3, :3])], axis=-1)


def pose_matrix(translation_mm: FloatArray, angles_rad: FloatArray) -> FloatArray:
    """Trans RotX RotY RotZ, in that order, from shapes (..., 3) [mm] and (..., 3) [rad]."""
    x, y, z = (rotation(angles_rad * axis) for axis in np.eye(3))
    return motion(translation_mm, x @ y @ z)


def register(from_mm: FloatArray, onto_mm: FloatArray) -> FloatArray:
    """Return the motion, shape (4, 4), of points (m, 3) onto others in the least squares sense."""
    centre_from, centre_onto = from_mm.mean(axis=0), onto_mm.mean(axis=0)
    u, _, vt = np.linalg.svd((onto_mm - centre_onto).T @ (from_mm - centre_from))
    # Three points, or any in a plane, fit their mirror image as well; the sign keeps it a rotation.
    handed = np.diag([1.0, 1.0, float(np.sign(np.linalg.det(u @ vt)))])
    turned = u @ handed @ vt
    return motion(centre_onto - turned @ centre_from, turned)
