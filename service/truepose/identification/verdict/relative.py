"""Relative accuracy: what is left of position errors once the base may stand anywhere.

An absolute figure counts where the model believes the robot to stand, a relative one does not (thesis of
A. Nubiola, 2014, section 1.1): whoever sets up a work object by the robot itself sees the relative one.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import NominalAndIdentified, Statistics
from truepose.identification.verdict.judge import Judged
from truepose.identification.verdict.statistics import expected_noise_mm, statistics
from truepose.kinematics.frames import rigid_alignment

_FEWEST: Final = 4  # three places on a plane are aligned to almost nothing


def relative_errors(judged: Judged) -> NominalAndIdentified | None:
    """Return the statistics after the best rigid alignment; None of lengths, or of too few readings."""
    places = judged.block.place_mm
    if places is None:
        return None
    noise = expected_noise_mm(judged.block)
    nominal, identified = (
        relative_statistics(places - residual, places, noise)
        for residual in (judged.nominal_mm, judged.identified_mm)
    )
    return None if nominal is None or identified is None else NominalAndIdentified(nominal, identified)


def relative_statistics(wanted_mm: FloatArray, places_mm: FloatArray, noise_mm: float) -> Statistics | None:
    """Return what is left of the errors of n places after the best rigid alignment.

    Parameters
    ----------
    wanted_mm, places_mm : ndarray, shape (n, 3)
        Where they should be, and where they were read [mm].
    noise_mm : float
        Mean norm that stated noise alone gives.

    Returns
    -------
    Statistics or None
        None of fewer than four places, or of places on a line: any errors would be aligned away.
    """
    if len(places_mm) < _FEWEST or _on_a_line(places_mm):
        return None
    return statistics(aligned_errors(wanted_mm, places_mm), noise_mm)


def aligned_errors(wanted_mm: FloatArray, places_mm: FloatArray) -> FloatArray:
    """Return what the best rigid alignment leaves of errors, shape (n, 3) [mm]."""
    rotation, translation = rigid_alignment(wanted_mm, places_mm)
    return np.asarray(places_mm - (wanted_mm @ rotation.T + translation))


def rigid_motions(places_mm: FloatArray) -> FloatArray:
    """Return how places move with shifts and small turns about their middle, shape (3 n, 6)."""
    arms = places_mm - places_mm.mean(axis=0)
    turns = np.cross(np.eye(3)[:, None], arms) / max(float(np.abs(arms).max()), 1.0)
    shifts = np.broadcast_to(np.eye(3)[:, None], turns.shape)
    return np.concatenate([shifts, turns]).reshape(6, -1).T


def _on_a_line(places_mm: FloatArray) -> bool:
    widths = np.linalg.svd(places_mm - places_mm.mean(axis=0), compute_uv=False)
    return bool(widths[1] < 1e-3 * max(widths[0], 1e-12))
