"""The pool: all candidates with their columns, linearised at one fit, and what fitting some of them leaves.

Everything that is asked of it is linear: a pick is fitted beside the present model by its products, and so is
the model itself without some of its readings.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from truepose.diagnosis.screening.columns import candidate_columns
from truepose.diagnosis.screening.normal_equations import (
    Normal,
    Products,
    Sums,
    normal_of,
    products_of,
)
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.effects.causes import Candidate
from truepose.identification.fit.robust import RobustFit


class Alike(NamedTuple):
    """Candidates of one number of parameters, scaled to columns of length 1."""

    here: IntArray  # (C,) which candidates
    rows: IntArray  # (C, k) their columns
    scale: FloatArray  # (C, k) lengths of the columns
    gram: FloatArray  # (C, k, k) products among the unit columns
    belief: FloatArray  # (C, k) precision that the priors give the unit columns


@dataclass(frozen=True, slots=True)
class Pool:
    """Candidates with their columns, beside a fitted model."""

    all: tuple[Candidate, ...]
    tried: FloatArray  # (C,) from how many variants of its cause and subject each was chosen; 1: it has none
    shares: FloatArray  # (C,) how often chance had a chance for each: every cause has the same share of it
    products: Products  # of all K columns
    starts: tuple[int, ...]  # first column of each candidate
    grams: tuple[FloatArray, ...]  # (k, k) products among the columns of each candidate
    alike: tuple[Alike, ...]  # of those that are no functions
    functions: tuple[int, ...]  # which candidates are
    normal: Normal
    fit: RobustFit

    def own(self, index: int) -> slice:
        """Return the columns of one candidate."""
        first = self.starts[index]
        return slice(first, first + len(self.all[index].specs))

    def index_of(self, pick: Candidate) -> int:
        """Return which candidate a pick was, whatever its size is now."""
        return next(index for index, candidate in enumerate(self.all) if candidate.same_as(pick))

    def rows(self, index: int) -> FloatArray:
        """Return the columns of one candidate, shape (k, m)."""
        return self.products.columns[self.own(index)]

    def rows_of(self, indices: Sequence[int]) -> IntArray:
        """Return which columns belong to some candidates, theirs in turn."""
        owned = [np.arange(self.own(index).start, self.own(index).stop) for index in indices]
        return np.concatenate([np.zeros(0, dtype=np.int64), *owned])

    def view(self, without: tuple[str, ...] = ()) -> "View":
        """Return the candidates as they stand beside the model, as if `without` had not been fitted."""
        past = self.normal.past(without)
        absorbed = past.absorbed(self.products)
        fitted = frozenset(self.normal.names).difference(without)
        return View(self, past.sums, absorbed, past.towards(self.products, absorbed), fitted)

    def of(self, indices: Sequence[int]) -> "Pool":
        """Return the pool with some candidates only, each still chosen from as many."""
        here = np.asarray(indices, dtype=np.int64)
        return _assembled(
            tuple(self.all[index] for index in indices),
            self.products.rows(self.rows_of(indices)),
            tuple(self.grams[index] for index in indices),
            (self.tried[here], self.shares[here]),
            (self.normal, self.fit),
        )

    def beside(self, index: int, pick: Candidate) -> "Pool":
        """Return the pool with a candidate fitted too, to first order, under the prior that the pick has."""
        own = self.products.rows(self.own(index))
        widths = np.array([spec.prior_width for spec in pick.specs])
        across = np.hstack([self.products.with_jacobian, self.products.columns @ own.columns.T])
        return replace(
            self,
            products=replace(self.products, with_jacobian=across),
            normal=self.normal.beside(own, widths, pick.names),
        )

    def of_rows(self, rows: BoolArray) -> "Pool":
        """Return the pool as it were from some of the stacked observations (m,) alone, to first order."""
        final = self.fit.solution.final
        columns = self.products.columns[:, rows]
        products = Products(columns, columns @ final.jacobian[:, rows].T, columns @ final.residual[rows])
        counted = (self.tried, self.shares)
        return _assembled(
            self.all, products, _grams(self.all, columns), counted, (normal_of(self.fit, rows), self.fit)
        )


@dataclass(frozen=True, slots=True)
class View:
    """Candidates beside what is fitted."""

    pool: Pool
    sums: Sums
    absorbed: FloatArray  # (K, q)
    towards: FloatArray  # (K,) products with the residuals
    fitted: frozenset[str]  # parameters past which it is looked

    @property
    def parameters(self) -> int:
        """Number of parameters that are fitted."""
        return int(self.absorbed.shape[1])

    def gram(self, index: int) -> FloatArray:
        """Return the products among one candidate's columns past what is fitted, shape (k, k)."""
        absorbed = self.absorbed[self.pool.own(index)]
        return np.asarray(self.pool.grams[index] - absorbed @ absorbed.T)


def pooled(fit: RobustFit, candidates: Sequence[Candidate]) -> Pool:
    """Linearise candidates at a fit."""
    columns = candidate_columns(fit, candidates)
    return _assembled(
        tuple(candidates),
        products_of(fit, columns),
        _grams(candidates, columns),
        _counted(candidates),
        (normal_of(fit), fit),
    )


def _assembled(
    candidates: tuple[Candidate, ...],
    products: Products,
    grams: tuple[FloatArray, ...],
    counted: tuple[FloatArray, FloatArray],
    model: tuple[Normal, RobustFit],
) -> Pool:
    sizes = np.array([len(candidate.specs) for candidate in candidates], dtype=int)
    starts = np.cumsum(sizes) - sizes
    widths = np.array([spec.prior_width for candidate in candidates for spec in candidate.specs])
    function = np.array([candidate.function for candidate in candidates], dtype=bool)
    alike = tuple(
        _alike(np.flatnonzero((sizes == count) & ~function), count, starts, widths, grams)
        for count in np.unique(sizes[~function]).tolist()
    )
    functions = tuple(np.flatnonzero(function).tolist())
    return Pool(candidates, *counted, products, tuple(starts.tolist()), grams, alike, functions, *model)


def _grams(candidates: Sequence[Candidate], columns: FloatArray) -> tuple[FloatArray, ...]:
    grams, first = [], 0
    for candidate in candidates:
        own = columns[first : first + len(candidate.specs)]
        grams.append(own @ own.T)
        first += len(candidate.specs)
    return tuple(grams)


def _counted(candidates: Sequence[Candidate]) -> tuple[FloatArray, FloatArray]:
    variants = Counter((candidate.effect, candidate.subject) for candidate in candidates)
    of_effect = Counter(candidate.effect for candidate in candidates)
    tried = [variants[one.effect, one.subject] if one.variant else 1 for one in candidates]
    shares = [len(of_effect) * of_effect[candidate.effect] for candidate in candidates]
    return np.array(tried, dtype=float), np.array(shares, dtype=float)


def _alike(
    here: IntArray, count: int, starts: IntArray, widths: FloatArray, grams: Sequence[FloatArray]
) -> Alike:
    rows = starts[here][:, None] + np.arange(count)
    gram = np.stack([grams[index] for index in here.tolist()])
    scale = np.sqrt(np.maximum(np.einsum("cii->ci", gram), 1e-300))
    belief = 1.0 / (widths[rows] * scale) ** 2
    return Alike(here, rows, scale, gram / (scale[:, :, None] * scale[:, None, :]), belief)
