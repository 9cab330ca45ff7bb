"""What the closed forms share: branches side by side, vectors by components, joint 1, cosines beyond 1.

Arrays have branches first (back, down, flip) and poses last: (2, 2, 2, n) where all branches are asked for.
"""

from collections.abc import Callable
from typing import Final, NamedTuple, TypeAlias

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.robot import Robot

STRUCTURE_RAD: Final = 1e-9  # twists this close to a right angle are one; tables are written in whole degrees
STRUCTURE_MM: Final = 1e-9
LOCKED: Final = 1e-10  # sine of joint 5 below which two joints turn about the same line
_STRETCHED: Final = 1e-10  # cosines may pass 1 by rounding where the arm is just stretched: less than 1e-7 mm
_NEARLY_STRAIGHT: Final = float(np.cos(np.deg2rad(5.0)))  # from a straight arm no step leads inwards
Vector: TypeAlias = tuple[FloatArray, FloatArray, FloatArray]  # components
Ratio: TypeAlias = Callable[[FloatArray], FloatArray]  # what to do with cosines and sines beyond 1


class Branches(NamedTuple):
    """Branches, 0 or 1 each; of shapes that come together to (back, down, flip, poses)."""

    back: IntArray
    down: IntArray
    flip: IntArray


class Poses(NamedTuple):
    """Poses of the flange frame in front of joint 1, row 1 of the table taken off."""

    x_axis: FloatArray  # (3, n)
    z_axis: FloatArray  # (3, n)
    wrist_mm: FloatArray  # (3, n) where axis 5 meets axis 6, from the origin of frame 1


ALL: Final = Branches(*(np.arange(2).reshape(shape) for shape in ((2, 1, 1, 1), (1, 2, 1, 1), (1, 1, 2, 1))))


def column(planes: FloatArray) -> Vector:
    """Return the components of vectors, in the shape in which the forms compute.

    Parameters
    ----------
    planes : ndarray, shape (3, n)

    Returns
    -------
    tuple of three ndarray, shape (1, 1, 1, n) each
    """
    x, y, z = (plane[None, None, None] for plane in planes)
    return x, y, z


def turned_back(vector: Vector, alpha_rad: float, theta_rad: FloatArray | float) -> Vector:
    """Return vectors as a frame sees them that RotX(alpha) RotZ(theta) turned: RotZ(-theta) RotX(-alpha) v.

    Parameters
    ----------
    vector : tuple of three ndarray
    alpha_rad : float
    theta_rad : float or ndarray, of a shape that broadcasts with the components
    """
    x, y, z = vector
    c, s = float(np.cos(alpha_rad)), float(np.sin(alpha_rad))
    y, z = c * y + s * z, c * z - s * y
    cosine, sine = np.cos(theta_rad), np.sin(theta_rad)
    return cosine * x + sine * y, cosine * y - sine * x, z


def column_angle(robot: Robot, wrist: FloatArray, which: Branches, ratio: Ratio) -> FloatArray:
    """Return theta_1, shape (2, 1, 1, n): the column turns until axis 2 passes the wrist at its distance.

    With r, phi the wrist in polar coordinates about axis 1 and m its coordinate along axis 2,
    y cos(theta) - x sin(theta) = m is sin(phi - theta) = m / r; m is what d_2, d_3 and d_4 come to along axis
    2.

    Parameters
    ----------
    robot : Robot
    wrist : ndarray, shape (3, n)
        [mm], in front of joint 1.
    which : Branches
    ratio : callable
        `clip_rounding` or `within_reach`.

    References
    ----------
    J. J. Craig, Introduction to Robotics, 3rd ed., 2005, section 4.7 (the PUMA 560).
    """
    upper, elbow, forearm = robot.joints[1:4]
    # Offsets along parallel axes add up to one distance from the plane through axis 1, on whichever row they
    # stand.
    along_axis_2 = upper.d_mm + np.cos(elbow.alpha_rad) * elbow.d_mm
    along_axis_2 += np.cos(elbow.alpha_rad) * np.cos(forearm.alpha_rad) * forearm.d_mm
    distance = np.hypot(wrist[0], wrist[1])
    on_axis = (distance < STRUCTURE_MM) & (abs(along_axis_2) < STRUCTURE_MM)
    # With the wrist on axis 1 and no offset every theta_1 is as good; 0 / 0 would say that there is none.
    share = np.where(on_axis, 0.0, -along_axis_2 / np.sin(upper.alpha_rad) / distance)
    aside, direction = np.arcsin(ratio(share)), np.arctan2(wrist[1], wrist[0])
    # Front and back differ by half a turn of the column, with the shoulder's offset on the other side of the
    # wrist.
    return np.asarray(np.where(which.back, direction - np.pi + aside, direction - aside))


def same_way(robot: Robot) -> float:
    """Say how axis 3 points: +1 the same way as axis 2, else -1, that is cos(alpha_3)."""
    return float(np.sign(np.cos(robot.joints[2].alpha_rad)))


def positive_side(robot: Robot) -> float:
    """Sign of sin(theta_5) at a small positive angle of joint 5, its offset included."""
    row = robot.joints[4]
    # A millionth of a radian beside zero: at zero itself the sine of an offset of 0 or 180 deg says nothing.
    return 1.0 if np.sin(row.theta_offset_rad + row.sign * 1e-6) > 0.0 else -1.0


def is_beyond(side: FloatArray, rounding: float) -> BoolArray:
    """Say what is on the negative side of where two branches meet; in their midst the lower one counts.

    Parameters
    ----------
    side : ndarray, shape (n,)
        0 where they meet.
    rounding : float
        Less is 0: the sine of an offset of half a turn is 1e-16, of either sign.
    """
    return np.asarray(side < -rounding)


def clip_rounding(ratio: FloatArray) -> FloatArray:
    """Bring ratios that pass 1 by rounding alone back to it; those beyond stay: their arc functions are NaN.

    Parameters
    ----------
    ratio : ndarray
        Sines or cosines [1].
    """
    return np.where(np.abs(np.abs(ratio) - 1.0) < _STRETCHED, np.sign(ratio), ratio)


def within_reach(ratio: FloatArray) -> FloatArray:
    """Bring ratios of unreachable poses to an arm that is nearly straight or folded; others stay as they are.

    Parameters
    ----------
    ratio : ndarray
        Sines or cosines [1].
    """
    return np.where(np.abs(ratio) < 1.0, ratio, np.sign(ratio) * _NEARLY_STRAIGHT)
