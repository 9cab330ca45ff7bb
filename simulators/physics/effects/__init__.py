"""One file per physical effect; `plant_effect` finds it by the name that scenarios use."""

from simulators.physics.effects.effect import Conditions, Deflection, Loads, PlantedChange
from simulators.physics.effects.ports import Effect
from simulators.physics.effects.registry import EFFECTS, plant_effect, realise_effect
from simulators.physics.effects.site import Site
from simulators.physics.effects.stated import ModelArm, Stated

__all__ = [
    "EFFECTS",
    "Conditions",
    "Deflection",
    "Effect",
    "Loads",
    "ModelArm",
    "PlantedChange",
    "Site",
    "Stated",
    "plant_effect",
    "realise_effect",
]
