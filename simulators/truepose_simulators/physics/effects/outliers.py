"""Single bad readings: a reflector not quite seated, somebody in the beam."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class OutlierDetails:
    """How bad."""

    size_mm: float = 0.3

    def __post_init__(self) -> None:
        if not 0.0 <= self.size_mm <= 1000.0:
            raise ScenarioError(f'key "size_mm" must be 0 to 1000, not {self.size_mm:g}')


@dataclass(frozen=True, slots=True)
class BadReadings:
    """A share of the readings is off by a fixed distance in any direction."""

    share: float
    size_mm: float
    from_s: float

    def displacement_mm(self, time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """Return by how much each reading is off, shape (n, 3)."""
        n = len(time_s)
        bad = rng.random(n) < self.share * effect.since(time_s, self.from_s)
        direction = rng.standard_normal((n, 3))
        direction /= np.linalg.norm(direction, axis=1, keepdims=True)
        displaced: FloatArray = self.size_mm * bad[:, np.newaxis] * direction
        return displaced


def plant(change: effect.PlantedChange, site: effect.Site) -> BadReadings:
    """Build the effect; the amplitude is the share of the readings."""
    del site
    effect.check_only(change, "readings")
    details = effect.read_details(OutlierDetails, change)
    return BadReadings(change.amplitude, details.size_mm, change.from_s)
