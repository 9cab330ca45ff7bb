"""The pool: all candidates with their columns, linearised at one fit, and what fitting some of them leaves.

Columns are the whitened derivatives of parameters that the fitted model does not have. Causes propose
parameters (`candidate_columns`); smooth families are given as terms (`term_columns`).

Everything that is asked of it is linear: a pick is fitted beside the present model by its products, and so is
the model itself without some of its readings.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
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
    """Return the whitened derivatives of all parameters of the candidates.

    Parameters
    ----------
    fit : RobustFit
        Of m stacked observations.
    candidates : sequence of Candidate
        With K parameters altogether.

    Returns
    -------
    ndarray, shape (K, m)
        Per internal unit of each parameter, at the fitted values.
    """
    # Written where they stay: to put chunks together afterwards would copy all of them once more.
    columns = np.empty((sum(len(one.specs) for one in candidates), len(fit.solution.final.residual)))
    first = 0
    for chunk in _chunks(candidates, _chunk_size(fit)):
        specs = _specs(chunk)
        last = first + len(specs)
        _fill(columns[first:last], fit, specs, [_terms(result.state, chunk) for result in fit.results])
        first = last
    return columns


def candidate_motions(fit: RobustFit, candidates: Sequence[Candidate]) -> Iterator[FloatArray]:
    """Yield how each reading of the first block moves per unit of each candidate's parameters.

    Parameters
    ----------
    fit : RobustFit
        Whose first block has n readings of d components.
    candidates : sequence of Candidate

    Yields
    ------
    ndarray, shape (k, n, d)
        Of each candidate in turn, not whitened [mm per internal unit].
    """
    block, state = fit.blocks[0], fit.results[0].state
    for chunk in _chunks(candidates, _chunk_size(fit)):
        specs = _specs(chunk)
        motions = trial_derivatives(block.derivatives(tried(state, specs, _terms(state, chunk))), state)
        yield from np.split(motions, np.cumsum([len(candidate.specs) for candidate in chunk])[:-1])


def _chunks(candidates: Sequence[Candidate], size: int) -> Iterator[list[Candidate]]:
    """Yield runs of candidates of at most so many parameters, never less than one."""
    chunk, count = list[Candidate](), 0
    # Counted as it grows: to count each chunk anew took a tenth of a diagnosis of 600 readings.
    for candidate in candidates:
        if chunk and count + len(candidate.specs) > size:
            yield chunk
            chunk, count = [], 0
        chunk.append(candidate)
        count += len(candidate.specs)
    if chunk:
        yield chunk


def _chunk_size(fit: RobustFit) -> int:
    """Return how many parameters go together: three components of every reading of each."""
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
    """Return the whitened derivatives of parameters that are given by their terms.

    Parameters
    ----------
    fit : RobustFit
        Of m stacked observations.
    terms : sequence of tuple of Term
        How the parameters act in each block of the fit, in its order; numbered from 0.
    count : int
        How many parameters there are.

    Returns
    -------
    ndarray, shape (count, m)
    """
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
    """C candidates of k parameters each, scaled to columns of length 1, so that one call decomposes them all.

    Attributes
    ----------
    here : ndarray of int, shape (C,)
        Which candidates of the pool.
    rows : ndarray of int, shape (C, k)
        Their columns.
    scale : ndarray, shape (C, k)
        Lengths of the columns.
    gram : ndarray, shape (C, k, k)
        Products among the unit columns.
    belief : ndarray, shape (C, k)
        Precision that the priors give the unit columns.
    """

    here: IntArray
    rows: IntArray
    scale: FloatArray
    gram: FloatArray
    belief: FloatArray


@dataclass(frozen=True, slots=True)
class Pool:
    """C candidates with their K columns, beside a fitted model.

    Attributes
    ----------
    all : tuple of Candidate
    tried : ndarray, shape (C,)
        From how many variants of its cause and subject each was chosen; 1: nothing was searched.
    shares : ndarray, shape (C,)
        By what a p value is multiplied: the number of causes, times the candidates of its cause.
    products : Products
        Of all K columns.
    starts : tuple of int
        First column of each candidate.
    grams : tuple of ndarray, shape (k, k)
        Products among the columns of each candidate.
    alike : tuple of EqualCandidates
        Those that are no functions, by their number of parameters.
    functions : tuple of int
        Which candidates are functions.
    owners : mapping of str to sequence of int
        Which candidates have a parameter of that name.
    normal : NormalEquations
        Of the fitted model, and of what was fitted beside it since.
    fit : RobustFit
        Where everything is linearised.
    """

    all: tuple[Candidate, ...]
    tried: FloatArray
    shares: FloatArray
    products: Products
    starts: tuple[int, ...]
    grams: tuple[FloatArray, ...]
    alike: tuple[EqualCandidates, ...]
    functions: tuple[int, ...]
    owners: Mapping[str, Sequence[int]]
    normal: NormalEquations
    fit: RobustFit

    def own(self, index: int) -> slice:
        """Return the columns of one candidate, as a slice of all K."""
        first = self.starts[index]
        return slice(first, first + len(self.all[index].specs))

    def index_of(self, pick: Candidate) -> int:
        """Return which candidate a pick of the pool was, whatever its size is now."""
        return next(index for index, candidate in enumerate(self.all) if candidate.same_as(pick))

    def rows(self, index: int) -> FloatArray:
        """Return the columns of one candidate, shape (k, m)."""
        return self.products.columns[self.own(index)]

    def rows_of(self, indices: Sequence[int]) -> IntArray:
        """Return which columns belong to some candidates, theirs in turn, shape (sum of k,)."""
        owned = [np.arange(self.own(index).start, self.own(index).stop) for index in indices]
        return np.concatenate([np.zeros(0, dtype=np.int64), *owned])

    def view(self, without: tuple[str, ...] = ()) -> "View":
        """Return the candidates as they stand beside the model.

        Parameters
        ----------
        without : tuple of str
            Parameters of the model that are left out, as if they had not been fitted.

        Returns
        -------
        View
        """
        past = self.normal.past(without)
        absorbed = past.absorbed(self.products)
        fitted = frozenset(self.normal.names).difference(without)
        return View(self, past.sums, absorbed, past.towards(self.products, absorbed), fitted)

    def of(self, indices: Sequence[int]) -> "Pool":
        """Return the pool with some candidates only.

        Parameters
        ----------
        indices : sequence of int

        Returns
        -------
        Pool
            Each candidate still counts as chosen from as many as before.
        """
        here = np.asarray(indices, dtype=np.int64)
        return _assembled(
            tuple(self.all[index] for index in indices),
            self.products.rows(self.rows_of(indices)),
            tuple(self.grams[index] for index in indices),
            (self.tried[here], self.shares[here]),
            (self.normal, self.fit),
        )

    def beside(self, index: int, pick: Candidate) -> "Pool":
        """Return the pool with a candidate fitted too, to first order.

        Parameters
        ----------
        index : int
            Of the candidate.
        pick : Candidate
            The same, with the prior that it is fitted under.

        Returns
        -------
        Pool
            Of the same candidates, the fitted one among them.
        """
        own = self.products.rows(self.own(index))
        widths = np.array([spec.prior_width for spec in pick.specs])
        across = np.hstack([self.products.with_jacobian, self.products.columns @ own.columns.T])
        return replace(
            self,
            products=replace(self.products, with_jacobian=across),
            normal=self.normal.beside(own, widths, pick.names),
        )

    def of_rows(self, rows: BoolArray) -> "Pool":
        """Return the pool as it were from some of the stacked observations alone, to first order.

        Parameters
        ----------
        rows : ndarray of bool, shape (m,)

        Returns
        -------
        Pool
            Linearised where this one is: no parameter has taken its step yet.
        """
        final = self.fit.solution.final
        # The parameters stay where all readings put them: the step that these readings ask for is the
        # projection's.
        columns = self.products.columns[:, rows]
        products = Products(columns, columns @ final.jacobian[:, rows].T, columns @ final.residual[rows])
        counted = (self.tried, self.shares)
        return _assembled(
            self.all, products, _grams(self.all, columns), counted, (normal_of(self.fit, rows), self.fit)
        )


@dataclass(frozen=True, slots=True)
class View:
    """Candidates beside what is fitted.

    Attributes
    ----------
    pool : Pool
    sums : Sums
        Of the residuals that the fitted parameters leave.
    absorbed : ndarray, shape (K, q)
        Coordinates of the columns in what q parameters take up.
    towards : ndarray, shape (K,)
        Products of the columns with the residuals left.
    fitted : frozenset of str
        Names of the q parameters.
    """

    pool: Pool
    sums: Sums
    absorbed: FloatArray
    towards: FloatArray
    fitted: frozenset[str]

    @property
    def taken(self) -> set[int]:
        """Candidates of which some parameter is fitted."""
        return {index for name in self.fitted for index in self.pool.owners.get(name, ())}

    @property
    def parameters(self) -> int:
        """Number of parameters that are fitted."""
        return int(self.absorbed.shape[1])

    def gram(self, index: int) -> FloatArray:
        """Return the products among one candidate's columns past what is fitted, shape (k, k)."""
        absorbed = self.absorbed[self.pool.own(index)]
        return np.asarray(self.pool.grams[index] - absorbed @ absorbed.T)


