"""What a correction is asked for, where the tool shall be, and the joint limits of the controller."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, Table
from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.kinematics.inverse import brought_within

FLANGE: Final = 0  # number of the "nest" that is the origin of the flange frame
_ORTHONORMAL: Final = 1e-6  # what a turn of 1 urad changes


@dataclass(frozen=True, slots=True)
class Goals(Table):
    """Wanted poses of the flange frame in the world; of the position, that of one of its nests; n rows.

    Attributes
    ----------
    stops : Stops
        `joints_rad` are the angles that the search starts from, NaN where none are known; direction of
        approach, time, temperature and mounting are those at which the target will be reached.
    nest : ndarray of int, shape (n,)
        From 1, whose position it is; FLANGE for the origin of the flange frame.
    position_mm : ndarray, shape (n, 3)
    rotation : ndarray, shape (n, 3, 3)
        Of the flange frame.
    """

    stops: Stops
    nest: IntArray  # (n,) from 1, whose position it is; FLANGE for the origin of the flange frame
    position_mm: FloatArray  # (n, 3)
    rotation: FloatArray  # (n, 3, 3)

    def __len__(self) -> int:
        return len(self.nest)

    def at(self, joints_rad: FloatArray) -> Stops:
        """Return the stops with other joint angles.

        Parameters
        ----------
        joints_rad : ndarray, shape (n, J)
        """
        return replace(self.stops, joints_rad=joints_rad)


def of_poses(pose: FloatArray, joints: int) -> Goals:
    """Return goals of the flange frame of which nothing else is known.

    Parameters
    ----------
    pose : ndarray, shape (n, 4, 4)
        In the world [mm].
    joints : int
        Number of joints of the arm.

    Raises
    ------
    ConfigurationError
        A rotation is none.
    """
    n = len(pose)
    check_rotations(pose[:, :3, :3])
    stops = Stops(np.arange(n), np.full((n, joints), np.nan))
    return Goals(stops, np.full(n, FLANGE), pose[:, :3, 3], pose[:, :3, :3])


def check_rotations(rotation: FloatArray) -> None:
    """Refuse what is no rotation.

    Parameters
    ----------
    rotation : ndarray, shape (n, 3, 3)

    Raises
    ------
    ConfigurationError
        A matrix is not orthonormal to 1e-6, not finite, or left-handed; the first such row is named.
    """
    with np.errstate(invalid="ignore"):  # of infinity too the result is NaN
        off = np.abs(rotation @ np.swapaxes(rotation, 1, 2) - np.eye(3)).max(axis=(1, 2))
    # NaN compares false with every limit: it must not pass as being below it.
    wrong = ~(off <= _ORTHONORMAL)
    if wrong.any():
        raise ConfigurationError(
            f"The orientation of row {int(np.argmax(wrong))} is not a rotation: its axes are not orthogonal "
            "unit vectors."
        )
    # An orthonormal matrix may still mirror: lengths of 1 and right angles do not show it.
    mirrored = np.linalg.det(rotation) < 0.0
    if mirrored.any():
        raise ConfigurationError(
            f"The orientation of row {int(np.argmax(mirrored))} is left-handed. Reverse one of its axes."
        )


# Corrections turn joints by tenths of a degree; near a singularity they would turn one by any angle.
FAR_RAD: Final = float(np.deg2rad(5.0))


def turned_within(
    limits: tuple[JointRange, ...] | None, joints_rad: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Turn joints by whole turns into their limits, and say which rows are within.

    Parameters
    ----------
    limits : tuple of JointRange, or None
        None: unknown; joints stay as they are, and all rows count as within.
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    joints_rad : ndarray, shape (n, J)
    within : ndarray of bool, shape (n,)
    """
    if limits is None:
        return joints_rad, np.ones(len(joints_rad), dtype=bool)
    return brought_within(joints_rad, limits)


def beyond(limits: tuple[JointRange, ...] | None, joints_rad: FloatArray) -> FloatArray:
    """Return by how much each joint is beyond its limits.

    Parameters
    ----------
    limits : tuple of JointRange, or None
    joints_rad : ndarray, shape (n, J)

    Returns
    -------
    ndarray, shape (n, J)
        [rad]; 0 within, NaN where limits or joints are unknown.
    """
    if limits is None:
        return np.full_like(joints_rad, np.nan)
    low, high = (np.array(ends) for ends in zip(*((r.lower_rad, r.upper_rad) for r in limits), strict=True))
    return np.asarray(np.maximum(np.maximum(low - joints_rad, joints_rad - high), 0.0))
