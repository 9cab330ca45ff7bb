r"""The DH-Modified chain with its error ports, and how every port moves a point.

With `R_0, o_0` the placed base, joint i = 1..J does (Craig's convention; beta after Hayati)

    R_i = R_(i-1) RotX(alpha_i) RotY(beta_i) RotZ(theta_i)
    o_i = o_(i-1) + a_i x_(i-1) + d_i z_i

so that a small change of one quantity is a screw, and a point p fixed to the flange frame moves by

    alpha_i : x_(i-1) x (p - o_(i-1))      a_i : x_(i-1)
    beta_i  : y_m x (p - o_m)              d_i : z_i
    theta_i : z_i x (p - o_i)

with y_m the second axis of R_(i-1) RotX(alpha_i) and o_m = o_(i-1) + a_i x_(i-1).

In memory components come first and rows last: what is of shape (J, n, 3) is a view of three planes, so that
every product runs over contiguous rows, several times faster than 3 by 3 products row by row.

Besides, a body may move as a whole before the next joint is reached: body b = 0 is the base, b = 1..J the
link that joint b turns, body J carries the tool. Its motion Trans(s) RotX RotY RotZ is in its own axes.

References
----------
J. J. Craig, Introduction to Robotics, 3rd ed., 2005, section 3.4 (DH-Modified).
S. A. Hayati, Proc. 22nd IEEE Conf. Decision and Control, 1983, 1477-1483 (near-parallel axes).
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from types import MappingProxyType

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.robot import Robot
from truepose.kinematics.frames import cross, rotate, turned_axes

_STILL: Mapping[int, FloatArray] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class LinkValues:
    """Values of the five link quantities; nominal ones, or with what the ports of effects add to them.

    Attributes
    ----------
    alpha_rad, a_mm, beta_rad, d_mm : ndarray, shape (J,) or (n, J)
        The latter where they differ from row to row, as lengths do that grow with the temperature.
    theta_rad : ndarray, shape (n, J)
        Joint angles with sign, offset and errors.
    """

    alpha_rad: FloatArray
    a_mm: FloatArray
    beta_rad: FloatArray
    theta_rad: FloatArray  # (n, J): joint angles with sign, offset and errors
    d_mm: FloatArray


@dataclass(frozen=True, slots=True)
class Chain:
    """Frames of n configurations in the world; the joint comes first, so that one joint is contiguous.

    Attributes
    ----------
    x_before : ndarray, shape (J, n, 3)
        x axis of the frame before joint i: alpha_i turns about it, a_i runs along it.
    origin_before : ndarray, shape (J, n, 3)
        Origin of that frame [mm], after the motion of its body.
    origin_middle : ndarray, shape (J, n, 3)
        Where beta_i turns: o_(i-1) + a_i x_(i-1) [mm].
    rotation : ndarray, shape (J, n, 3, 3)
        Of frame i.
    origin : ndarray, shape (J, n, 3)
        Of frame i [mm].
    base_rotation : ndarray, shape (n, 3, 3)
    base_origin : ndarray, shape (n, 3)
        [mm], before the motion of body 0.
    end_rotation : ndarray, shape (n, 3, 3)
        Of the flange frame where the tool is, after the motion of body J.
    end_origin : ndarray, shape (n, 3)
        [mm]
    """

    x_before: FloatArray  # (J, n, 3) x axis of the frame before joint i
    origin_before: FloatArray  # (J, n, 3) [mm]
    origin_middle: FloatArray  # (J, n, 3) [mm]
    rotation: FloatArray  # (J, n, 3, 3) of frame i
    origin: FloatArray  # (J, n, 3) of frame i [mm]
    base_rotation: FloatArray  # (n, 3, 3)
    base_origin: FloatArray  # (n, 3) [mm]
    end_rotation: FloatArray  # (n, 3, 3) of the flange frame where the tool is, after the motion of body J
    end_origin: FloatArray  # (n, 3) [mm]

    @property
    def z(self) -> FloatArray:
        """Axis of each joint, shape (J, n, 3)."""
        return self.rotation[..., 2]

    def taken(self, rows: IntArray) -> "Chain":
        """Return the frames of some configurations.

        Parameters
        ----------
        rows : ndarray of int, shape (m,)
        """
        columns = {field.name: getattr(self, field.name) for field in fields(self)}
        # These have no joint in front of the configurations.
        alone = ("base_rotation", "base_origin", "end_rotation", "end_origin")
        return Chain(**{
            name: column[rows] if name in alone else column[:, rows] for name, column in columns.items()
        })

    def y_middle(self, joint: int) -> FloatArray:
        """Second axis of the frame between alpha and beta of a joint: z_i x x_(i-1), normalised.

        z_i leans by beta in the plane of x and z of that frame, so that the product is y cos(beta).

        Parameters
        ----------
        joint : int
            0-based.

        Returns
        -------
        ndarray, shape (n, 3)
            Unit vectors; for |beta| < 90 deg.
        """
        # Worked out where it is asked for: few joints have a beta, and frames keep it for none.
        across = cross(self.z[joint], self.x_before[joint])
        return np.asarray(
            across / np.sqrt((across**2).sum(axis=1, keepdims=True))
        )  # beta is the angle that z leans by

    def points(self, in_last_frame_mm: FloatArray) -> FloatArray:
        """Return points of the flange frame in the world.

        Parameters
        ----------
        in_last_frame_mm : ndarray, shape (3,) or (n, 3)
            One for all configurations, or one each.

        Returns
        -------
        ndarray, shape (n, 3)
            [mm]
        """
        placed = rotate(self.end_rotation, in_last_frame_mm)
        placed += self.end_origin
        return placed

    def places(self, in_last_frame_mm: FloatArray) -> FloatArray:
        """Return m points of the flange frame in the world, each in every configuration.

        Parameters
        ----------
        in_last_frame_mm : ndarray, shape (m, 3)

        Returns
        -------
        ndarray, shape (m, n, 3)
            [mm]
        """
        x, y, z = self.end_rotation.T
        along = in_last_frame_mm.T[:, :, None, None]
        placed = x * along[0] + y * along[1] + z * along[2]
        placed += self.end_origin.T
        return np.asarray(np.swapaxes(placed, 1, 2))

    def body(self, number: int) -> tuple[FloatArray, FloatArray]:
        """Return where a body is, and the point that it turns about.

        Parameters
        ----------
        number : int
            0 is the base, 1..J the link that joint turns, J carries the tool.

        Returns
        -------
        rotation : ndarray, shape (n, 3, 3)
            Before the body's motion.
        about_mm : ndarray, shape (n, 3)
            After its shift.
        """
        rotation = self.base_rotation if number == 0 else self.rotation[number - 1]
        # A turn comes after the shift, about the body's origin where the shift has put it: derivatives by the
        # turn need that place. Behind the last body no joint follows that would keep it as its
        # `origin_before`.
        joints = len(self.origin)
        return rotation, self.end_origin if number == joints else self.origin_before[number]


def nominal_values(robot: Robot, joints_rad: FloatArray) -> LinkValues:
    """Return the link values of the nominal robot.

    Parameters
    ----------
    robot : Robot
    joints_rad : ndarray, shape (n, J)
        As the controller counts them: theta = sign * q + offset.
    """
    rows = robot.joints
    sign = np.array([row.sign for row in rows], dtype=float)
    offset = np.array([row.theta_offset_rad for row in rows])
    return LinkValues(
        alpha_rad=np.array([row.alpha_rad for row in rows], dtype=float),
        a_mm=np.array([row.a_mm for row in rows], dtype=float),
        beta_rad=np.array([row.beta_rad for row in rows], dtype=float),
        # Laid out joint by joint, as `forward` reads it: a joint's angles are then one contiguous row.
        theta_rad=(np.multiply(joints_rad.T, sign[:, None], order="C") + offset[:, None]).T,
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
        Shifts [mm] and turns RotX RotY RotZ [rad] of bodies that move, in the body's own axes.

    Returns
    -------
    Chain

    References
    ----------
    J. J. Craig, Introduction to Robotics, 3rd ed., 2005, equation (3.6).
    A. Nubiola, PhD thesis, ETS Montreal, 2014, section 2.3.
    """
    n, joints = values.theta_rad.shape
    axes, origins = np.empty((joints + 1, 3, 3, n)), np.empty((joints + 1, 3, n))  # frame 0 is the base
    axes[0], origins[0] = (
        np.broadcast_to(base_rotation, (n, 3, 3)).T,
        np.broadcast_to(base_origin_mm, (n, 3)).T,
    )
    # Without motions the frame before a joint is the frame behind the one before it: a view, not a copy.
    before, origins_before, middle = axes[:-1], origins[:-1], np.empty((joints, 3, n))
    if motions:
        before, origins_before = np.empty_like(before), np.empty_like(origins_before)
    alphas, betas, thetas = _Angles(values.alpha_rad), _Angles(values.beta_rad), _Angles(values.theta_rad)
    for i in range(joints):
        if motions:
            # Before the joint: what a body's motion shifts are all joints behind it, their axes and their
            # levers.
            before[i], origins_before[i] = _moved(axes[i], origins[i], motions.get(i))
        x, y, z = before[i]
        np.add(origins_before[i], _column(values.a_mm, i) * x, out=middle[i])
        # Three turns in a plane each, of two axes at a time: the third axis of a turn stays what it was,
        # which a product of matrices would multiply by ones and zeros.
        y, z = alphas.turned(y, z, i)
        z, x = betas.turned(z, x, i)
        thetas.turn(x, y, i, axes[i + 1, :2])
        axes[i + 1, 2] = z
        np.add(middle[i], _column(values.d_mm, i) * z, out=origins[i + 1])
    # The tool's own motion: no joint follows it, so that no gradient of a joint or of a link's row sees it.
    end_axes, end_origin = _moved(axes[-1], origins[-1], motions.get(joints))
    return Chain(
        x_before=_by_row(before[:, 0]),
        origin_before=_by_row(origins_before),
        origin_middle=_by_row(middle),
        rotation=np.transpose(axes[1:], (0, 3, 2, 1)),
        origin=_by_row(origins[1:]),
        base_rotation=axes[0].T,
        base_origin=origins[0].T,
        end_rotation=end_axes.T,
        end_origin=end_origin.T,
    )


