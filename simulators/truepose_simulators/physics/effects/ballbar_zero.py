"""A ballbar whose zero is wrong: dirt on the calibrator, or a magnet that creeps afterwards."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray

COURSES = ("constant", "growing")


@dataclass(frozen=True, slots=True)
class ZeroDetails:
    """How the error goes from one initialisation to the next."""

    course: str = "constant"
    grown_s: float = 60.0  # after which a growing error is what was drawn for it

    def __post_init__(self) -> None:
        if self.course not in COURSES:
            raise ScenarioError(f'key "course" must be {" or ".join(COURSES)}, not "{self.course}"')
        if not 1.0 <= self.grown_s <= 1e6:
            raise ScenarioError(f'key "grown_s" must be 1 to 1000000, not {self.grown_s:g}')


@dataclass(frozen=True, slots=True)
class WrongZero:
    """Every initialisation leaves an error of its own."""

    size_mm: float  # standard deviation over the initialisations
    details: ZeroDetails
    site: effect.Site
    from_s: float

    def zero_mm(self, initialisation: NestNumbers, since_s: FloatArray, time_s: FloatArray) -> FloatArray:
        """Return by how much lengths are read too long after initialisations, shape (n,)."""
        numbers, which = np.unique(initialisation, return_inverse=True)
        drawn = np.array([self.site.rng(int(number)).standard_normal() for number in numbers])
        grown = since_s / self.details.grown_s if self.details.course == "growing" else 1.0
        zeros: FloatArray = self.size_mm * drawn[which] * grown * effect.since(time_s, self.from_s)
        return zeros


def plant(change: effect.PlantedChange, site: effect.Site) -> WrongZero:
    """Build the effect; the amplitude is the root mean square over the initialisations [mm]."""
    effect.check_only(change, "ballbar")
    return WrongZero(change.amplitude, effect.read_details(ZeroDetails, change), site, change.from_s)
