"""One file per physical effect; `plant_effect` finds it by the name that scenarios use."""

from truepose_simulators.physics.effects.effect import Conditions, Deflection, Loads, PlantedChange
from truepose_simulators.physics.effects.ports import Effect
from truepose_simulators.physics.effects.registry import EFFECTS, plant_effect, realise_effect
from truepose_simulators.physics.effects.site import Site
from truepose_simulators.physics.effects.stated import ModelArm, Stated

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
