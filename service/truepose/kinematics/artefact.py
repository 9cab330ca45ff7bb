r"""An artefact whose pose is read: where its nests have their centre, and how exactly a pose is known there.

Nests whose coordinates err by sigma each, all alike, give a rigid body the errors

    of its centre        sigma / sqrt(K)                             per axis
    of its turn          sigma sqrt(tr((sum of (|r|^2 I - r r^T))^-1) / 3)      per axis, RMS of the three

for K nests at r from their centre; at the centre, and nowhere else, the two have nothing in common. A
rigid body keeps six of the 3 K errors, so that its nests err by sigma sqrt(2 / K) only: this is what
instruments state.
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray

_OF_A_RIGID_BODY = 6.0


@dataclass(frozen=True, slots=True)
class PoseUncertainty:
    """Standard uncertainties per axis of a pose, read at the artefact's centre."""

    position_mm: float
    rotation_rad: float


def centre(nests_mm: FloatArray) -> FloatArray:
    """Return the centre of nests (K, 3), shape (3,)."""
    return np.asarray(nests_mm.mean(axis=0))


def pose_uncertainty(nests_mm: FloatArray, nest_mm: float) -> PoseUncertainty:
    """Return how exactly a pose is known whose nests are known to `nest_mm` per coordinate.

    Parameters
    ----------
    nests_mm : ndarray, shape (K, 3)
        K >= 3, not on a line.
    nest_mm : float
        Standard uncertainty per coordinate of the nests of the artefact as placed.
    """
    arms = nests_mm - centre(nests_mm)
    sigma_mm = nest_mm * np.sqrt(nests_mm.size / _OF_A_RIGID_BODY)
    squares = (arms**2).sum() * np.eye(3) - arms.T @ arms
    turn = sigma_mm * np.sqrt(np.trace(np.linalg.inv(squares)) / 3.0)
    return PoseUncertainty(float(sigma_mm / np.sqrt(len(arms))), float(turn))


def normal(nests_mm: FloatArray) -> FloatArray:
    """Return the normal of the plane of the first three nests, away from the last frame's origin, (3,)."""
    first, second, third = nests_mm[:3]
    across = np.cross(second - first, third - first)
    away = across if across @ centre(nests_mm) >= 0.0 else -across
    return np.asarray(away / np.linalg.norm(away))
