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
    """Frames of n configurations in the world; joint index last but one."""

    x_before: FloatArray  # (n, J, 3) x axis of the frame before joint i
    origin_before: FloatArray  # (n, J, 3) [mm]
    y_middle: FloatArray  # (n, J, 3)
    origin_middle: FloatArray  # (n, J, 3) [mm]
    rotation: FloatArray  # (n, J, 3, 3) of frame i
    origin: FloatArray  # (n, J, 3) of frame i [mm]

    @property
    def z(self) -> FloatArray:
        """Axes of the joints, shape (n, J, 3)."""
        return self.rotation[..., 2]

    def points(self, in_last_frame_mm: FloatArray) -> FloatArray:
        """Return points of the last frame in the world [mm], shape (n, 3), from (3,) or (n, 3)."""
        points = np.broadcast_to(in_last_frame_mm, (len(self.origin), 3))
        return self.origin[:, -1] + np.einsum("nij,nj->ni", self.rotation[:, -1], points)


def nominal_values(robot: Robot, joints_rad: FloatArray) -> LinkValues:
    """Return the link values of the nominal robot at n configurations."""
    rows = robot.joints
    sign = np.array([row.sign for row in rows], dtype=float)
    offset = np.array([row.theta_offset_rad for row in rows])
    return LinkValues(
        alpha_rad=np.array([row.alpha_rad for row in rows]),
        a_mm=np.array([row.a_mm for row in rows]),
        beta_rad=np.zeros(len(rows)),
        theta_rad=joints_rad * sign + offset,
        d_mm=np.array([row.d_mm for row in rows]),
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
    tilt = rotation_x(values.alpha_rad)
    twist = tilt @ rotation_y(values.beta_rad)
    a_mm, d_mm = (np.broadcast_to(array, (n, joints)) for array in (values.a_mm, values.d_mm))
    cosine, sine = np.cos(values.theta_rad), np.sin(values.theta_rad)
    chain = _empty_chain(n, joints)
    rotation, origin = np.broadcast_to(base_rotation, (n, 3, 3)), np.broadcast_to(base_origin_mm, (n, 3))
    for i in range(joints):
        chain.x_before[:, i], chain.origin_before[:, i] = rotation[:, :, 0], origin
        chain.y_middle[:, i] = np.einsum("nij,...j->ni", rotation, tilt[..., i, :, 1])
        middle = origin + a_mm[:, i, None] * rotation[:, :, 0]
        turned = rotation @ twist[..., i, :, :]
        c, s = cosine[:, i, None], sine[:, i, None]
        chain.rotation[:, i, :, 0] = c * turned[:, :, 0] + s * turned[:, :, 1]
        chain.rotation[:, i, :, 1] = c * turned[:, :, 1] - s * turned[:, :, 0]
        chain.rotation[:, i, :, 2] = turned[:, :, 2]
        rotation = chain.rotation[:, i]
        origin = middle + d_mm[:, i, None] * turned[:, :, 2]
        chain.origin_middle[:, i], chain.origin[:, i] = middle, origin
    return chain


def _empty_chain(n: int, joints: int) -> Chain:
    vectors = (np.empty((n, joints, 3)) for _ in range(4))
    return Chain(*vectors, np.empty((n, joints, 3, 3)), np.empty((n, joints, 3)))


def theta_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points per angle of each joint [mm/rad], shape (n, J, 3)."""
    return cross(chain.z, points_mm[:, None] - chain.origin)


def alpha_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points per alpha of each joint [mm/rad], shape (n, J, 3)."""
    return cross(chain.x_before, points_mm[:, None] - chain.origin_before)


def beta_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points per beta of each joint [mm/rad], shape (n, J, 3)."""
    return cross(chain.y_middle, points_mm[:, None] - chain.origin_middle)
