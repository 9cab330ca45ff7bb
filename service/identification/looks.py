"""Looks at fixed nests, one after the other: what they say of themselves, whatever the model says of them.

Nests that stand still are the witnesses of the instrument: a model that they contradict must not judge them.
So the scatter of their readings is told by how far each lies from the middle of those of the same nest before
and after it (Gasser, Sroka and Jennen-Steinmetz 1986); of these distances neither a drift nor a kick of the
instrument makes more than a few large. And where most readings of one look are off, it is not a nest that
moved: none of them is gross, unless it is far from those before and after it as well.

References
----------
T. Gasser, L. Sroka, C. Jennen-Steinmetz, Biometrika 73(3), 1986, 625-633.
"""

import numpy as np

from service.domain.arrays import BoolArray, IntArray
from service.identification.distributions import chi2_exceeded, chi2_limit, chi2_median
from service.identification.observations import BlockResult
from service.identification.reference import ReferenceBlock

_MIDDLE = 1.5  # variance of a reading less the middle of its two neighbours, over that of a reading
_FEWEST = 6  # readings between others: of fewer, a kick may be half of what is seen
# Three times the scatter of a median of chi-square variates, 1 / sqrt(n) of it, and a half more because those
# that are next to each other share readings.
_BEYOND = 4.5
_FALSE_ALARM = 0.01  # chance that noise alone sets any reading apart


def own_discrepancy_mm(block: ReferenceBlock) -> float:
    """Return by how much readings scatter beyond what is stated, per axis [mm]; 0 where few tell."""
    apart = [block.measured_mm[now] - block.measured_mm[both].mean(axis=0) for now, both in _between(block)]
    stated = block.stated_sigma() ** 2
    if len(apart) < _FEWEST:
        return 0.0
    squared = (np.array(apart) ** 2).sum(axis=1) / _MIDDLE
    variance = float(np.median(squared) / chi2_median(3))
    clearly = stated * (1.0 + _BEYOND / np.sqrt(len(apart)))
    return float(np.sqrt(variance - stated)) if variance > clearly else 0.0


def gross_looks(block: ReferenceBlock, off: BoolArray) -> BoolArray:
    """Return which readings that are off the model are bad ones, shape (n,); the others speak against it."""
    look = _looks(block)
    shared = np.bincount(look, off)[look] > 0.5 * np.bincount(look)[look]
    return np.asarray(off & (~shared | _alone(block)))


def contradiction(block: ReferenceBlock, result: BlockResult) -> float:
    """Return the chance that readings without a gross one lie so far off the model by noise alone."""
    squared = block.weights * block.squared(result)
    return float(chi2_exceeded(squared.sum(), 3.0 * max(float(block.weights.sum()), 1.0)))


def _between(block: ReferenceBlock) -> list[tuple[int, IntArray]]:
    """Return every reading that has one of its nest before and one after it, with these two."""
    return [
        (int(rows[k]), rows[[k - 1, k + 1]]) for rows in _of_nests(block) for k in range(1, len(rows) - 1)
    ]


def _of_nests(block: ReferenceBlock) -> list[IntArray]:
    """Return the readings of each nest in the order of time."""
    order = _in_time(block)
    return [order[block.fixed_nest[order] == nest] for nest in np.unique(block.fixed_nest)]


def _in_time(block: ReferenceBlock) -> IntArray:
    time_s = block.targets.stops.time_s
    count = len(block.fixed_nest)
    return np.arange(count) if time_s is None else np.argsort(time_s, kind="stable")


def _alone(block: ReferenceBlock) -> BoolArray:
    """Return which readings are far from both of their nest that are next in time, shape (n,)."""
    alone = np.zeros(len(block.fixed_nest), dtype=bool)
    limit = float(chi2_limit(_FALSE_ALARM / len(alone), 3))
    variance = block.component_variance()
    for now, both in _between(block):
        apart = ((block.measured_mm[now] - block.measured_mm[both]) ** 2).sum(axis=1)
        alone[now] = bool(np.all(apart > limit * (variance[now] + variance[both])))
    return alone


def _looks(block: ReferenceBlock) -> IntArray:
    """Return the number of each reading's look, shape (n,): one ends where the nests begin anew.

    Of a single nest, each reading is a look.
    """
    looks = np.zeros(len(block.fixed_nest), dtype=np.int64)
    seen: list[int] = []
    number, alone = 0, len(np.unique(block.fixed_nest)) == 1
    for row in _in_time(block).tolist():
        nest = int(block.fixed_nest[row])
        if seen and (alone or (nest in seen[:-1] and nest != seen[-1])):
            number, seen = number + 1, []
        seen.append(nest)
        looks[row] = number
    return looks
