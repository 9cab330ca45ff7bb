"""Trilateration: the point that lies at three known distances from three known points.

With u = v2 - v1, w = v3 - v1 and n = u x w, the foot d of the point in the plane of v1, v2, v3, seen from v1,
satisfies u.d = (l1^2 - l2^2 + u.u)/2 =: a and w.d = (l1^2 - l3^2 + w.w)/2 =: b, hence

    d = (a (w x n) + b (n x u)) / n.n        and the point is v1 + d +- sqrt(l1^2 - d.d) n/|n|.

References
----------
P. Nair, 1992, as quoted by A. Nubiola, PhD thesis, ETS Montreal, 2014, equations (3.4) to (3.11).
"""

import numpy as np
import numpy.typing as npt

from truepose.domain.arrays import FloatArray


def tri(
    v1: FloatArray,
    v2: FloatArray,
    v3: FloatArray,
    l1: npt.ArrayLike,
    l2: npt.ArrayLike,
    l3: npt.ArrayLike,
    side: npt.ArrayLike,
) -> FloatArray:
    """Return the points at distances l1, l2, l3 from v1, v2, v3.

    Parameters
    ----------
    v1, v2, v3 : ndarray, shape (..., 3)
        Centres [mm].
    l1, l2, l3 : array_like, shape (...)
        Distances [mm].
    side : array_like, shape (...)
        +1 on the side to which (v2 - v1) x (v3 - v1) points, -1 on the other.

    Returns
    -------
    ndarray, shape (..., 3)
        [mm]; NaN where the three distances do not meet, or where the three centres are on a line.
    """
    first, second, third = np.asarray(l1), np.asarray(l2), np.asarray(l3)
    u, w = v2 - v1, v3 - v1
    normal = np.cross(u, w)
    along_u = 0.5 * (first**2 - second**2 + _dot(u, u))
    along_w = 0.5 * (first**2 - third**2 + _dot(w, w))
    with np.errstate(divide="ignore", invalid="ignore"):  # NaN is the answer where there is no such point
        # In vectors throughout, without a frame of the three centres: derivatives by complex steps run
        # through here.
        weighted = along_u[..., None] * np.cross(w, normal) + along_w[..., None] * np.cross(normal, u)
        foot = weighted / _dot(normal, normal)[..., None]
        height = np.asarray(side) * np.sqrt(first**2 - _dot(foot, foot)) / np.sqrt(_dot(normal, normal))
        point: FloatArray = v1 + foot + height[..., None] * normal
    return point


def tri_gradient(
    point_mm: FloatArray, centres_mm: FloatArray, centres_gradient: FloatArray, lengths_gradient: FloatArray
) -> FloatArray:
    """Differentiate a trilaterated point by the quantities that its centres and lengths depend on.

    Differentiating |p - v_i|^2 = l_i^2 gives (p - v_i).(dp - dv_i) = l_i dl_i: three linear equations for dp.

    Parameters
    ----------
    point_mm : ndarray, shape (..., 3)
        The point itself.
    centres_mm : ndarray, shape (..., 3, 3)
        One centre in each row.
    centres_gradient : ndarray, shape (..., 3, 3, q)
        Motion of each centre (centre, coordinate) per quantity.
    lengths_gradient : ndarray, shape (..., 3, q)
        Change of each length per quantity.

    Returns
    -------
    ndarray, shape (..., 3, q)
        mm per unit of each of the q quantities.

    Raises
    ------
    numpy.linalg.LinAlgError
        The point lies in the plane of its centres, so that no length sees how far it is off that plane.
    """
    towards = point_mm[..., None, :] - centres_mm
    lengths = np.sqrt(_dot(towards, towards))
    change = np.einsum("...ij,...ijq->...iq", towards, centres_gradient)
    gradient: FloatArray = np.linalg.solve(towards, change + lengths[..., None] * lengths_gradient)
    return gradient


def _dot(first: FloatArray, second: FloatArray) -> FloatArray:
    # not norm: complex steps run through here, and the modulus is not differentiable
    return np.asarray((first * second).sum(axis=-1))
