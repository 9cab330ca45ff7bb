"""Columns: the whitened derivatives of parameters that the fitted model does not have.

Causes propose parameters (`candidate_columns`); smooth families are given as terms (`term_columns`).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.causes import Candidate
from truepose.effects.ports import ParameterSpec, Term
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.evaluation import State
from truepose.identification.model.trial import candidate_terms, trial_derivatives, tried

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
