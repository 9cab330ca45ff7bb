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

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from service.diagnosis.columns import candidate_columns
from service.diagnosis.footing import Footing
from service.diagnosis.functions import chance, most_likely
from service.diagnosis.normal import Normal, Products, Projection, Sums, normal_of, products_of
from service.domain.arrays import FloatArray, IntArray
from service.effects.causes import Candidate
from service.identification.distributions import f_exceeded
from service.identification.robust import RobustFit

_MOSTLY_BELIEF = 0.1  # what the data see, over what is believed before: below, nothing is seen
_VISIBLE = 1e-7  # share of a derivative's square that the present parameters do not absorb


class Alike(NamedTuple):
    """Candidates of one number of parameters, scaled to columns of length 1."""

    here: IntArray  # (C,) which candidates
    rows: IntArray  # (C, k) their columns
    scale: FloatArray  # (C, k) lengths of the columns
    gram: FloatArray  # (C, k, k) products among the unit columns
    belief: FloatArray  # (C, k) precision that the priors give the unit columns


@dataclass(frozen=True, slots=True)
class Pool:
    """All candidates with their columns, linearised at one fit."""

    all: tuple[Candidate, ...]
    products: Products  # of all K columns
    starts: tuple[int, ...]  # first column of each candidate
    alike: tuple[Alike, ...]  # of those that are no functions
    functions: tuple[int, ...]  # which candidates are
    normal: Normal
    fit: RobustFit

    def own(self, index: int) -> slice:
        """Return the columns of one candidate."""
        first = self.starts[index]
        return slice(first, first + len(self.all[index].specs))

    def rows(self, index: int) -> FloatArray:
        """Return the columns of one candidate, shape (k, m)."""
        return self.products.columns[self.own(index)]

    def view(self, without: tuple[str, ...] = ()) -> "View":
        """Return the candidates as they stand beside the fit, as if `without` had not been fitted."""
        past = self.normal.past(without)
        absorbed = past.absorbed(self.products)
        fitted = frozenset(self.fit.structure.names).difference(without)
        return View(self, past.sums, absorbed, past.towards(self.products, absorbed), fitted)


@dataclass(frozen=True, slots=True)
class View:
    """Candidates beside what is fitted."""

    pool: Pool
    sums: Sums
    absorbed: FloatArray  # (K, q)
    towards: FloatArray  # (K,) products with the residuals
    fitted: frozenset[str]  # parameters past which it is looked

    def with_pick(self, index: int, footing: Footing) -> tuple["View", Footing]:
        """Return view and footing once a candidate is fitted too."""
        new = footing.directions(self.pool.rows(index))
        products = self.pool.products.columns @ new[: footing.size]
        towards = self.towards - products @ (new.T @ footing.residual)
        extended = footing.extended(new)
        sums = replace(self.sums, residual_square=extended.residual_square, degrees=extended.degrees)
        view = View(self.pool, sums, np.hstack([self.absorbed, products]), towards, self.fitted)
        return view, extended


def pooled(fit: RobustFit, candidates: Sequence[Candidate]) -> Pool:
    """Linearise candidates at a fit."""
    columns = candidate_columns(fit, candidates)
    sizes = np.array([len(candidate.specs) for candidate in candidates], dtype=int)
    starts = np.cumsum(sizes) - sizes
    widths = np.array([spec.prior_width for candidate in candidates for spec in candidate.specs])
    function = np.array([candidate.function for candidate in candidates], dtype=bool)
    return Pool(
        all=tuple(candidates),
        products=products_of(fit, columns),
        starts=tuple(starts.tolist()),
        alike=tuple(
            _alike(columns, widths, starts, np.flatnonzero((sizes == count) & ~function), count)
            for count in np.unique(sizes[~function]).tolist()
        ),
        functions=tuple(np.flatnonzero(function).tolist()),
        normal=normal_of(fit),
        fit=fit,
    )


