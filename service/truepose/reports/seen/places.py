"""What errors show over reach, and over the work space."""

from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.sentences import Sentence, said
from truepose.reports.wording.rounding import millimetres

_CLEAR: Final = 4.0  # standard deviations of what chance gives
_FEWEST: Final = 12  # readings
_COVERED: Final = 2.0  # times what the model is uncertain by
_DEPENDENT: Final = 2.0  # by which pairs of neighbours, who share readings, vary more than independent ones


def reach_sentence(reach_mm: FloatArray, error_mm: FloatArray) -> Sentence:
    """Return whether errors grow with the distance from axis 1, by ranks (Spearman).

    Parameters
    ----------
    reach_mm, error_mm : ndarray, shape (n,)
        Distance from axis 1, and size of the error there.
    """
    n = len(reach_mm)
    if n < _FEWEST or np.ptp(reach_mm) <= 0.0:
        return said("seen.reach.few")
    ranks = np.array([np.argsort(np.argsort(values)) for values in (reach_mm, error_mm)])
    correlation = float(np.corrcoef(ranks)[0, 1])
    if abs(correlation) * np.sqrt(n - 1) < _CLEAR:
        return said("seen.reach.nothing")
    near, far = (error_mm[part].mean() for part in np.array_split(np.argsort(reach_mm), 3)[::2])
    key = "seen.reach.grows" if correlation > 0.0 else "seen.reach.falls"
    return said(key, near=millimetres(float(near)), far=millimetres(float(far)))


def neighbours_sentence(position_mm: FloatArray, error_mm: FloatArray, model_share: float = 0.0) -> Sentence:
    """Return whether errors of neighbours point alike: what no noise does.

    Parameters
    ----------
    position_mm, error_mm : ndarray, shape (n, 3)
    model_share : float
        Share of the mean square that the uncertainty of the model's own parameters explains: it is alike for
        neighbours, and no finding.
    """
    size = np.linalg.norm(error_mm, axis=1)
    known = size > 0.0
    if known.sum() < _FEWEST:
        return said("seen.space.few")
    place, direction = position_mm[known], error_mm[known] / size[known, None]
    cosine = float((direction * direction[_nearest(place)]).sum(axis=1).mean())
    # The cosine of two directions by chance has mean 0 and variance 1/3.
    chance = _CLEAR / np.sqrt(3.0 * len(place) / _DEPENDENT)
    if cosine < chance + _COVERED * model_share:
        return said("seen.space.nothing")
    return said("seen.space.alike", cosine=cosine)


def _nearest(place: FloatArray) -> IntArray:
    """Return the nearest other place of each; where several stand at one place, another one of them."""
    from scipy.spatial import KDTree

    found = np.asarray(KDTree(place).query(place, k=2)[1])
    return np.where(found[:, 0] == np.arange(len(place)), found[:, 1], found[:, 0])
