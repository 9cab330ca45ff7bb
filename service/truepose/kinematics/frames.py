"""Rotations and frames: a rotation matrix takes coordinates in the turned frame to the reference frame.

Conventions of every module that uses these functions, angles in rad, right-handed, c and s cosine and sine:

    RotX(a) RotY(b) RotZ(c)         about axes that the turns before have moved (FramePlacement, body motions)
    q = (w, x, y, z)                quaternions with the real part first, |q| = 1
    R = exp([v]x) = 1 + sin|v|/|v| [v]x + (1 - cos|v|)/|v|^2 [v]x [v]x         (Rodrigues)
    v = log R = angle * axis,       |v| <= pi

with [v]x the matrix of the cross product. Arrays of n vectors are of shape (n, 3), of n rotations (n, 3, 3).

References
----------
J. J. Craig, Introduction to Robotics, 3rd ed., 2005, chapter 2 and appendix B (X-Y-Z Euler angles).
J. Sola, J. Deray, D. Atchuthan, A micro Lie theory for state estimation in robotics, arXiv 1812.01537, 2018.
"""

from math import cos, sin

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement

_LOCKED = 1e-14  # cosine of ry below which rx and rz turn about the same axis as far as doubles can tell


def rotation_x(angle_rad: FloatArray | float) -> FloatArray:
    """Return rotations about x.

    Parameters
    ----------
    angle_rad : float or ndarray, shape (...)

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    return _about(angle_rad, 0)


def rotation_y(angle_rad: FloatArray | float) -> FloatArray:
    """Return rotations about y; parameters and result as of `rotation_x`."""
    return _about(angle_rad, 1)


def rotation_z(angle_rad: FloatArray | float) -> FloatArray:
    """Return rotations about z; parameters and result as of `rotation_x`."""
    return _about(angle_rad, 2)


def _about(angle_rad: FloatArray | float, axis: int) -> FloatArray:
    """Rotations about axis 0, 1 or 2: cos on the other two of the diagonal, sin below it in cyclic order."""
    angle = np.asarray(angle_rad, dtype=float)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    rotation = np.zeros((*angle.shape, 3, 3))
    rotation[..., axis, axis] = 1.0
    rotation[..., first, first] = rotation[..., second, second] = np.cos(angle)
    rotation[..., second, first] = np.sin(angle)
    rotation[..., first, second] = -rotation[..., second, first]
    return rotation


def rotation_xyz(rx_rad: float, ry_rad: float, rz_rad: float) -> FloatArray:
    """Return RotX(rx) RotY(ry) RotZ(rz), multiplied out.

    Parameters
    ----------
    rx_rad, ry_rad, rz_rad : float

    Returns
    -------
    ndarray, shape (3, 3)
    """
    # Base and tool take this way once in every linearisation: in closed form, by the scalar functions of
    # math, it costs a fraction of three small matrices and their products.
    (cx, cy, cz), (sx, sy, sz) = ([f(angle) for angle in (rx_rad, ry_rad, rz_rad)] for f in (cos, sin))
    return np.array([
        [cy * cz, -cy * sz, sy],
        [cx * sz + sx * sy * cz, cx * cz - sx * sy * sz, -sx * cy],
        [sx * sz - cx * sy * cz, sx * cz + cx * sy * sz, cx * cy],
    ])


def turned_axes(angles_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Rotations RotX RotY RotZ of n triples of angles, and the axes about which each of the angles turns.

    A change of the three angles by da turns the frame by sum of da_k axes_k, to first order; in the frame
    before the motion the axes are x, RotX y and RotX RotY z.

    Parameters
    ----------
    angles_rad : ndarray, shape (n, 3)

    Returns
    -------
    rotation : ndarray, shape (n, 3, 3)
    axes : ndarray, shape (3, n, 3)
        Unit vectors; at ry = +-90 deg the first and the last are parallel.
    """
    about_x = rotation_x(angles_rad[:, 0])
    about_xy = about_x @ rotation_y(angles_rad[:, 1])
    axes = np.stack([np.broadcast_to(np.eye(3)[0], angles_rad.shape), about_x[:, :, 1], about_xy[:, :, 2]])
    return about_xy @ rotation_z(angles_rad[:, 2]), axes


