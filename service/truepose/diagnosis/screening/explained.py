r"""Screening: how much each candidate would explain, and whether that is more than noise would give.

With T the sum of squares that a candidate of k parameters would explain of R, left with nu degrees of
freedom, F = (T / k) / ((R - T) / (nu - k)) is F distributed where the candidate is not there: the size of the
noise is taken from the residuals themselves, never from what is stated. The level is controlled over
everything tried: every cause has the same share of it, divided among its candidates (weighted Bonferroni).

Readings of one stop share what the model lacks there: all counts are divided by the number of readings that
are worth one (design effect, from the residuals themselves).

Candidates are compared by BIC; what was searched over (orders, moments) costs 2 ln of their number.

References
----------
G. A. F. Seber, A. J. Lee, Linear Regression Analysis, 2nd ed., 2003, chapter 4.
C. Genovese, K. Roeder, L. Wasserman, Biometrika 93(3), 2006, 509-524 (weighted Bonferroni).
L. Kish, Survey Sampling, 1965, section 5.4 (design effect).
G. Schwarz, Annals of Statistics 6(2), 1978, 461-464.
"""

from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.distributions import f_exceeded
from truepose.diagnosis.screening.candidates import View
from truepose.diagnosis.screening.normal_equations import Products, Projection
from truepose.diagnosis.screening.random_functions import chance, most_likely
from truepose.domain.arrays import FloatArray

_MOSTLY_BELIEF = 0.1  # what the data see, over what is believed before: below, nothing is seen
_VISIBLE = 1e-7  # share of a derivative's square that the present parameters do not absorb


@dataclass(frozen=True, slots=True)
class Screened:
    """What each candidate would do; C candidates."""

    explained: FloatArray  # (C,) sum of squares T
    size: FloatArray  # (C,) effective number of parameters, 0 where nothing can be seen
    alone: FloatArray  # (C,) p-value of each as if nothing else had been tried
    p_value: FloatArray  # (C,) corrected for everything tried
    score: FloatArray  # (C,) gain in BIC, search included; larger is better
    width: FloatArray  # (C,) most likely factor on the prior widths of a function, 1 of what is none


def screen(view: View) -> Screened:
    """Screen all candidates of a view."""
    screened, pool = _screened(view), view.pool
    for index in pool.functions:
        candidate = pool.all[index]
        if not view.fitted.isdisjoint(candidate.names):
            continue  # what its prior holds back of a fitted function is no function once more
        gram, towards = _of_function(view, index)
        found = most_likely(gram, towards, view.sums, widest=1.0 / candidate.size)
        screened.explained[index], screened.size[index] = found.explained, found.size
        screened.width[index] = found.width
        screened.score[index] = found.gain - 2.0 * np.log(pool.tried[index])
        screened.alone[index] = chance(gram, towards, view.sums)
        screened.p_value[index] = min(1.0, pool.shares[index] * screened.alone[index])
    return screened


def _of_function(view: View, index: int) -> tuple[FloatArray, FloatArray]:
    """Products of the columns of a function, scaled to its prior widths, past what is fitted."""
    widths = np.array([spec.prior_width for spec in view.pool.all[index].specs])
    return view.gram(index) * np.outer(widths, widths), view.towards[view.pool.own(index)] * widths


def _screened(view: View) -> Screened:
    """Screen the candidates that are no functions."""
    sums, pool = view.sums, view.pool
    alike = sums.alike
    explained, size = _explained(view)
    left = np.maximum(sums.residual_square - explained, 1e-9 * sums.residual_square + 1e-300)
    degrees = np.maximum(sums.degrees / alike - size, 1.0)
    seen = size > 0
    ratio = np.where(seen, explained / np.maximum(size, 1), 0.0) / (left / degrees)
    alone = np.where(seen, f_exceeded(ratio, np.maximum(size, 1), degrees), 1.0)
    likelihood = sums.degrees / alike * np.log(sums.residual_square / left)
    score = likelihood - size * np.log(max(sums.observations / alike, 2.0)) - 2.0 * np.log(pool.tried)
    return Screened(
        explained=explained,
        size=size,
        alone=alone,
        p_value=np.minimum(alone * pool.shares, 1.0),
        score=np.where(seen, score, -np.inf),
        width=np.ones(len(pool.all)),
    )


def chance_beside(products: Products, widths: FloatArray, past: Projection, tried: int) -> float:
    """Chance, over everything tried, that noise gives what columns explain past what is fitted."""
    absorbed = past.absorbed(products)
    rows, sums = products.columns, past.sums
    scale = np.sqrt(np.maximum(np.einsum("km,km->k", rows, rows), 1e-300))
    gram = (rows @ rows.T - absorbed @ absorbed.T) / np.outer(scale, scale)
    towards = past.towards(products, absorbed) / scale
    explained, size = _quadratic(gram[None], (1.0 / (widths * scale) ** 2)[None], towards[None])
    if size[0] == 0.0:
        return 1.0
    degrees = max(sums.degrees / sums.alike - size[0], 1.0)
    left = max(sums.residual_square - explained[0], 1e-300)
    ratio = explained[0] / size[0] / (left / degrees)
    return min(1.0, tried * float(f_exceeded(ratio, size[0], degrees)))


def _explained(view: View) -> tuple[FloatArray, FloatArray]:
    explained, size = np.zeros(len(view.pool.all)), np.zeros(len(view.pool.all))
    for alike in view.pool.alike:
        taken = view.absorbed[alike.rows] / alike.scale[:, :, None]
        gram = alike.gram - taken @ np.swapaxes(taken, 1, 2)
        found = _quadratic(gram, alike.belief, view.towards[alike.rows] / alike.scale)
        explained[alike.here], size[alike.here] = found
    return explained, size


def _quadratic(gram: FloatArray, belief: FloatArray, towards: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sum of squares explained, and the number of parameters that can be seen, of C candidates.

    The prior of each parameter is an observation of it: an amplitude that nobody would believe explains
    nothing. A direction that the data see less well than the prior knows it does not count.
    """
    sizes, axes = np.linalg.eigh(gram)
    seen = sizes > _VISIBLE
    within = np.einsum("cij,ci->cj", axes, towards)
    strength = np.einsum("cij,ci->cj", axes**2, belief)
    explained = np.where(seen, within**2 / np.where(seen, sizes + strength, 1.0), 0.0).sum(axis=1)
    return explained, (seen & (sizes > _MOSTLY_BELIEF * strength)).sum(axis=1).astype(float)
