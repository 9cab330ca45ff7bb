r"""The DH-Modified chain with its error ports, and how every port moves a point.

With `R_0, o_0` the placed base, joint i = 1..J does (Craig's convention; beta after Hayati)

    R_i = R_(i-1) RotX(alpha_i) RotY(beta_i) RotZ(theta_i)
    o_i = o_(i-1) + a_i x_(i-1) + d_i z_i

so that a small change of one quantity is a screw, and a point p fixed to the last frame moves by

    alpha_i : x_(i-1) x (p - o_(i-1))      a_i : x_(i-1)
    beta_i  : y_m x (p - o_m)              d_i : z_i
    theta_i : z_i x (p - o_i)

with y_m the second axis of R_(i-1) RotX(alpha_i) and o_m = o_(i-1) + a_i x_(i-1).

References
----------
J. J. Craig, Introduction to Robotics, 3rd ed., 2005, section 3.4 (DH-Modified).
S. A. Hayati, Proc. 22nd IEEE Conf. Decision and Control, 1983, 1477-1483 (near-parallel axes).
"""

from dataclasses import dataclass

import numpy as np

from service.domain.arrays import FloatArray
from service.domain.robot import Robot
from service.kinematics.frames import cross, rotation_x, rotation_y


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

    def points(self, in_last_frame_mm: FloatArray) -> FloatArray:
        """Return points of the last frame in the world [mm], shape (n, 3), from (3,) or (n, 3)."""
        points = np.broadcast_to(in_last_frame_mm, self.origin[-1].shape)
        placed: FloatArray = self.origin[-1] + np.einsum("nij,nj->ni", self.rotation[-1], points)
        return placed


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


def forward(values: LinkValues, base_rotation: FloatArray, base_origin_mm: FloatArray) -> Chain:
    """Forward kinematics of n configurations.

    Parameters
    ----------
    values : LinkValues
    base_rotation : ndarray, shape (3, 3) or (n, 3, 3)
    base_origin_mm : ndarray, shape (3,) or (n, 3)

    Returns
    -------
    Chain
    """
    n, joints = values.theta_rad.shape
    chain = _empty_chain(joints, n)
    rotation, origin = np.broadcast_to(base_rotation, (n, 3, 3)), np.broadcast_to(base_origin_mm, (n, 3))
    for i in range(joints):
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
    return chain


def nominal_chain(robot: Robot, joints_rad: FloatArray) -> Chain:
    """Return the nominal chain with its base at the identity."""
    return forward(nominal_values(robot, joints_rad), np.eye(3), np.zeros(3))


def _empty_chain(joints: int, n: int) -> Chain:
    def vectors() -> FloatArray:
        return np.empty((joints, n, 3))

    rotations = np.empty((joints, n, 3, 3))
    return Chain(vectors(), vectors(), vectors(), vectors(), rotations, vectors(), vectors())


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


def alpha_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points (n, 3) per alpha of each joint [mm/rad], shape (J, n, 3)."""
    return cross(chain.x_before, points_mm - chain.origin_before)


def beta_gradient(chain: Chain, points_mm: FloatArray, joint: int) -> FloatArray:
    """Return the motion of points (n, 3) per beta of one joint [mm/rad], shape (n, 3)."""
    return cross(chain.y_middle[joint], points_mm - chain.origin_middle[joint])