def _alike(columns: FloatArray, widths: FloatArray, starts: IntArray, here: IntArray, count: int) -> Alike:
    rows = starts[here][:, None] + np.arange(count)
    scale = np.sqrt(np.maximum(np.einsum("km,km->k", columns, columns), 1e-300))[rows]
    gram = np.stack([columns[own] @ columns[own].T for own in rows])
    belief = 1.0 / (widths[rows] * scale) ** 2
    return Alike(here, rows, scale, gram / (scale[:, :, None] * scale[:, None, :]), belief)


@dataclass(frozen=True, slots=True)
class Screened:
    """What each candidate would do; C candidates."""

    explained: FloatArray  # (C,) sum of squares T
    size: FloatArray  # (C,) effective number of parameters, 0 where nothing can be seen
    p_value: FloatArray  # (C,) corrected for everything tried
    score: FloatArray  # (C,) gain in BIC, search included; larger is better
    width: FloatArray  # (C,) most likely factor on the prior widths of a function, 1 of what is none


def screen(view: View) -> Screened:
    """Screen all candidates of a view."""
    screened = _screened(view)
    tried, shares = _tried(view.pool.all), _shares(view.pool.all)
    for index in view.pool.functions:
        candidate = view.pool.all[index]
        if not view.fitted.isdisjoint(candidate.names):
            continue  # what its prior holds back of a fitted function is no function once more
        gram, towards = _of_function(view, index)
        found = most_likely(gram, towards, view.sums, widest=1.0 / candidate.size)
        screened.explained[index], screened.size[index] = found.explained, found.size
        screened.width[index] = found.width
        screened.score[index] = found.gain - 2.0 * np.log(tried[index])
        screened.p_value[index] = min(1.0, shares[index] * chance(gram, towards, view.sums))
    return screened


def _of_function(view: View, index: int) -> tuple[FloatArray, FloatArray]:
    """Products of the columns of a function, scaled to its prior widths, past what is fitted."""
    own, candidate = view.pool.own(index), view.pool.all[index]
    widths = np.array([spec.prior_width for spec in candidate.specs])
    columns, absorbed = view.pool.products.columns[own], view.absorbed[own]
    gram = (columns @ columns.T - absorbed @ absorbed.T) * np.outer(widths, widths)
    return gram, view.towards[own] * widths


def _screened(view: View) -> Screened:
    """Screen the candidates that are no functions."""
    candidates, footing = view.pool.all, view.sums
    alike = footing.alike
    explained, size = _explained(view)
    left = np.maximum(footing.residual_square - explained, 1e-9 * footing.residual_square + 1e-300)
    degrees = np.maximum(footing.degrees / alike - size, 1.0)
    seen = size > 0
    ratio = np.where(seen, explained / np.maximum(size, 1), 0.0) / (left / degrees)
    alone = np.where(seen, f_exceeded(ratio, np.maximum(size, 1), degrees), 1.0)
    likelihood = footing.degrees / alike * np.log(footing.residual_square / left)
    score = (
        likelihood - size * np.log(max(footing.observations / alike, 2.0)) - 2.0 * np.log(_tried(candidates))
    )
    return Screened(
        explained=explained,
        size=size,
        p_value=np.minimum(alone * _shares(candidates), 1.0),
        score=np.where(seen, score, -np.inf),
        width=np.ones(len(candidates)),
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


def _shares(candidates: tuple[Candidate, ...]) -> FloatArray:
    """How often chance had a chance for each candidate: every cause has the same share of the level."""
    of_effect = Counter(candidate.effect for candidate in candidates)
    return np.array([len(of_effect) * of_effect[candidate.effect] for candidate in candidates], dtype=float)


def _tried(candidates: tuple[Candidate, ...]) -> FloatArray:
    """How many variants of its cause and subject each candidate was chosen from; what has none, from one."""
    variants = Counter((candidate.effect, candidate.subject) for candidate in candidates)
    counts = [variants[one.effect, one.subject] if one.variant else 1 for one in candidates]
    return np.array(counts, dtype=float)


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
