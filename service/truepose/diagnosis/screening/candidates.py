"""The pool: all candidates with their columns, linearised at one fit, and what fitting some of them leaves.

Columns are the whitened derivatives of parameters that the fitted model does not have. Causes propose
parameters (`candidate_columns`); smooth families are given as terms (`term_columns`).

Everything that is asked of it is linear: a pick is fitted beside the present model by its products, and so is
the model itself without some of its readings.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from truepose.diagnosis.screening.normal_equations import (
    NormalEquations,
    Products,
    Sums,
    normal_of,
    products_of,
)
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.effects.causes import Candidate
from truepose.effects.ports import ParameterSpec, Term
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.derivatives import candidate_terms, trial_derivatives, tried
from truepose.identification.model.evaluation import State

_LARGEST = 6_000_000  # numbers in one chunk of derivatives: what stays near the processor


def candidate_columns(fit: RobustFit, candidates: Sequence[Candidate]) -> FloatArray:
    """Return whitened derivatives of all parameters of the candidates, shape (K, m)."""
    columns = np.empty((sum(len(one.specs) for one in candidates), len(fit.solution.final.residual)))
    first = 0
    for chunk in _chunks(candidates, _chunk_size(fit)):
        specs = _specs(chunk)
        last = first + len(specs)
        _fill(columns[first:last], fit, specs, [_terms(result.state, chunk) for result in fit.results])
        first = last
    return columns


def candidate_motions(fit: RobustFit, candidates: Sequence[Candidate]) -> Iterator[FloatArray]:
    """Yield how each reading of the first block moves per unit of each candidate's parameters, (k, n, d)."""
    block, state = fit.blocks[0], fit.results[0].state
    for chunk in _chunks(candidates, _chunk_size(fit)):
        specs = _specs(chunk)
        motions = trial_derivatives(block.derivatives(tried(state, specs, _terms(state, chunk))), state)
        yield from np.split(motions, np.cumsum([len(candidate.specs) for candidate in chunk])[:-1])


def _chunks(candidates: Sequence[Candidate], size: int) -> Iterator[list[Candidate]]:
    """Yield runs of candidates of at most so many parameters, never less than one."""
    chunk, count = list[Candidate](), 0
    for candidate in candidates:
        if chunk and count + len(candidate.specs) > size:
            yield chunk
            chunk, count = [], 0
        chunk.append(candidate)
        count += len(candidate.specs)
    if chunk:
        yield chunk


def _chunk_size(fit: RobustFit) -> int:
    rows = max(len(block.weights) for block in fit.blocks)
    return max(12, _LARGEST // (3 * max(rows, 1)))


def _specs(candidates: Sequence[Candidate]) -> tuple[ParameterSpec, ...]:
    return tuple(spec for candidate in candidates for spec in candidate.specs)


def _terms(state: State, candidates: Sequence[Candidate]) -> tuple[Term, ...]:
    """Return how the parameters of all candidates act, numbered from 0."""
    found: list[Term] = []
    first = 0
    for effect, names in _runs(candidates):
        found += candidate_terms(state, effect, names, first)
        first += len(names)
    return tuple(found)


def _runs(candidates: Sequence[Candidate]) -> list[tuple[str, tuple[str, ...]]]:
    """Names of successive candidates of one effect, together."""
    runs: list[tuple[str, list[str]]] = []
    for candidate in candidates:
        if not runs or runs[-1][0] != candidate.effect:
            runs.append((candidate.effect, []))
        runs[-1][1].extend(candidate.names)
    return [(effect, tuple(names)) for effect, names in runs]


def term_columns(fit: RobustFit, terms: Sequence[tuple[Term, ...]], count: int) -> FloatArray:
    """Return whitened derivatives of `count` parameters by their terms in each block, shape (count, m)."""
    specs = tuple(ParameterSpec(f"trial_{k}", "1", 0.0, 1.0) for k in range(count))
    columns = np.empty((count, len(fit.solution.final.residual)))
    _fill(columns, fit, specs, terms)
    return columns


def _fill(
    columns: FloatArray, fit: RobustFit, specs: tuple[ParameterSpec, ...], terms: Sequence[tuple[Term, ...]]
) -> None:
    """Write the whitened derivatives of parameters by their terms in each block, block beside block."""
    first = 0
    for block, result, acting in zip(fit.blocks, fit.results, terms, strict=True):
        derivatives = block.derivatives(tried(result.state, specs, acting))
        white = result.whitening.apply(trial_derivatives(derivatives, result.state))
        width = white.shape[1] * white.shape[2]
        columns[:, first : first + width] = white.reshape(len(specs), width)
        first += width


class EqualCandidates(NamedTuple):
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
    alike: tuple[EqualCandidates, ...]  # of those that are no functions
    functions: tuple[int, ...]  # which candidates are
    normal: NormalEquations
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
    model: tuple[NormalEquations, RobustFit],
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
) -> EqualCandidates:
    rows = starts[here][:, None] + np.arange(count)
    gram = np.stack([grams[index] for index in here.tolist()])
    scale = np.sqrt(np.maximum(np.einsum("cii->ci", gram), 1e-300))
    belief = 1.0 / (widths[rows] * scale) ** 2
    return EqualCandidates(here, rows, scale, gram / (scale[:, :, None] * scale[:, None, :]), belief)
