"""Poses of the last frame from the places of its nests, and how far two poses are apart."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import UnderdeterminedError
from truepose.kinematics.frames import cross_matrix, rigid_alignment


@dataclass(frozen=True, slots=True, eq=False)  # arrays: equal means the same object
class Pose:
    """Where the last frame of the arm is, in the frame in which the cups are given."""

    rotation: FloatArray  # (3, 3)
    origin_mm: FloatArray  # (3,)

    @property
    def matrix(self) -> FloatArray:
        """The homogeneous matrix, shape (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self.rotation, self.origin_mm
        return matrix

    def points(self, in_last_frame_mm: FloatArray) -> FloatArray:
        """Return points of the last frame in the frame of the cups, shape (n, 3) [mm]."""
        placed: FloatArray = in_last_frame_mm @ self.rotation.T + self.origin_mm
        return placed


def pose_of(nests_mm: FloatArray, points_mm: FloatArray) -> Pose:
    """Return the pose that brings the nests (3, 3) of the last frame onto these points (3, 3)."""
    return Pose(*rigid_alignment(nests_mm, points_mm))


def pose_covariance(pose: Pose, nests_mm: FloatArray, points_covariance_mm2: FloatArray) -> FloatArray:
    """Return the covariance of a pose from that of its three nests, shape (6, 6).

    Order and units: origin x, y, z [mm], then the turn about x, y, z of the frame of the cups [rad].

    Parameters
    ----------
    pose : Pose
    nests_mm : ndarray, shape (3, 3)
        In the last frame.
    points_covariance_mm2 : ndarray, shape (9, 9)
        As from `cascade.points_covariance`.

    Raises
    ------
    UnderdeterminedError
        The three nests are on a line.
    """
    motion = points_gradient(pose, nests_mm).reshape(9, 6)
    if np.linalg.matrix_rank(motion) < 6:
        raise UnderdeterminedError("The three tool nests are on a line: they show no turn about it.")
    back = np.linalg.pinv(motion)
    covariance: FloatArray = back @ points_covariance_mm2 @ back.T
    return covariance


def points_gradient(pose: Pose, in_last_frame_mm: FloatArray) -> FloatArray:
    """Return the motion of points (n, 3) per shift and turn of the pose, shape (n, 3, 6)."""
    arms = in_last_frame_mm @ pose.rotation.T
    gradient = np.zeros((len(arms), 3, 6))
    gradient[:, :, :3] = np.eye(3)
    gradient[:, :, 3:] = -cross_matrix(arms)
    return gradient


def turn_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the angle between rotations, shape (...) [rad], exact for small ones as for half a turn."""
    # |A - B|^2 = 8 sin^2(angle / 2) in the Frobenius norm
    chord = np.sqrt(((first - second) ** 2).sum(axis=(-2, -1)) / 8.0)
    angle: FloatArray = 2.0 * np.arcsin(np.minimum(chord, 1.0))
    return angle
