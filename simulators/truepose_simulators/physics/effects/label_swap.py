"""Two nests confused: what is written down as the one was read at the other."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class SwappedLabels:
    """A share of the readings of two nests is swapped."""

    pair: tuple[int, int]  # 1-based
    share: float
    from_s: float

    def nests_read(self, nest: NestNumbers, time_s: FloatArray, rng: np.random.Generator) -> NestNumbers:
        """Return which nests were truly read, shape (n,)."""
        swapped = rng.random(len(nest)) < self.share * effect.since(time_s, self.from_s)
        first, second = self.pair
        read = np.where(swapped & (nest == first), second, nest)
        return np.where(swapped & (nest == second), first, read)


def plant(change: effect.PlantedChange, site: effect.Site) -> SwappedLabels:
    """Build the effect; the amplitude is the share of the readings, 1 for all of them."""
    effect.read_details(effect.NoDetails, change)
    return SwappedLabels(effect.nest_pair(change, site.n_nests), change.amplitude, change.from_s)
