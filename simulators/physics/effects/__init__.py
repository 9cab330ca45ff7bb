"""One file per physical effect; `plant_effect` finds it by the name that scenarios use."""

from collections.abc import Callable, Mapping
from types import MappingProxyType

from simulators.errors import ScenarioError
from simulators.physics.arm import Arm
from simulators.physics.effects import joint_gain
from simulators.physics.effects.effect import (
    Conditions,
    Deflection,
    Effect,
    Loads,
    PlantedChange,
)

__all__ = ["EFFECTS", "Conditions", "Deflection", "Effect", "Loads", "PlantedChange", "plant_effect"]

EFFECTS: Mapping[str, Callable[[PlantedChange, Arm], Effect]] = MappingProxyType({
    "joint_gain": joint_gain.plant
})


def plant_effect(change: PlantedChange, arm: Arm) -> Effect:
    """Build the effect of a planted change; raises ScenarioError with the known names."""
    builder = EFFECTS.get(change.name)
    if builder is None:
        raise ScenarioError(f'unknown effect "{change.name}"; known: {", ".join(sorted(EFFECTS))}')
    return builder(change, arm)
