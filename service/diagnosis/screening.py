r"""Screening: how much each candidate would explain, and whether that is more than noise would give.

With T the sum of squares that a candidate of k parameters would explain of R, left with nu degrees of
freedom, F = (T / k) / ((R - T) / (nu - k)) is F distributed where the candidate is not there: the size of the
noise is taken from the residuals themselves, never from what is stated. The level is controlled over
everything tried: every cause has the same share of it, divided among its candidates (weighted Bonferroni).

Candidates are compared by BIC; what was searched over (orders, moments) costs 2 ln of their number.

References
----------
G. A. F. Seber, A. J. Lee, Linear Regression Analysis, 2nd ed., 2003, chapter 4.
C. Genovese, K. Roeder, L. Wasserman, Biometrika 93(3), 2006, 509-524 (weighted Bonferroni).
G. Schwarz, Annals of Statistics 6(2), 1978, 461-464.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import f as f_distribution

from service.diagnosis.footing import Footing
from service.domain.arrays import FloatArray
from service.effects.causes import Candidate

_VISIBLE = 1e-7  # share of a derivative's square that the present parameters do not absorb


@dataclass(frozen=True, slots=True)
class Candidates:
    """All candidates with their columns, those of one number of parameters together."""

    all: tuple[Candidate, ...]
    columns: FloatArray  # (K, m)
    starts: tuple[int, ...]  # first column of each candidate
    square: FloatArray  # (K,) of each column

    def rows(self, index: int) -> FloatArray:
        """Return the columns of one candidate, shape (k, m)."""
        first = self.starts[index]
        return self.columns[first : first + len(self.all[index].specs)]


def gathered(candidates: Sequence[Candidate], columns: FloatArray) -> Candidates:
    """Return candidates with their columns in order."""
    sizes = [len(candidate.specs) for candidate in candidates]
    starts = tuple(int(start) for start in np.cumsum([0, *sizes])[:-1])
    return Candidates(tuple(candidates), columns, starts, np.einsum("km,km->k", columns, columns))


@dataclass(frozen=True, slots=True)
class Screened:
    """What each candidate would do; C candidates."""

    explained: FloatArray  # (C,) sum of squares T
    size: FloatArray  # (C,) effective number of parameters, 0 where nothing can be seen
    p_value: FloatArray  # (C,) corrected for everything tried
    score: FloatArray  # (C,) gain in BIC, search included; larger is better


def screen(candidates: Candidates, footing: Footing) -> Screened:
    """Screen all candidates on a footing."""
    explained, size = _explained(candidates, footing)
    left = np.maximum(footing.residual_square - explained, 1e-9 * footing.residual_square + 1e-300)
    degrees = np.maximum(footing.degrees - size, 1.0)
    seen = size > 0
    ratio = np.where(seen, explained / np.maximum(size, 1), 0.0) / (left / degrees)
    alone = np.where(seen, f_distribution.sf(ratio, np.maximum(size, 1), degrees), 1.0)
    tried = _tried(candidates.all)
    of_effect = Counter(candidate.effect for candidate in candidates.all)
    shares = np.array([len(of_effect) * of_effect[candidate.effect] for candidate in candidates.all])
    likelihood = footing.degrees * np.log(footing.residual_square / left)
    score = likelihood - size * np.log(max(footing.observations, 2.0)) - 2.0 * np.log(tried)
    return Screened(
        explained=explained,
        size=size,
        p_value=np.minimum(alone * shares, 1.0),
        score=np.where(seen, score, -np.inf),
    )


def _tried(candidates: tuple[Candidate, ...]) -> FloatArray:
    """How many variants of its cause and subject each candidate was chosen from."""
    variants = Counter((candidate.effect, candidate.subject) for candidate in candidates)
    return np.array([variants[candidate.effect, candidate.subject] for candidate in candidates], dtype=float)


def _explained(candidates: Candidates, footing: Footing) -> tuple[FloatArray, FloatArray]:
    columns = candidates.columns
    towards = columns @ footing.residual[: footing.size]
    absorbed = footing.absorbed(columns)
    explained, size = np.zeros(len(candidates.all)), np.zeros(len(candidates.all))
    counts = np.array([len(candidate.specs) for candidate in candidates.all], dtype=int)
    for count in np.unique(counts).tolist():
        here = np.flatnonzero(counts == count)
        rows = np.array(candidates.starts)[here][:, None] + np.arange(count)
        scale = np.sqrt(np.maximum(candidates.square[rows], 1e-300))
        unit = columns[rows] / scale[:, :, None] if count > 1 else None
        own = np.ones((len(here), 1, 1)) if unit is None else unit @ np.swapaxes(unit, 1, 2)
        taken = absorbed[rows] / scale[:, :, None]
        gram = own - taken @ np.swapaxes(taken, 1, 2)
        explained[here], size[here] = _quadratic(gram, towards[rows] / scale)
    return explained, size


def _quadratic(gram: FloatArray, towards: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Sum of squares explained, and the number of directions that can be seen, of C candidates."""
    sizes, axes = np.linalg.eigh(gram)
    along = np.einsum("cij,ci->cj", axes, towards)
    seen = sizes > _VISIBLE
    explained = np.where(seen, along**2 / np.where(seen, sizes, 1.0), 0.0).sum(axis=1)
    return explained, seen.sum(axis=1).astype(float)
