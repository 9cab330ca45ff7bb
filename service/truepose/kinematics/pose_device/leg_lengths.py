"""Lengths of legs at a pose: their derivatives, their covariance from cups and nests, their forecast.

Leg k joins cup c and nest n (flange frame): l = |R n + x - c|. With the unit vector e from cup to nest,

    dl = e . dx + (R n x e) . dw - e . dc + e . R dn

Cups and nests add C S_c C' + N S_n N' to the covariance of the lengths, C and N the last two derivatives.

References
----------
JCGM 102:2011 (GUM supplement 2), section 6.2: propagation for several output quantities.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.ballbar import Leg, PoseForecast
from truepose.kinematics.frames import directions
from truepose.kinematics.poses import Pose, points_gradient


@dataclass(frozen=True, slots=True, eq=False)  # arrays: equal means the same object
class Fixtures:
    """Cups and nests as they are known, and how well.

    Attributes
    ----------
    cups_mm : ndarray, shape (K, 3)
        In the frame in which the pose is wanted.
    nests_mm : ndarray, shape (3, 3)
        In the flange frame of the arm.
    cups_covariance_mm2 : ndarray, shape (3K, 3K), or None
        Cup by cup; None: exact.
    nests_covariance_mm2 : ndarray, shape (9, 9), or None
        Nest by nest; None: exact.
    """

    cups_mm: FloatArray  # (K, 3) in the frame in which the pose is wanted
    nests_mm: FloatArray  # (3, 3) in the flange frame of the arm
    cups_covariance_mm2: FloatArray | None = None  # (3K, 3K), cup by cup; None: exact
    nests_covariance_mm2: FloatArray | None = None  # (9, 9), nest by nest; None: exact


@dataclass(frozen=True, slots=True, eq=False)
class LinearLegs:
    """Legs at a pose, and how they change near it.

    Attributes
    ----------
    length_mm : ndarray, shape (n,)
    gradient : ndarray, shape (n, 6)
        Per shift [mm/mm] and turn [mm/rad] of the pose, along the axes of the cups' frame.
    fixtures_covariance_mm2 : ndarray, shape (n, n)
        Of the lengths, from cups and nests.
    """

    length_mm: FloatArray  # (n,)
    gradient: FloatArray  # (n, 6) per shift [mm] and turn [rad] of the pose
    fixtures_covariance_mm2: FloatArray  # (n, n) from cups and nests


def linear_legs(fixtures: Fixtures, legs: Sequence[Leg], pose: Pose) -> LinearLegs:
    """Return legs at a pose of the flange frame, by the formulas of the module's head.

    Parameters
    ----------
    fixtures : Fixtures
    legs : sequence of (cup, nest)
        n of them, numbers from 1.
    pose : Pose
        Of the flange frame. A leg whose nest lies in its cup has no direction: no motion changes its length.
    """
    # Legs that share a cup or a nest share its error: the covariance is one of all legs, not a variance each.
    cup, nest = np.array(legs).T - 1
    apart = pose.points(fixtures.nests_mm)[nest] - fixtures.cups_mm[cup]
    unit, length = directions(apart)
    gradient = np.einsum("ni,nij->nj", unit, points_gradient(pose, fixtures.nests_mm)[nest])
    added = np.zeros((len(legs), len(legs)))
    if fixtures.cups_covariance_mm2 is not None:
        added += _through(unit, cup, fixtures.cups_covariance_mm2)
    if fixtures.nests_covariance_mm2 is not None:
        added += _through(unit @ pose.rotation, nest, fixtures.nests_covariance_mm2)
    return LinearLegs(length, gradient, added)


def _through(unit: FloatArray, point: IntArray, covariance: FloatArray) -> FloatArray:
    """Return the covariance (n, n) of lengths along `unit` from points whose covariance is given.

    Parameters
    ----------
    unit : ndarray, shape (n, 3)
        Direction of each length, in the frame of the points.
    point : ndarray of int, shape (n,)
        From 0.
    covariance : ndarray, shape (3 points, 3 points)
        [mm2]
    """
    # Rows and columns of the points of the legs, once each: a cup with three legs stands three times in it.
    blocks = covariance.reshape(len(covariance) // 3, 3, -1, 3)[point][:, :, point]
    added: FloatArray = np.einsum("ni,nimj,mj->nm", unit, blocks, unit)
    return added


def foreseen(config: int, fixtures: Fixtures, pose: Pose, covariance: FloatArray) -> PoseForecast:
    """Foresee the lengths of every pair of cup and nest at a commanded pose.

    With G the derivatives of the lengths, C = G C_pose G^T + V, V from the cups and nests.

    Parameters
    ----------
    config : int
        Number of the configuration in the campaign.
    fixtures : Fixtures
    pose : Pose
        Where the flange frame is believed to be.
    covariance : ndarray, shape (6, 6)
        Of that belief: shift [mm], then turn [rad], about the axes of the cups' frame.

    Returns
    -------
    PoseForecast
        All pairs, cup by cup, with the covariance of their errors [mm2].
    """
    # Every pair and not only those that are planned: what is read may be of another one.
    legs = tuple((cup, nest) for cup in range(1, len(fixtures.cups_mm) + 1) for nest in (1, 2, 3))
    linear = linear_legs(fixtures, legs, pose)
    total = linear.gradient @ covariance @ linear.gradient.T + linear.fixtures_covariance_mm2
    return PoseForecast(config, legs, tuple(linear.length_mm.tolist()), tuple(map(tuple, total.tolist())))
