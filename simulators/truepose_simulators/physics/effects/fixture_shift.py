"""A base fixture that moves while it is measured from: somebody leant on it, a clamp crept."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.effects.rigid_change import jump
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class ShiftedFixture:
    """The cups of one placement stand elsewhere from `from_s` on, turned about the origin of the world."""

    placement: int
    motion: FloatArray  # (6,) [mm, rad]
    from_s: float

    def fixture_motion(self, placement: NestNumbers, time_s: FloatArray) -> FloatArray:
        """Return `[tx ty tz rx ry rz]` [mm, rad] of fixtures at times, shape (n, 6)."""
        there = (placement == self.placement) * effect.since(time_s, self.from_s)
        moved: FloatArray = there[:, np.newaxis] * self.motion
        return moved


def plant(change: effect.PlantedChange, site: effect.Site) -> ShiftedFixture:
    """Build the effect; the amplitude is the norm of the translation [mm]."""
    placement, motion = effect.placement_number(change), jump(change, site)
    if change.from_s <= 0.0:
        raise ScenarioError(
            f"effect {change.name}: from_s, when the fixture moves, must be after its cups are clamped and"
            f" before its last leg, not {change.from_s:g}"
        )
    return ShiftedFixture(placement, motion, change.from_s)
