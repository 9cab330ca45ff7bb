r"""Joint axes, as lines in space, to a DH-Modified table.

Frame i has its z along axis i. Where axes i and i+1 are skew or meet, origin and x of frame i lie on their
common normal, and `alpha, a` of row i+1 follow. With axes p + s u and q + t v, n = u x v, it meets them at

    s = ((q - p) x v) . n / n.n        t = ((q - p) x u) . n / n.n

Where they are nearly parallel that normal may lie kilometres away, and rounding with it; there the origin of
frame i stays at the foot of the normal before (its `d` is 0), x points to where axis i+1 passes through the
plane z = 0 of frame i, and beta takes what alpha cannot (Hayati). Of the two senses of x it is the one that
turns less from the x before. The row from one frame to the next is read off B^-1 F:

    z = (sin(beta), -sin(alpha) cos(beta), cos(alpha) cos(beta)),    o = (a, 0, 0) + d z

References
----------
J. J. Craig, Introduction to Robotics, 3rd ed., 2005, section 3.4.
S. A. Hayati, Proc. 22nd IEEE Conf. Decision and Control, 1983, 1477-1483.
docs/decisions/0042 (why nearly parallel axes have a beta, and where the limit lies).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRow
from truepose.kinematics.frames import rotation_x, rotation_y

# As the geometry's errors have it: below this angle the normal moves by more than 30 mm per mm of an axis.
_PARALLEL: Final = float(np.sin(np.deg2rad(2.0)))
_SAME_PLACE_MM: Final = 1e-6  # axes that pass each other closer than a nanometre show no direction
_ROUNDING_RAD: Final = 1e-15
_SAME_WAY: Final = 1e-9  # of a unit vector left in a plane, below which it shows no direction there


@dataclass(frozen=True, slots=True)
class JointAxis:
    """One axis while all joints read zero.

    Attributes
    ----------
    point_mm : ndarray, shape (3,)
        Any point of it.
    direction : ndarray, shape (3,)
        Its z, of length 1.
    sign : int
        -1 where the joint counts against `direction`.
    """

    point_mm: FloatArray
    direction: FloatArray
    sign: int = 1  # -1: the joint counts against `direction`


@dataclass(frozen=True, slots=True)
class Table:
    """The table of some axes, and where its first and flange frames are while all joints read zero.

    Attributes
    ----------
    rows : tuple of JointRow
        J of them.
    base : ndarray, shape (4, 4)
        Frame 0 [mm].
    frames : ndarray, shape (J, 4, 4)
        Frames 1..J [mm].
    """

    rows: tuple[JointRow, ...]
    base: FloatArray  # (4, 4) of frame 0
    frames: FloatArray  # (J, 4, 4) of frames 1..J


def table_of(axes: Sequence[JointAxis], base: FloatArray, tip: FloatArray) -> Table:
    """Return the DH-Modified table of axes.

    Parameters
    ----------
    axes : sequence of JointAxis
        J >= 1, in the order of the joints.
    base : ndarray, shape (4, 4)
        Frame 0 is the one on axis 1 that is nearest to it: this one, where axis 1 is its z.
    tip : ndarray, shape (4, 4)
        Frame J is the one on the last axis that is nearest to it.

    Returns
    -------
    Table
        Its forward kinematics is that of the axes, to rounding, at any tilt. Whoever needs the tip itself
        keeps its motion from the flange frame beside the table.
    """
    first = _on_axis(axes[0], base)
    frames = _frames(axes, first, tip)
    befores = [first, *frames[:-1]]
    rows = [_row(before, frame, axis.sign) for before, frame, axis in zip(befores, frames, axes, strict=True)]
    return Table(tuple(rows), first, np.array(frames))


def _frames(axes: Sequence[JointAxis], first: FloatArray, tip: FloatArray) -> list[FloatArray]:
    """Place frames 1..J on their axes."""
    frames, before = [], first
    for axis, following in pairwise(axes):
        before = _towards(axis, following, before)
        frames.append(before)
    return [*frames, _on_axis(axes[-1], tip)]


def _towards(axis: JointAxis, following: JointAxis, before: FloatArray) -> FloatArray:
    """Return the frame on an axis whose x leads to the axis that follows."""
    normal = np.cross(axis.direction, following.direction)
    if np.linalg.norm(normal) > _PARALLEL:
        foot, end = _feet(axis, following, normal)
    else:
        # The common normal may be kilometres away; at the foot of the one before, lengths stay those of the
        # arm, which planning, priors and checks of plausibility take them for.
        foot = _nearest_foot(axis, before)
        along = (foot - following.point_mm) @ axis.direction / (following.direction @ axis.direction)
        end = following.point_mm + along * following.direction
        # For axes that run through each other: no direction leads from one to the other, and x stays as it
        # was.
        normal = np.asarray(before[:3, 0])
    across = end - foot
    x = across if np.linalg.norm(across) > _SAME_PLACE_MM else normal
    return _frame(axis, foot, -x if x @ before[:3, 0] < -_SAME_WAY * np.linalg.norm(x) else x)


def _feet(axis: JointAxis, following: JointAxis, normal: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return where the common normal of two skew axes meets each of them; formula in the module's head."""
    between, square = following.point_mm - axis.point_mm, normal @ normal
    here = np.cross(between, following.direction) @ normal / square
    there = np.cross(between, axis.direction) @ normal / square
    return axis.point_mm + here * axis.direction, following.point_mm + there * following.direction


