"""One file per physical effect; `plant_effect` finds it by the name that scenarios use."""

from truepose_simulators.physics.effects.effect import (
    Conditions,
    Deflection,
    IdentifiedEffect,
    Loads,
    ModelArm,
    PlantedChange,
    Site,
)
from truepose_simulators.physics.effects.ports import Effect
from truepose_simulators.physics.effects.registry import EFFECTS, plant_effect, realise_effect

__all__ = [
    "EFFECTS",
    "Conditions",
    "Deflection",
    "Effect",
    "IdentifiedEffect",
    "Loads",
    "ModelArm",
    "PlantedChange",
    "Site",
    "plant_effect",
    "realise_effect",
]