def angles_xyz(rotation: FloatArray) -> tuple[float, float, float]:
    """Return rx, ry, rz [rad] of a rotation RotX RotY RotZ; at ry = +-90 deg, rz is 0.

    Close to there rx is ill determined, but the three together are not: ry and rz are those of what
    remains once the chosen rx is undone.

    Parameters
    ----------
    rotation : ndarray, shape (3, 3)

    Returns
    -------
    rx, ry, rz : float
        rx and rz in [-pi, pi], ry in [-pi/2, pi/2].
    """
    # Both arguments of the usual arc tangent are rounding there, and rx would be any angle.
    if np.hypot(rotation[1, 2], rotation[2, 2]) < _LOCKED:
        rx = float(np.arctan2(rotation[2, 1], rotation[1, 1]))
    else:
        rx = float(np.arctan2(-rotation[1, 2], rotation[2, 2]))
    rest = rotation_x(-rx) @ rotation
    return rx, float(np.arctan2(rest[0, 2], rest[2, 2])), float(np.arctan2(rest[1, 0], rest[1, 1]))


def placement_rotation(placement: FramePlacement) -> FloatArray:
    """Return the rotation of a placement, RotX RotY RotZ of its three angles.

    Returns
    -------
    ndarray, shape (3, 3)
        Takes coordinates in the placed frame to the frame in which it is placed.
    """
    return rotation_xyz(placement.rx_rad, placement.ry_rad, placement.rz_rad)


def placement_translation(placement: FramePlacement) -> FloatArray:
    """Return the translation of a placement [mm], shape (3,)."""
    return np.array([placement.x_mm, placement.y_mm, placement.z_mm])


def placement_of(rotation: FloatArray, translation_mm: FloatArray) -> FramePlacement:
    """Return the placement Trans RotX RotY RotZ of a rotation and a translation.

    Parameters
    ----------
    rotation : ndarray, shape (3, 3)
    translation_mm : ndarray, shape (3,)

    Returns
    -------
    FramePlacement
        Angles as of `angles_xyz`.
    """
    rx, ry, rz = angles_xyz(rotation)
    x, y, z = (float(value) for value in translation_mm)
    return FramePlacement(x, y, z, rx, ry, rz)


