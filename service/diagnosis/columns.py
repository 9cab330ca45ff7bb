"""Columns: the whitened derivatives of parameters that the fitted model does not have.

Causes propose parameters (`candidate_columns`); smooth families are given as terms (`term_columns`).
"""

from collections.abc import Iterator, Sequence

import numpy as np

from service.domain.arrays import FloatArray
from service.effects.causes import Candidate
from service.effects.ports import ParameterSpec, Term
from service.identification.evaluation import State
from service.identification.robust import RobustFit
from service.identification.trial import candidate_terms, trial_derivatives, tried

_LARGEST = 3_000_000  # numbers in one chunk of derivatives: what stays near the processor


def candidate_columns(fit: RobustFit, candidates: Sequence[Candidate]) -> FloatArray:
    """Return whitened derivatives of all parameters of the candidates, shape (K, m)."""
    rows = max(len(block.weights) for block in fit.blocks)
    size = max(12, _LARGEST // (3 * max(rows, 1)))
    chunks = [_candidate_chunk(fit, chunk) for chunk in _chunks(candidates, size)]
    m = len(fit.solution.final.residual)
    return np.concatenate(chunks) if chunks else np.zeros((0, m))


def candidate_motions(fit: RobustFit, candidates: Sequence[Candidate]) -> Iterator[FloatArray]:
    """Yield how each reading of the first block moves per unit of each candidate's parameters, (k, n, d)."""
    block, state = fit.blocks[0], fit.results[0].state
    for candidate in candidates:
        acting = candidate_terms(state, candidate.effect, candidate.names, 0)
        yield trial_derivatives(block.derivatives(tried(state, candidate.specs, acting)), state)


def _chunks(candidates: Sequence[Candidate], size: int) -> list[list[Candidate]]:
    chunks: list[list[Candidate]] = [[]]
    for candidate in candidates:
        if sum(len(other.specs) for other in chunks[-1]) + len(candidate.specs) > size and chunks[-1]:
            chunks.append([])
        chunks[-1].append(candidate)
    return [chunk for chunk in chunks if chunk]


def _candidate_chunk(fit: RobustFit, candidates: Sequence[Candidate]) -> FloatArray:
    specs = tuple(spec for candidate in candidates for spec in candidate.specs)

    def terms(state: State) -> tuple[Term, ...]:
        found: list[Term] = []
        first = 0
        for effect, names in _runs(candidates):
            found += candidate_terms(state, effect, names, first)
            first += len(names)
        return tuple(found)

    return _columns(fit, specs, [terms(result.state) for result in fit.results])


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
    return _columns(fit, specs, terms)


def _columns(
    fit: RobustFit, specs: tuple[ParameterSpec, ...], terms: Sequence[tuple[Term, ...]]
) -> FloatArray:
    parts = []
    for block, result, acting in zip(fit.blocks, fit.results, terms, strict=True):
        derivatives = block.derivatives(tried(result.state, specs, acting))
        own = trial_derivatives(derivatives, result.state)
        parts.append(result.whitening.apply(own).reshape(len(specs), -1))
    return np.concatenate(parts, axis=1)