def _nearest_foot(axis: JointAxis, before: FloatArray) -> FloatArray:
    """Return where the normal from the axis before, or the plane of its frame, meets an axis."""
    z, origin = before[:3, 2], before[:3, 3]
    across = np.cross(z, axis.direction)
    if np.linalg.norm(across) > _PARALLEL:
        _, foot = _feet(JointAxis(origin, z), axis, across)
        return foot
    along = (origin - axis.point_mm) @ z / (axis.direction @ z)
    return np.asarray(axis.point_mm + along * axis.direction)


def _on_axis(axis: JointAxis, frame: FloatArray) -> FloatArray:
    """Return the frame on an axis that is nearest to another one: its origin, and x where it shows one."""
    # An axis may be given by any of its points: the frame goes where it is nearest to the one that was meant,
    # so that d_1 and the tool's lengths stay those of the drawing.
    origin = axis.point_mm + ((frame[:3, 3] - axis.point_mm) @ axis.direction) * axis.direction
    return _frame(axis, origin, frame[:3, 0], spare=frame[:3, 1])


def _frame(
    axis: JointAxis, origin: FloatArray, x_about: FloatArray, spare: FloatArray | None = None
) -> FloatArray:
    """Return the frame at a place of an axis whose x is nearest to a direction, else to a spare one."""
    z = axis.direction
    x = x_about - (x_about @ z) * z
    if np.linalg.norm(x) <= _SAME_WAY * np.linalg.norm(x_about):
        return _frame(axis, origin, np.roll(z, 1) if spare is None else spare)
    x = x / np.linalg.norm(x)
    frame = np.eye(4)
    frame[:3] = np.column_stack([x, np.cross(z, x), z, origin])
    return frame


def _row(before: FloatArray, frame: FloatArray, sign: int) -> JointRow:
    """Return the row that leads from a frame, whose x shows the way, to the next one."""
    step = before[:3, :3].T @ np.column_stack([frame[:3, :3], frame[:3, 3] - before[:3, 3]])
    z, origin = step[:, 2], step[:, 3]
    # cos(beta): what of the axis remains in the plane that alpha turns in.
    level = float(np.hypot(z[1], z[2]))
    alpha = float(np.arctan2(-z[1], z[2]))
    # Of skew axes x is the common normal, so that a beta beside alpha would be rounding and nothing else.
    beta = float(np.arctan2(z[0], level)) if abs(z[1]) <= _PARALLEL else 0.0
    d = float(origin[1:] @ z[1:]) / level**2
    turned = (rotation_x(alpha) @ rotation_y(beta)).T @ step[:, 0]
    theta = float(np.arctan2(turned[1], turned[0]))
    return JointRow(_whole(alpha), float(origin[0] - d * z[0]), _whole(theta), d, sign, _whole(beta))


def _whole(angle_rad: float) -> float:
    """Return an angle, 0 where it is nothing but rounding: a maker's table comes back with its zeros."""
    return 0.0 if abs(angle_rad) < _ROUNDING_RAD else angle_rad