def rotation_from_quaternion(quaternion: FloatArray) -> FloatArray:
    """Return the rotations of unit quaternions.

    Parameters
    ----------
    quaternion : array_like, shape (..., 4)
        Real part first. One of another length than 1 gives no rotation: whoever reads it normalises it.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    w, x, y, z = np.moveaxis(np.asarray(quaternion, dtype=float), -1, 0)
    rotation = np.empty((*w.shape, 3, 3))
    rotation[..., 0, :] = np.stack([1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)], -1)
    rotation[..., 1, :] = np.stack([2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)], -1)
    rotation[..., 2, :] = np.stack([2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)], -1)
    return rotation


def poses_of(rotation: FloatArray, origin_mm: FloatArray) -> FloatArray:
    """Return homogeneous matrices.

    Parameters
    ----------
    rotation : ndarray, shape (n, 3, 3)
    origin_mm : ndarray, shape (n, 3)

    Returns
    -------
    ndarray, shape (n, 4, 4)
    """
    pose = np.zeros((len(rotation), 4, 4))
    pose[:, :3, :3], pose[:, :3, 3], pose[:, 3, 3] = rotation, origin_mm, 1.0
    return pose


def quaternion_from_rotation(rotation: FloatArray) -> FloatArray:
    """Return unit quaternions of rotations, real part first.

    The ten products 4 q_i q_j are linear in the entries of R. The row of the largest square is taken and
    normalised: its divisor is 2 at least, where that of a fixed row vanishes for some turns.

    Parameters
    ----------
    rotation : array_like, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 4)
        Of q and -q, which are the same rotation, the one whose largest part is positive.

    References
    ----------
    S. W. Shepperd, J. Guidance and Control 1(3), 1978, 223-224.
    """
    r = np.asarray(rotation, dtype=float)
    x, y, z = (r[..., k, k] for k in range(3))
    square = np.stack([1 + x + y + z, 1 + x - y - z, 1 - x + y - z, 1 - x - y + z], axis=-1)
    a, b, c = (r[..., (k + 2) % 3, (k + 1) % 3] - r[..., (k + 1) % 3, (k + 2) % 3] for k in range(3))
    d, e, f = (r[..., (k + 2) % 3, (k + 1) % 3] + r[..., (k + 1) % 3, (k + 2) % 3] for k in range(3))
    s, t, u, v = np.moveaxis(square, -1, 0)
    rows = [[s, a, b, c], [a, t, f, e], [b, f, u, d], [c, e, d, v]]
    products = np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)  # 4 q q^T
    largest = np.argmax(square, axis=-1)[..., None, None]
    chosen = np.take_along_axis(products, largest, axis=-2)[..., 0, :]
    return np.asarray(chosen / np.linalg.norm(chosen, axis=-1, keepdims=True))


def rotation_from_vector(vector_rad: FloatArray) -> FloatArray:
    """Return rotations of rotation vectors, by Rodrigues' formula.

    Parameters
    ----------
    vector_rad : array_like, shape (..., 3)
        Axis times angle; of any length.

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    vector = np.asarray(vector_rad, dtype=float)
    angle = np.linalg.norm(vector, axis=-1)[..., None, None]
    cross = cross_matrix(vector)
    # Through numpy's sinc, sin(pi x) / (pi x), both ratios are right at no turn too, where they are 0 by 0.
    sine_ratio = np.sinc(angle / np.pi)
    cosine_ratio = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    rotation: FloatArray = np.eye(3) + sine_ratio * cross + cosine_ratio * (cross @ cross)
    return rotation


def vector_from_rotation(rotation: FloatArray) -> FloatArray:
    """Return rotation vectors of rotations.

    With s the vector of the antisymmetric part of R, |s| = 2 sin(angle), and angle = atan2(|s|, tr R - 1):
    v = s angle / (2 sin(angle)). Beyond a quarter of a turn the axis a is that of the symmetric part,
    (R + R^T) / 2 - cos(angle) 1 = (1 - cos(angle)) a a^T, with the sense of s.

    Parameters
    ----------
    rotation : ndarray, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (..., 3)
        [rad], of length 0..pi; of half a turn either of the two vectors.
    """
    skew = np.stack(
        [
            rotation[..., 2, 1] - rotation[..., 1, 2],
            rotation[..., 0, 2] - rotation[..., 2, 0],
            rotation[..., 1, 0] - rotation[..., 0, 1],
        ],
        -1,
    )
    sine = 0.5 * np.linalg.norm(skew, axis=-1)
    cosine = 0.5 * (np.trace(rotation, axis1=-2, axis2=-1) - 1.0)
    # By both: an arc cosine alone loses half of the digits of small turns, of which residuals consist.
    angle = np.asarray(np.arctan2(sine, cosine))
    ratio = np.divide(angle, 2 * sine, out=np.full_like(angle, 0.5), where=sine > 1e-9)
    vector: FloatArray = skew * ratio[..., None]
    far = np.asarray(cosine < 0.0)
    if far.any():
        # Towards half a turn s vanishes, and with it the axis: a search would take the turn for none.
        vector[far] = angle[far][:, None] * _axes_of_far_turns(rotation[far], skew[far])
    return vector


def _axes_of_far_turns(rotation: FloatArray, skew: FloatArray) -> FloatArray:
    """Return the axes (n, 3) of n turns of more than a quarter, whose antisymmetric parts are given."""
    cosine = 0.5 * (np.trace(rotation, axis1=1, axis2=2) - 1.0)
    squares = 0.5 * (rotation + np.swapaxes(rotation, 1, 2)) - cosine[:, None, None] * np.eye(3)
    # The column of the largest component: its length is that of the axis, of others it may be rounding alone.
    largest = np.argmax(np.diagonal(squares, axis1=1, axis2=2), axis=1)
    axis = squares[np.arange(len(squares)), largest]
    axis *= np.where((axis * skew).sum(axis=1) < 0.0, -1.0, 1.0)[:, None]
    return np.asarray(axis / np.linalg.norm(axis, axis=1, keepdims=True))