class _Angles:
    """Turns about one axis of every joint, by the same angle in all rows or by one each.

    An angle that is 0 in all rows is skipped: of makers' tables every beta, and alpha of parallel axes.
    """

    def __init__(self, angles_rad: FloatArray) -> None:
        angles = np.ascontiguousarray(angles_rad.T)
        self._cosine, self._sine = np.cos(angles), np.sin(angles)
        # Angles of one each are not looked at: it would cost a pass over all of them to find none.
        self._still = np.equal(angles, 0.0).tolist() if angles.ndim == 1 else [False] * len(angles)

    def turned(self, first: FloatArray, second: FloatArray, joint: int) -> tuple[FloatArray, FloatArray]:
        """Return two axes turned about the third, first c + second s and second c - first s.

        x, y, z follow each other in a circle: about x turn y and z, about y turn z and x, about z turn x and
        y.

        Parameters
        ----------
        first, second : ndarray, shape (3, n)
        joint : int
            0-based.
        """
        if self._still[joint]:
            return first, second
        axes = np.empty((2, *first.shape))
        self.turn(first, second, joint, axes)
        return axes[0], axes[1]

    def turn(self, first: FloatArray, second: FloatArray, joint: int, axes: FloatArray) -> None:
        """Write two axes (3, n) turned about the third into `axes` (2, 3, n)."""
        c, s = self._cosine[joint], self._sine[joint]
        np.multiply(c, first, out=axes[0])
        axes[0] += s * second
        np.multiply(c, second, out=axes[1])
        axes[1] -= s * first


