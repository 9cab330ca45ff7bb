"""When a fault strikes, and for how long: the keys that every kind has.

A trigger is a moment of cell time (`from_s`) or an event: the nth `reading`, the nth `move`, or the
motion to the nth `configuration`. Events count from the moment the fault is given, so 1 is the next one. A
cell knows no session: a configuration is a stop at which something on the tool was read.
"""

import math
from dataclasses import dataclass
from typing import Final

from truepose_simulators.errors import ScenarioError
from truepose_simulators.scenarios.table import require_at_least_0

EVENTS: Final = ("configuration", "move", "reading")


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """What goes wrong, once its trigger has come."""

    from_s: float = 0.0  # cell time; 0: as soon as it is given
    configuration: int | None = None
    move: int | None = None
    reading: int | None = None

    def __post_init__(self) -> None:
        stated = [name for name in EVENTS if getattr(self, name) is not None]
        from_one(self, *stated)
        if self.from_s > 0.0:
            stated.insert(0, "from_s")
        if len(stated) > 1:
            raise ScenarioError(f"keys {' and '.join(map(repr, stated))}: a fault takes only one trigger")


@dataclass(frozen=True, slots=True, kw_only=True)
class Lasting(Fault):
    """Holds for a while."""

    after_s: float = 0.0  # from the trigger to the beginning
    for_s: float = math.inf
    until_s: float = math.inf  # cell time

    def __post_init__(self) -> None:
        Fault.__post_init__(self)
        require_at_least_0(self, "after_s", "for_s")

    def end_s(self, begun_s: float) -> float:
        """Return when it ends that began at a cell time."""
        return min(self.until_s, begun_s + self.for_s)


@dataclass(frozen=True, slots=True, kw_only=True)
class ScheduledFault(Fault):
    """Befalls `count` readings, motions or connections, the next ones when its trigger has come."""

    count: int = 1

    def __post_init__(self) -> None:
        Fault.__post_init__(self)
        from_one(self, "count")


class AtReading(ScheduledFault):
    """Befalls stationary measurements."""


class AtMove(ScheduledFault):
    """Befalls motions."""


class AtConnection(ScheduledFault):
    """Befalls what the hands put between two balls."""


def from_one(fault: object, *names: str) -> None:
    """Raise ScenarioError where a count of a fault is below 1."""
    for name in names:
        if getattr(fault, name) < 1:
            raise ScenarioError(f'key "{name}" must be 1 or more, not {getattr(fault, name)}')
