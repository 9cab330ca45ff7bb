"""When a fault strikes: for a while of cell time, at a measurement, or at a move."""

import math
from dataclasses import dataclass

from truepose_simulators.errors import ScenarioError


@dataclass(frozen=True, slots=True)
class Lasting:
    """Holds for a while."""

    from_s: float = 0.0
    until_s: float = math.inf

    def holds(self, time_s: float) -> bool:
        """Whether it holds at a cell time."""
        return self.from_s <= time_s < self.until_s


@dataclass(frozen=True, slots=True)
class AtReading:
    """Befalls stationary measurement number `reading`, counted from the moment it is given."""

    reading: int

    def __post_init__(self) -> None:
        from_one(self, "reading")


@dataclass(frozen=True, slots=True)
class AtMove:
    """Befalls move number `move`, counted from the moment it is given."""

    move: int

    def __post_init__(self) -> None:
        from_one(self, "move")


def from_one(fault: object, *names: str) -> None:
    """Raise ScenarioError where a count of a fault is below 1."""
    for name in names:
        if getattr(fault, name) < 1:
            raise ScenarioError(f'key "{name}" must be 1 or more, not {getattr(fault, name)}')
