"""Errors of the distances between all pairs of points: what no frame can hide."""

from collections.abc import Iterator

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.results import NominalAndIdentified, Statistics
from truepose.identification.verdict.judge import Judged

_PAIRS_AT_ONCE = 2_000_000


def distances(judged: Judged) -> NominalAndIdentified | None:
    """Return the statistics over all pairs of places; None of readings that are none, or of a single one."""
    block = judged.block
    places = block.place_mm
    if places is None or len(places) < 2:
        return None
    # A distance sees one component of the noise of each of its two ends.
    covariance = block.covariance() + block.scatter_mm**2 * np.eye(block.components)
    variance = float(np.trace(covariance, axis1=1, axis2=2).mean()) / block.components
    noise = float(np.sqrt(2.0 / np.pi) * np.sqrt(2.0 * variance))
    before, after = _Running(), _Running()
    for first, second in _pairs(len(places)):
        seen = _lengths(places, first, second)
        before.add(seen - _lengths(judged.nominal.state.position_mm, first, second))
        after.add(seen - _lengths(judged.position_mm, first, second))
    return NominalAndIdentified(before.statistics(noise), after.statistics(noise))


def _lengths(points: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
    return np.asarray(np.linalg.norm(points[first] - points[second], axis=1))


def _pairs(n: int) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield all pairs i < j in blocks that fit in memory."""
    rows = max(1, _PAIRS_AT_ONCE // n)
    for start in range(0, n, rows):
        here = np.arange(start, min(start + rows, n), dtype=np.int64)
        first, second = np.meshgrid(here, np.arange(n, dtype=np.int64), indexing="ij")
        chosen = first < second
        yield first[chosen], second[chosen]


class _Running:
    """Statistics of absolute errors over blocks of pairs."""

    def __init__(self) -> None:
        self._n, self._sum, self._squares, self._largest = 0, 0.0, 0.0, 0.0

    def add(self, errors: FloatArray) -> None:
        """Take another block."""
        if errors.size == 0:
            return
        self._n += errors.size
        self._sum += float(np.abs(errors).sum())
        self._squares += float(errors @ errors)
        self._largest = max(self._largest, float(np.abs(errors).max()))

    def statistics(self, noise_mm: float) -> Statistics:
        """Return the statistics of all blocks."""
        mean = self._sum / self._n
        variance = max(self._squares / self._n - mean**2, 0.0) * self._n / max(self._n - 1, 1)
        return Statistics(
            self._n,
            mean,
            float(np.sqrt(self._squares / self._n)),
            float(np.sqrt(variance)),
            self._largest,
            noise_mm,
        )
