r"""Poses of the flange frame from the places of nests, how far two are apart, how well one is known.

An artefact whose pose is read: where its nests have their centre, and how exactly a pose is known there.
Nests whose coordinates err by sigma each, all alike, give a rigid body the errors

    of its centre        sigma / sqrt(K)                             per axis
    of its turn          sigma sqrt(tr((sum of (|r|^2 I - r r^T))^-1) / 3)      per axis, RMS of the three

for K nests at r from their centre; at the centre, and nowhere else, the two have nothing in common. A
rigid body keeps six of the 3 K errors, so that its nests err by sigma sqrt(2 / K) only: this is what
instruments state.
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import UnderdeterminedError
from truepose.kinematics.frames import cross_matrix, rigid_alignment


@dataclass(frozen=True, slots=True, eq=False)  # arrays: equal means the same object
class Pose:
    """Where the flange frame of the arm is, in the frame in which the cups are given.

    A point x of the flange frame is at R x + o there.

    Attributes
    ----------
    rotation : ndarray, shape (3, 3)
    origin_mm : ndarray, shape (3,)
    """

    rotation: FloatArray  # (3, 3)
    origin_mm: FloatArray  # (3,)

    @property
    def matrix(self) -> FloatArray:
        """The homogeneous matrix, shape (4, 4)."""
        matrix = np.eye(4)
        matrix[:3, :3], matrix[:3, 3] = self.rotation, self.origin_mm
        return matrix

    def points(self, in_last_frame_mm: FloatArray) -> FloatArray:
        """Return points of the flange frame in the frame of the cups.

        Parameters
        ----------
        in_last_frame_mm : ndarray, shape (n, 3)

        Returns
        -------
        ndarray, shape (n, 3)
            [mm]
        """
        placed: FloatArray = in_last_frame_mm @ self.rotation.T + self.origin_mm
        return placed


def pose_of(nests_mm: FloatArray, points_mm: FloatArray) -> Pose:
    """Return the pose that brings the nests of the flange frame onto points, by least squares.

    Parameters
    ----------
    nests_mm : ndarray, shape (3, 3)
        In the flange frame, one in each row.
    points_mm : ndarray, shape (3, 3)
        Where they are, in the frame of the cups.
    """
    return Pose(*rigid_alignment(nests_mm, points_mm))


def pose_covariance(pose: Pose, nests_mm: FloatArray, points_covariance_mm2: FloatArray) -> FloatArray:
    """Return the covariance of a pose from that of its three nests.

    With G = d(points) / d(pose), shape (9, 6), least squares give C = G^+ C_points G^+T.

    Parameters
    ----------
    pose : Pose
    nests_mm : ndarray, shape (3, 3)
        In the flange frame.
    points_covariance_mm2 : ndarray, shape (9, 9)
        As from `cascade.points_covariance`.

    Returns
    -------
    ndarray, shape (6, 6)
        Of the origin x, y, z [mm], then of the turn about x, y, z of the frame of the cups [rad].

    Raises
    ------
    UnderdeterminedError
        The three nests are on a line.
    """
    # By rank and not by the pivots of a solution: nests on a line leave one turn free, whatever the frame is.
    motion = points_gradient(pose, nests_mm).reshape(9, 6)
    if np.linalg.matrix_rank(motion) < 6:
        raise UnderdeterminedError(
            "The three tool nests lie on a line, so rotation about it cannot be determined."
        )
    back = np.linalg.pinv(motion)
    covariance: FloatArray = back @ points_covariance_mm2 @ back.T
    return covariance


def points_gradient(pose: Pose, in_last_frame_mm: FloatArray) -> FloatArray:
    """Return the motion of points per shift and turn of the pose: [1, -[R x]x].

    Parameters
    ----------
    pose : Pose
    in_last_frame_mm : ndarray, shape (n, 3)

    Returns
    -------
    ndarray, shape (n, 3, 6)
        mm per mm of a shift, then mm per rad of a turn about the flange's origin, along the axes of
        the cups' frame.
    """
    arms = in_last_frame_mm @ pose.rotation.T
    gradient = np.zeros((len(arms), 3, 6))
    gradient[:, :, :3] = np.eye(3)
    gradient[:, :, 3:] = -cross_matrix(arms)
    return gradient


def turn_between(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return the angle of the turn from one rotation to another.

    From |A - B|^2 = 8 sin^2(angle / 2) in the Frobenius norm.

    Parameters
    ----------
    first, second : ndarray, shape (..., 3, 3)

    Returns
    -------
    ndarray, shape (...)
        [rad], in 0..pi; exact for small angles as for half a turn.
    """
    # |A - B|^2 = 8 sin^2(angle / 2) in the Frobenius norm
    # Rounding may carry the chord beyond 1 at half a turn, where the arc sine would be NaN.
    chord = np.sqrt(((first - second) ** 2).sum(axis=(-2, -1)) / 8.0)
    angle: FloatArray = 2.0 * np.arcsin(np.minimum(chord, 1.0))
    return angle


_OF_A_RIGID_BODY = 6.0


@dataclass(frozen=True, slots=True)
class PoseUncertainty:
    """Standard uncertainties per axis of a pose, read at the artefact's centre.

    Attributes
    ----------
    position_mm : float
    rotation_rad : float
        RMS of the three axes.
    """

    position_mm: float
    rotation_rad: float


def centre(nests_mm: FloatArray) -> FloatArray:
    """Return the centre of K nests.

    Parameters
    ----------
    nests_mm : ndarray, shape (K, 3)

    Returns
    -------
    ndarray, shape (3,)
        [mm]
    """
    return np.asarray(nests_mm.mean(axis=0))


def pose_uncertainty(nests_mm: FloatArray, nest_mm: float) -> PoseUncertainty:
    """Return how exactly a pose is known whose nests are known to `nest_mm` per coordinate.

    The formulas of the module's head, solved for sigma = nest_mm sqrt(K / 2) first.

    Parameters
    ----------
    nests_mm : ndarray, shape (K, 3)
        K >= 3, not on a line.
    nest_mm : float
        Standard uncertainty per coordinate of the nests of the artefact as placed.

    Raises
    ------
    UnderdeterminedError
        The nests are in one place or on a line.
    """
    arms = nests_mm - centre(nests_mm)
    if np.linalg.matrix_rank(arms) < 2:
        raise UnderdeterminedError("The nests lie on a line, so rotation about it cannot be determined.")
    # What is stated is how far the nests of the fitted body are off; the readings themselves err by more.
    sigma_mm = nest_mm * np.sqrt(nests_mm.size / _OF_A_RIGID_BODY)
    squares = (arms**2).sum() * np.eye(3) - arms.T @ arms
    turn = sigma_mm * np.sqrt(np.trace(np.linalg.inv(squares)) / 3.0)
    return PoseUncertainty(float(sigma_mm / np.sqrt(len(arms))), float(turn))


def normal(nests_mm: FloatArray) -> FloatArray:
    """Return the normal of the plane that lies nearest to the nests, away from the flange frame's origin.

    Of the singular vectors of the nests about their centre the one of the smallest singular value: all nests
    count alike, in whatever order they are numbered.

    Parameters
    ----------
    nests_mm : ndarray, shape (K, 3)
        K >= 3, not on a line. In the flange frame.

    Returns
    -------
    ndarray, shape (3,)
        Of length 1.
    """
    middle = centre(nests_mm)
    across = np.linalg.svd(nests_mm - middle)[2][2]
    # Targets of a flat artefact look away from the arm that carries it.
    return np.asarray(across if across @ middle >= 0.0 else -across)
