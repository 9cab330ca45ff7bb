"""Lengths of legs at a pose: their derivative, and what uncertain fixtures add to their covariance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.ballbar import Leg, PoseForecast
from truepose.kinematics.pose_device.poses import Pose, points_gradient


@dataclass(frozen=True, slots=True, eq=False)  # arrays: equal means the same object
class Fixtures:
    """Cups and nests as they are known, and how well."""

    cups_mm: FloatArray  # (K, 3) in the frame in which the pose is wanted
    nests_mm: FloatArray  # (3, 3) in the last frame of the arm
    cups_covariance_mm2: FloatArray | None = None  # (3K, 3K), cup by cup; None: exact
    nests_covariance_mm2: FloatArray | None = None  # (9, 9), nest by nest; None: exact


@dataclass(frozen=True, slots=True, eq=False)
class LinearLegs:
    """Legs at a pose, and how they change near it."""

    length_mm: FloatArray  # (n,)
    gradient: FloatArray  # (n, 6) per shift [mm] and turn [rad] of the pose
    fixtures_covariance_mm2: FloatArray  # (n, n) from cups and nests


def linear_legs(fixtures: Fixtures, legs: Sequence[Leg], pose: Pose) -> LinearLegs:
    """Return n legs (cup, nest) at a pose of the last frame."""
    cup, nest = np.array(legs).T - 1
    apart = pose.points(fixtures.nests_mm)[nest] - fixtures.cups_mm[cup]
    length = np.linalg.norm(apart, axis=1)
    unit = apart / length[:, None]
    gradient = np.einsum("ni,nij->nj", unit, points_gradient(pose, fixtures.nests_mm)[nest])
    added = np.zeros((len(legs), len(legs)))
    if fixtures.cups_covariance_mm2 is not None:
        added += _through(unit, cup, fixtures.cups_covariance_mm2)
    if fixtures.nests_covariance_mm2 is not None:
        added += _through(unit @ pose.rotation, nest, fixtures.nests_covariance_mm2)
    return LinearLegs(np.asarray(length), gradient, added)


def _through(unit: FloatArray, point: IntArray, covariance: FloatArray) -> FloatArray:
    """Return the covariance (n, n) of lengths along `unit` from points whose covariance is given."""
    blocks = covariance.reshape(len(covariance) // 3, 3, -1, 3)[point][:, :, point]
    added: FloatArray = np.einsum("ni,nimj,mj->nm", unit, blocks, unit)
    return added


def foreseen(config: int, fixtures: Fixtures, pose: Pose, covariance: FloatArray) -> PoseForecast:
    """Foresee the lengths of every pair of cup and nest at a commanded pose.

    Parameters
    ----------
    config : int
        Number of the configuration in the campaign.
    fixtures : Fixtures
    pose : Pose
        Where the last frame is believed to be.
    covariance : ndarray, shape (6, 6)
        Of that belief: shift [mm], then turn [rad], about the axes of the cups' frame.

    Returns
    -------
    PoseForecast
    """
    legs = tuple((cup, nest) for cup in range(1, len(fixtures.cups_mm) + 1) for nest in (1, 2, 3))
    linear = linear_legs(fixtures, legs, pose)
    total = linear.gradient @ covariance @ linear.gradient.T + linear.fixtures_covariance_mm2
    return PoseForecast(config, legs, tuple(linear.length_mm.tolist()), tuple(map(tuple, total.tolist())))
