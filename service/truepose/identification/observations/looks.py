"""Looks at fixed nests, one after the other: what they say of themselves, whatever the model says of them.

Nests that stand still are the witnesses of the instrument: a model that they contradict must not judge them.
So the scatter of their readings is told by the differences between successive ones of the same nest (von
Neumann et al. 1941), of which a kick of the instrument makes one large and a drift none; the median passes it
over. And where most readings of one look are off, it is not a nest that moved: none of them is gross, unless
it is far from those before and after it as well.

References
----------
J. von Neumann, R. H. Kent, H. R. Bellinson, B. I. Hart, Annals of Mathematical Statistics 12(2), 1941,
153-162.
"""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray, distinct_values
from truepose.identification.distributions import chi2_exceeded, chi2_limit, chi2_median, f_exceeded
from truepose.identification.observations.blocks import FALSE_ALARM

_FEWEST = 4  # differences of each nest: of fewer, a kick is too large a part of what is seen
# Three times the scatter of a median of chi-square variates, 1 / sqrt(n) of it, and a third more because
# successive differences share readings.
_BEYOND = 4.0
_WORTH = 0.7  # degrees of freedom of a difference of three components: for the median, and what they share


class _Scatter(NamedTuple):
    """What successive looks show: variance per axis, from so many differences."""

    variance_mm2: float
    differences: int


@dataclass(frozen=True, slots=True)
class Looks:
    """Readings of fixed nests."""

    time_s: FloatArray | None  # (n,)
    fixed_nest: IntArray  # (n,)
    measured_mm: FloatArray  # (n, 3)
    variance_mm2: FloatArray  # (n,) per axis

    def discrepancy_mm(self, stated_mm2: float) -> float:
        """Return by how much readings scatter beyond a variance per axis [mm]; 0 where few tell."""
        scatter = self._scatter()
        if scatter is None:
            return 0.0
        clearly = stated_mm2 * (1.0 + _BEYOND / np.sqrt(scatter.differences))
        return float(np.sqrt(scatter.variance_mm2 - stated_mm2)) if scatter.variance_mm2 > clearly else 0.0

    def bad_among(self, off: BoolArray) -> BoolArray:
        """Return which readings off the model are bad ones, shape (n,); the others speak against it."""
        look = self._numbers()
        shared = np.bincount(look, off)[look] > 0.5 * np.bincount(look)[look]
        return np.asarray(off & (~shared | self._alone()))

    def chance_of(self, squared: float, degrees: float) -> float:
        """Return the chance that residuals have this sum of normalised squares by their scatter alone.

        The scatter is the stated one, or what looks show of it where that is more, known as a median
        knows it.
        """
        scatter = self._scatter()
        if scatter is None or degrees == 0.0:
            return chi2_exceeded(squared, max(degrees, 1.0))
        more = max(scatter.variance_mm2 / float(np.mean(self.variance_mm2)), 1.0)
        return f_exceeded(squared / more / degrees, degrees, _WORTH * scatter.differences)

    def _scatter(self) -> _Scatter | None:
        nests = self._of_nests()
        apart = np.concatenate([np.diff(self.measured_mm[rows], axis=0) for rows in nests])
        if len(apart) < _FEWEST * len(nests):
            return None
        squared = (apart**2).sum(axis=1) / 2.0
        return _Scatter(float(np.median(squared) / chi2_median(3)), len(apart))

    def _between(self) -> list[tuple[int, IntArray]]:
        """Return every reading that has one of its nest before and one after it, with these two."""
        return [
            (int(rows[k]), rows[[k - 1, k + 1]]) for rows in self._of_nests() for k in range(1, len(rows) - 1)
        ]

    def _of_nests(self) -> list[IntArray]:
        """Return the readings of each nest in the order of time."""
        order = self._in_time()
        return [order[self.fixed_nest[order] == nest] for nest in distinct_values(self.fixed_nest)]

    def _in_time(self) -> IntArray:
        count = len(self.fixed_nest)
        return np.arange(count) if self.time_s is None else np.argsort(self.time_s, kind="stable")

    def _alone(self) -> BoolArray:
        """Return which readings are far from both of their nest that are next in time, shape (n,)."""
        alone = np.zeros(len(self.fixed_nest), dtype=bool)
        limit = chi2_limit(FALSE_ALARM / len(alone), 3)
        for now, both in self._between():
            apart = ((self.measured_mm[now] - self.measured_mm[both]) ** 2).sum(axis=1)
            expected = self.variance_mm2[now] + self.variance_mm2[both]
            alone[now] = bool(np.all(apart > limit * expected))
        return alone

    def _numbers(self) -> IntArray:
        """Return the number of each reading's look, shape (n,): one ends where the nests begin anew.

        Of a single nest, each reading is a look.
        """
        looks = np.zeros(len(self.fixed_nest), dtype=np.int64)
        seen: list[int] = []
        number, alone = 0, len(distinct_values(self.fixed_nest)) == 1
        for row in self._in_time().tolist():
            nest = int(self.fixed_nest[row])
            if seen and (alone or (nest in seen[:-1] and nest != seen[-1])):
                number, seen = number + 1, []
            seen.append(nest)
            looks[row] = number
        return looks
