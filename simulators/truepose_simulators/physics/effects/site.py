"""What is known about the cell in which an effect is planted, and how an effect reads its details."""

from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Arm, CarriedMass
from truepose_simulators.physics.effects.effect import PlantedChange
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.table import read_table

T = TypeVar("T")


@dataclass(frozen=True)
class Site:
    """One cell, as far as effects care."""

    arm: Arm
    compliance_rad_per_n_mm: FloatArray  # (J,) of the true gearboxes
    tool_mass: CarriedMass | None  # as stated
    n_nests: int  # on the tool
    reference_c: float  # temperature at which lengths are what the plant says
    entropy: tuple[int, ...]  # decides what the change leaves to chance

    def rng(self, *stream: int) -> np.random.Generator:
        """Source of what is left to chance; the same stream always gives the same numbers."""
        return np.random.default_rng([*self.entropy, *stream])


@dataclass(frozen=True, slots=True)
class NoDetails:
    """Of an effect that subject and amplitude describe in full."""


def read_details(cls: type[T], change: PlantedChange) -> T:
    """Read the details of a change into the dataclass `cls`; raises ScenarioError."""
    where = f"effect {change.name}"
    try:
        return read_table(cls, change.details, where)
    except ScenarioError as error:  # a value that the class itself refuses does not know whose it is
        text = str(error)
        raise ScenarioError(text if text.startswith(where) else f"{where}: {text}") from error
