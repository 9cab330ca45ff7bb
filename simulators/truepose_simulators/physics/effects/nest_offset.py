"""A nest on the tool that is not where its certificate says."""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.arm import Vector
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.rigid_change import unit_or_drawn
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class OffsetDetails:
    """Which way, flange frame."""

    direction: Vector | None = None  # any length; absent: drawn


@dataclass(frozen=True, slots=True)
class OffsetNest:
    """One nest sits elsewhere from `from_s` on."""

    offsets_mm: FloatArray  # (nests, 3) flange frame
    from_s: float

    def nest_offsets_mm(self, conditions: effect.Conditions) -> FloatArray:
        """Return the offsets of all nests, shape (n, nests, 3)."""
        offsets: FloatArray = conditions.since(self.from_s)[:, np.newaxis, np.newaxis] * self.offsets_mm
        return offsets


def plant(change: effect.PlantedChange, site: effect.Site) -> OffsetNest:
    """Build the effect; the amplitude is the distance from the certified place [mm]."""
    details = effect.read_details(OffsetDetails, change)
    offsets = np.zeros((site.n_nests, 3))
    direction = unit_or_drawn(details.direction, site.rng())
    offsets[effect.nest_index(change, site.n_nests)] = change.amplitude * direction
    return OffsetNest(offsets, change.from_s)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[OffsetNest, ...]:
    """Build the identified offsets, `offset_<nest>_x`.. [mm, flange frame]."""
    return _realised("offset", stated, site)


def realise_certificate(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[OffsetNest, ...]:
    """Build the errors that a certificate allows, `certified_<nest>_x`.. [mm, flange frame]."""
    return _realised("certified", stated, site)


def _realised(prefix: str, stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[OffsetNest, ...]:
    offsets = np.zeros((site.n_nests, 3))
    for nest, offset_mm in stated.vectors(f"{prefix}_([0-9]+)", f"{prefix}_<nest>").items():
        offsets[stated.index(nest, site.n_nests, "nest")] = offset_mm
    return (OffsetNest(offsets, effect.ALWAYS_S),)
