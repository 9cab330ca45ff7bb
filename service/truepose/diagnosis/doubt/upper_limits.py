r"""Upper limits: how large a cause that was not found could still be.

Past the fitted model a candidate's parameters w have the mean m and the covariance C, priors included. With
M the products of the motions that they give the tool, averaged over the readings, its mean square is the
quadratic form w^T M w with the moments

    mean = m^T M m + tr(M C),    variance = 2 tr(M C M C) + 4 m^T M C M m.

The limit is the root of its 95 % quantile, that of the scaled chi-square of these moments.

References
----------
F. E. Satterthwaite, Biometrics Bulletin 2(6), 1946, 110-114 (a chi-square of the same two moments).
"""

from collections.abc import Sequence

import numpy as np

from truepose.diagnosis.screening.candidates import View
from truepose.diagnosis.screening.columns import candidate_motions
from truepose.domain.arrays import FloatArray
from truepose.identification.distributions import chi2_limit

_BEYOND = 0.05  # chance that it is larger all the same


def upper_limits_mm(view: View, chosen: Sequence[int]) -> tuple[float, ...]:
    """Return how large candidates could still be, RMS at the tool over the readings [mm].

    Parameters
    ----------
    view : View
        All candidates beside the fitted model.
    chosen : sequence of int
        Which of them; none of them a function, whose size has no prior.
    """
    motions = candidate_motions(view.pool.fit, [view.pool.all[index] for index in chosen])
    return tuple(_limit(view, index, motion) for index, motion in zip(chosen, motions, strict=True))


def _limit(view: View, index: int, motion_mm: FloatArray) -> float:
    mean, covariance = _posterior(view, index)
    readings = motion_mm.shape[1]
    products = np.einsum("ink,jnk->ij", motion_mm, motion_mm) / readings
    spread = products @ covariance
    size = float(mean @ products @ mean + np.trace(spread))
    variance = float(2.0 * np.trace(spread @ spread) + 4.0 * mean @ spread @ products @ mean)
    if size <= 0.0 or variance <= 0.0:
        return 0.0
    degrees = 2.0 * size**2 / variance
    return float(np.sqrt(size / degrees * chi2_limit(_BEYOND, degrees)))


def _posterior(view: View, index: int) -> tuple[FloatArray, FloatArray]:
    """Mean (k,) and covariance (k, k) of a candidate's parameters past what is fitted."""
    own = view.pool.own(index)
    noise = view.sums.variance * view.sums.alike
    widths = np.array([spec.prior_width for spec in view.pool.all[index].specs])
    # In units of the prior widths, so that shifts and turns are alike.
    information = view.gram(index) * np.outer(widths, widths) / noise
    covariance = np.linalg.inv(information + np.eye(len(widths)))
    mean = covariance @ (view.towards[own] * widths) / noise
    return np.asarray(mean * widths), np.asarray(covariance * np.outer(widths, widths))