def pool_candidates(fit: RobustFit, candidates: Sequence[Candidate]) -> Pool:
    """Linearise candidates at a fit.

    Parameters
    ----------
    fit : RobustFit
    candidates : sequence of Candidate
        May be empty.

    Returns
    -------
    Pool
    """
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
    """Return a pool of what was computed; candidates of equal size are put together."""
    sizes = np.array([len(candidate.specs) for candidate in candidates], dtype=int)
    starts = np.cumsum(sizes) - sizes
    widths = np.array([spec.prior_width for candidate in candidates for spec in candidate.specs])
    function = np.array([candidate.function for candidate in candidates], dtype=bool)
    alike = tuple(
        _alike(np.flatnonzero((sizes == count) & ~function), count, starts, widths, grams)
        for count in np.unique(sizes[~function]).tolist()
    )
    functions = tuple(np.flatnonzero(function).tolist())
    owners: dict[str, list[int]] = {}
    for index, candidate in enumerate(candidates):
        for name in candidate.names:
            owners.setdefault(name, []).append(index)
    return Pool(
        candidates, *counted, products, tuple(starts.tolist()), grams, alike, functions, owners, *model
    )


def _grams(candidates: Sequence[Candidate], columns: FloatArray) -> tuple[FloatArray, ...]:
    """Return the products among the columns (K, m) of each candidate, shape (k, k) each."""
    ends = np.cumsum([len(candidate.specs) for candidate in candidates], dtype=int)
    return tuple(own @ own.T for own in np.split(columns, ends)[:-1])


