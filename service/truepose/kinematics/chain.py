r"""The DH-Modified chain with its error ports, and how every port moves a point.

With `R_0, o_0` the placed base, joint i = 1..J does (Craig's convention; beta after Hayati)

    R_i = R_(i-1) RotX(alpha_i) RotY(beta_i) RotZ(theta_i)
    o_i = o_(i-1) + a_i x_(i-1) + d_i z_i

so that a small change of one quantity is a screw, and a point p fixed to the last frame moves by

    alpha_i : x_(i-1) x (p - o_(i-1))      a_i : x_(i-1)
    beta_i  : y_m x (p - o_m)              d_i : z_i
    theta_i : z_i x (p - o_i)

with y_m the second axis of R_(i-1) RotX(alpha_i) and o_m = o_(i-1) + a_i x_(i-1).

Besides, a body may move as a whole before the next joint is reached: body b = 0 is the base, b = 1..J the
link that joint b turns, body J carries the tool. Its motion Trans(s) RotX RotY RotZ is in its own axes.

References
----------
J. J. Craig, Introduction to Robotics, 3rd ed., 2005, section 3.4 (DH-Modified).
S. A. Hayati, Proc. 22nd IEEE Conf. Decision and Control, 1983, 1477-1483 (near-parallel axes).
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import Robot
from truepose.kinematics.frames import cross, rotation_x, rotation_y, turned_axes

_STILL: Mapping[int, FloatArray] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class LinkValues:
    """Values of the five link quantities, each of shape (J,) or (n, J) where they differ from row to row."""

    alpha_rad: FloatArray
    a_mm: FloatArray
    beta_rad: FloatArray
    theta_rad: FloatArray  # (n, J): joint angles with sign, offset and errors
    d_mm: FloatArray


@dataclass(frozen=True, slots=True)
class Chain:
    """Frames of n configurations in the world; the joint comes first, so that one joint is contiguous."""

    x_before: FloatArray  # (J, n, 3) x axis of the frame before joint i
    origin_before: FloatArray  # (J, n, 3) [mm]
    y_middle: FloatArray  # (J, n, 3)
    origin_middle: FloatArray  # (J, n, 3) [mm]
    rotation: FloatArray  # (J, n, 3, 3) of frame i
    z: FloatArray  # (J, n, 3) axis of joint i
    origin: FloatArray  # (J, n, 3) of frame i [mm]
    base_rotation: FloatArray  # (n, 3, 3)
    base_origin: FloatArray  # (n, 3) [mm]
    end_rotation: FloatArray  # (n, 3, 3) of the last frame where the tool is, after the motion of body J
    end_origin: FloatArray  # (n, 3) [mm]

    def points(self, in_last_frame_mm: FloatArray) -> FloatArray:
        """Return points of the last frame in the world [mm], shape (n, 3), from (3,) or (n, 3)."""
        points = np.broadcast_to(in_last_frame_mm, self.end_origin.shape)
        placed: FloatArray = self.end_origin + np.einsum("nij,nj->ni", self.end_rotation, points)
        return placed

    def body(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return rotation (n, 3, 3) of body 0..J before its motion, and the point (n, 3) it turns about."""
        rotation = self.base_rotation if number == 0 else self.rotation[number - 1]
        joints = len(self.origin)
        return rotation, self.end_origin if number == joints else self.origin_before[number]


def nominal_values(robot: Robot, joints_rad: FloatArray) -> LinkValues:
    """Return the link values of the nominal robot at n configurations."""
    rows = robot.joints
    sign = np.array([row.sign for row in rows], dtype=float)
    offset = np.array([row.theta_offset_rad for row in rows])
    return LinkValues(
        alpha_rad=np.array([row.alpha_rad for row in rows], dtype=float),
        a_mm=np.array([row.a_mm for row in rows], dtype=float),
        beta_rad=np.zeros(len(rows)),
        theta_rad=joints_rad * sign + offset,
        d_mm=np.array([row.d_mm for row in rows], dtype=float),
    )