def _by_row(planes: FloatArray) -> FloatArray:
    """Return vectors in the last place, of planes (J, 3, n)."""
    return np.swapaxes(planes, 1, 2)


def _moved(axes: FloatArray, origin: FloatArray, motion: FloatArray | None) -> tuple[FloatArray, FloatArray]:
    """Return axes (3, 3, n) and origin (3, n) of a body after its motion, in its own axes."""
    if motion is None:
        return axes, origin
    turn, _ = turned_axes(motion[:, 3:])
    return np.einsum("jin,njk->kin", axes, turn), origin + np.einsum("jin,nj->in", axes, motion[:, :3])


def body_gradients(chain: Chain, body: int, motion: FloatArray, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points per component of a body's motion.

    Per shift k: axis k of the body. Per angle k: (R axes_k) x (p - about), axes_k as of `turned_axes`.

    Parameters
    ----------
    chain : Chain
        n configurations.
    body : int
        0..J.
    motion : ndarray, shape (n, 6)
        Where the derivative is taken: shifts [mm], turns [rad].
    points_mm : ndarray, shape (n, 3)
        In the world; fixed to what the body carries.

    Returns
    -------
    ndarray, shape (6, n, 3)
        mm per mm, then mm per rad.
    """
    rotation, about = chain.body(body)
    _, axes = turned_axes(motion[:, 3:])
    turning = np.einsum("nij,knj->kni", rotation, axes)
    return np.concatenate([np.moveaxis(rotation, 2, 0), cross(turning, points_mm - about)])


def nominal_chain(robot: Robot, joints_rad: FloatArray) -> Chain:
    """Return the nominal chain with its base at the identity; frames are then in the robot's own base.

    Parameters
    ----------
    robot : Robot
    joints_rad : ndarray, shape (n, J)
    """
    return forward(nominal_values(robot, joints_rad), np.eye(3), np.zeros(3))


def _column(values: FloatArray, joint: int) -> FloatArray | float:
    return values[:, joint] if values.ndim == 2 else float(values[joint])


def theta_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points per angle of each joint, z_i x (p - o_i).

    Parameters
    ----------
    chain : Chain
    points_mm : ndarray, shape (n, 3)
        In the world; fixed to the flange frame.

    Returns
    -------
    ndarray, shape (J, n, 3)
        [mm/rad]
    """
    return cross(chain.z, points_mm - chain.origin)


def theta_gradient_of(chain: Chain, points_mm: FloatArray, joint: int) -> FloatArray:
    """Return the motion of points per angle of one joint (0-based), shape (n, 3), as `theta_gradient`."""
    return cross(chain.z[joint], points_mm - chain.origin[joint])


def alpha_gradient(chain: Chain, points_mm: FloatArray) -> FloatArray:
    """Return the motion of points per alpha of each joint, x_(i-1) x (p - o_(i-1)), as `theta_gradient`."""
    return cross(chain.x_before, points_mm - chain.origin_before)


def beta_gradient(chain: Chain, points_mm: FloatArray, joint: int) -> FloatArray:
    """Return the motion of points per beta of one joint, y_m x (p - o_m).

    Parameters
    ----------
    chain : Chain
    points_mm : ndarray, shape (n, 3)
    joint : int
        0-based.

    Returns
    -------
    ndarray, shape (n, 3)
        [mm/rad]
    """
    return cross(chain.y_middle(joint), points_mm - chain.origin_middle[joint])