def cross_matrix(vector: FloatArray) -> FloatArray:
    """Return the matrices [v]x of the cross product: [v]x u = v x u.

    Parameters
    ----------
    vector : ndarray, shape (..., 3)

    Returns
    -------
    ndarray, shape (..., 3, 3)
    """
    matrix = np.zeros((*vector.shape[:-1], 3, 3))
    matrix[..., 2, 1], matrix[..., 0, 2], matrix[..., 1, 0] = np.moveaxis(vector, -1, 0)
    return matrix - np.swapaxes(matrix, -1, -2)


def cross(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the cross product of (..., 3) arrays; several times faster than numpy's for short axes.

    Parameters
    ----------
    first, second : ndarray, shape (..., 3)
        Shapes that broadcast.

    Returns
    -------
    ndarray, shape (..., 3)
        A view: in memory the components of the product come first.
    """
    shape = np.broadcast_shapes(first.shape, second.shape)
    result = np.empty((3, *shape[:-1]))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        np.multiply(first[..., i], second[..., j], out=result[k])
        result[k] -= first[..., j] * second[..., i]
    return np.asarray(result.transpose(*range(1, result.ndim), 0))


def directions(vectors: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return unit vectors and lengths.

    Parameters
    ----------
    vectors : ndarray, shape (n, 3)

    Returns
    -------
    unit : ndarray, shape (n, 3)
        Zeros for a vector of no length, which has no direction.
    length : ndarray, shape (n,)
    """
    length = np.linalg.norm(vectors, axis=1)
    return vectors / np.where(length > 0.0, length, 1.0)[:, None], length


def rotate(rotation: FloatArray, vectors: FloatArray) -> FloatArray:
    """Return vectors turned by rotations, R v.

    Parameters
    ----------
    rotation : ndarray, shape (n, 3, 3)
    vectors : ndarray, shape (n, 3) or (3,)

    Returns
    -------
    ndarray, shape (n, 3)
    """
    # Rotations of a chain lie in memory by components (`kinematics.chain`): nine products of whole rows, each
    # contiguous, where a matrix product would gather nine numbers from nine places for each row.
    columns, components = rotation.T, vectors.T
    result = columns[0] * components[0]
    for k in (1, 2):
        result += columns[k] * components[k]
    return np.asarray(result.T)


def rigid_alignment(
    moving: FloatArray, fixed: FloatArray, weights: FloatArray | None = None
) -> tuple[FloatArray, FloatArray]:
    """Rotation and translation that bring `moving` onto `fixed` with least squared distance.

    With the weighted centres taken off: sum of w fixed moving^T = U S V^T, R = U diag(1, 1, det(U V^T)) V^T.

    Parameters
    ----------
    moving, fixed : ndarray, shape (n, 3)
        Points [mm]; n >= 3, not on a line: about that line any turn would be as good.
    weights : ndarray, shape (n,), optional
        Weight of each pair [1]; not all zero.

    Returns
    -------
    rotation : ndarray, shape (3, 3)
    translation_mm : ndarray, shape (3,)

    References
    ----------
    W. Kabsch, Acta Crystallographica A32, 1976, 922-923; reflection excluded after S. Umeyama,
    IEEE Trans. PAMI 13(4), 1991, 376-380.
    """
    share = np.full(len(moving), 1.0 / len(moving)) if weights is None else weights / weights.sum()
    centre_moving, centre_fixed = share @ moving, share @ fixed
    covariance = (fixed - centre_fixed).T @ (share[:, None] * (moving - centre_moving))
    left, _, right = np.linalg.svd(covariance)
    # Three nests are always in a plane: their mirror image fits as well, and must not be taken for a turn.
    mirror = np.diag([1.0, 1.0, np.sign(np.linalg.det(left @ right))])
    rotation = left @ mirror @ right
    return rotation, centre_fixed - rotation @ centre_moving