def forward(
    values: LinkValues,
    base_rotation: FloatArray,
    base_origin_mm: FloatArray,
    motions: Mapping[int, FloatArray] = _STILL,
) -> Chain:
    """Forward kinematics of n configurations.

    Parameters
    ----------
    values : LinkValues
    base_rotation : ndarray, shape (3, 3) or (n, 3, 3)
    base_origin_mm : ndarray, shape (3,) or (n, 3)
    motions : mapping of body (0..J) to ndarray, shape (n, 6)
        Shifts [mm] and turns RotX RotY RotZ [rad] of bodies that move.

    Returns
    -------
    Chain
    """
    n, joints = values.theta_rad.shape
    rotation, origin = np.broadcast_to(base_rotation, (n, 3, 3)), np.broadcast_to(base_origin_mm, (n, 3))
    chain = _empty_chain(rotation, origin, joints)
    for i in range(joints):
        rotation, origin = _moved(rotation, origin, motions.get(i))
        tilt = rotation_x(values.alpha_rad[..., i])
        chain.x_before[i], chain.origin_before[i] = rotation[:, :, 0], origin
        np.add(origin, _column(values.a_mm, i) * chain.x_before[i], out=chain.origin_middle[i])
        chain.y_middle[i] = _times(rotation, tilt)[:, :, 1]
        turned = _times(rotation, tilt @ rotation_y(values.beta_rad[..., i]))
        c, s = np.cos(values.theta_rad[:, i, None]), np.sin(values.theta_rad[:, i, None])
        rotation = chain.rotation[i]
        rotation[:, :, 0] = c * turned[:, :, 0] + s * turned[:, :, 1]
        rotation[:, :, 1] = c * turned[:, :, 1] - s * turned[:, :, 0]
        rotation[:, :, 2] = chain.z[i] = turned[:, :, 2]
        origin = np.add(chain.origin_middle[i], _column(values.d_mm, i) * chain.z[i], out=chain.origin[i])
    end_rotation, end_origin = _moved(rotation, origin, motions.get(joints))
    return replace(chain, end_rotation=end_rotation, end_origin=end_origin)


def _moved(
    rotation: FloatArray, origin: FloatArray, motion: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    if motion is None:
        return rotation, origin
    turn, _ = turned_axes(motion[:, 3:])
    return rotation @ turn, origin + np.einsum("nij,nj->ni", rotation, motion[:, :3])


def body_gradients(chain: Chain, body: int, motion: FloatArray, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points (n, 3) per component of a body's motion, shape (6, n, 3)."""
    rotation, about = chain.body(body)
    _, axes = turned_axes(motion[:, 3:])
    turning = np.einsum("nij,knj->kni", rotation, axes)
    return np.concatenate([np.moveaxis(rotation, 2, 0), cross(turning, points_mm - about)])


def nominal_chain(robot: Robot, joints_rad: FloatArray) -> Chain:
    """Return the nominal chain with its base at the identity."""
    return forward(nominal_values(robot, joints_rad), np.eye(3), np.zeros(3))


def _empty_chain(base_rotation: FloatArray, base_origin: FloatArray, joints: int) -> Chain:
    n = len(base_origin)

    def vectors() -> FloatArray:
        return np.empty((joints, n, 3))

    rotations = np.empty((joints, n, 3, 3))
    return Chain(
        x_before=vectors(),
        origin_before=vectors(),
        y_middle=vectors(),
        origin_middle=vectors(),
        rotation=rotations,
        z=vectors(),
        origin=vectors(),
        base_rotation=base_rotation,
        base_origin=base_origin,
        end_rotation=base_rotation,
        end_origin=base_origin,
    )


def _column(values: FloatArray, joint: int) -> FloatArray | float:
    return values[:, joint, None] if values.ndim == 2 else float(values[joint])


def _times(rotation: FloatArray, constant_or_rows: FloatArray) -> FloatArray:
    """Product of (n, 3, 3) with (3, 3) or (n, 3, 3); the former as one flat product, several times faster."""
    if constant_or_rows.ndim == 2:
        return np.asarray((rotation.reshape(-1, 3) @ constant_or_rows).reshape(rotation.shape))
    return rotation @ constant_or_rows


def theta_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points (n, 3) per angle of each joint [mm/rad], shape (J, n, 3)."""
    return cross(chain.z, points_mm - chain.origin)


def theta_gradient_of(chain: Chain, points_mm: FloatArray, joint: int) -> FloatArray:
    """Return the motion of points (n, 3) per angle of one joint [mm/rad], shape (n, 3)."""
    return cross(chain.z[joint], points_mm - chain.origin[joint])


def alpha_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points (n, 3) per alpha of each joint [mm/rad], shape (J, n, 3)."""
    return cross(chain.x_before, points_mm - chain.origin_before)


def beta_gradient(chain: Chain, points_mm: FloatArray, joint: int) -> FloatArray:
    """Return the motion of points (n, 3) per beta of one joint [mm/rad], shape (n, 3)."""
    return cross(chain.y_middle[joint], points_mm - chain.origin_middle[joint])