def _counted(candidates: Sequence[Candidate]) -> tuple[FloatArray, FloatArray]:
    """Return for each candidate how many variants it was chosen from, and its share of the level.

    With N causes and n_c candidates of cause c, a p value counts N n_c times: every cause has the same share
    of the level, divided evenly among its candidates (weighted Bonferroni; C. Genovese et al., Biometrika
    93(3), 2006, 509-524).
    """
    variants = Counter((candidate.effect, candidate.subject) for candidate in candidates)
    of_effect = Counter(candidate.effect for candidate in candidates)
    # The plain shape of a cause (variant 0) was not searched for, so it does not pay for the search of the
    # others. While it did, 4 of 20 even drifts were reported as settling.
    tried = [variants[one.effect, one.subject] if one.variant else 1 for one in candidates]
    shares = [len(of_effect) * of_effect[candidate.effect] for candidate in candidates]
    return np.array(tried, dtype=float), np.array(shares, dtype=float)


def _alike(
    here: IntArray, count: int, starts: IntArray, widths: FloatArray, grams: Sequence[FloatArray]
) -> EqualCandidates:
    """Return candidates of one number of parameters, as stacked arrays."""
    rows = starts[here][:, None] + np.arange(count)
    gram = np.stack([grams[index] for index in here.tolist()])
    # A parameter that no reading feels has a column of zeros; it must not divide by zero.
    scale = np.sqrt(np.maximum(np.einsum("cii->ci", gram), 1e-300))
    belief = 1.0 / (widths[rows] * scale) ** 2
    return EqualCandidates(here, rows, scale, gram / (scale[:, :, None] * scale[:, None, :]), belief)
