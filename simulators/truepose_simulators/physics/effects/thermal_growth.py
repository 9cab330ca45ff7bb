"""Links that grow with the temperature of an air that warms up.

From `from_s` the air nears `warm_up_k` above its usual temperature, and every link is longer in proportion
to how much warmer than the usual temperature the air truly is, its slow wave included. The artefact on the
flange is of invar and keeps its size.
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.arm import Arm
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.rigid import FloatArray, apply

# Temperature at which lengths in drawings are meant (ISO 1), and those of an identified model.
LENGTHS_HOLD_C = 20.0


@dataclass(frozen=True, slots=True)
class WarmUpDetails:
    """How the air warms up."""

    warm_up_k: float = 6.0
    time_constant_s: float = 2400.0

    def __post_init__(self) -> None:
        if not abs(self.warm_up_k) <= 60.0:
            raise ScenarioError(f'key "warm_up_k" must be -60 to 60, not {self.warm_up_k:g}')
        if not 1.0 <= self.time_constant_s <= 1e6:
            raise ScenarioError(f'key "time_constant_s" must be 1 to 1e6, not {self.time_constant_s:g}')


@dataclass(frozen=True, slots=True)
class ThermalGrowth:
    """Growing links, and the air that makes them grow."""

    links_mm: FloatArray  # (J+2, 3) how far each body leads from the one before, in its own seat
    per_k: float
    warm_up: WarmUpDetails
    reference_c: float
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return by how much every link is longer."""
        del loads
        share = self.per_k * (conditions.temperature_c - self.reference_c) * conditions.since(self.from_s)
        motions = np.zeros((len(conditions), *self.links_mm.shape[:1], 6))
        motions[..., :3] = share[:, np.newaxis, np.newaxis] * self.links_mm
        return effect.Deflection(motions=motions)

    def warming_k(self, time_s: FloatArray) -> FloatArray:
        """Return the warm-up of the air, shape (n,)."""
        elapsed_s = np.maximum(time_s - self.from_s, 0.0)
        # dT (1 - exp(-t / tau)); expm1 keeps the digits that 1 - exp would lose at the beginning.
        warmer: FloatArray = -self.warm_up.warm_up_k * np.expm1(-elapsed_s / self.warm_up.time_constant_s)
        return warmer


def plant(change: effect.PlantedChange, site: effect.Site) -> ThermalGrowth:
    """Build the effect; the amplitude is the coefficient of expansion [1/K]."""
    effect.check_only(change, "links")
    details = effect.read_details(WarmUpDetails, change)
    return ThermalGrowth(_links_mm(site.arm), change.amplitude, details, site.reference_c, change.from_s)


def _links_mm(arm: Arm) -> FloatArray:
    """Way from each joint's seat to the next and on to the flange; the base itself does not grow."""
    frames = np.concatenate([arm.seats, arm.flange[np.newaxis]])
    ways = np.diff(frames[:, :3, 3], axis=0, prepend=np.zeros((1, 3)))
    links: FloatArray = np.zeros((arm.n_joints + 2, 3))
    links[1:] = apply(np.swapaxes(frames[:, :3, :3], 1, 2), ways)
    return links


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[ThermalGrowth, ...]:
    """Build the identified expansion, `growth` [1/K] of all lengths from 20 degC on, in the cell's air."""
    links_mm, still = _links_mm(site.arm), WarmUpDetails(warm_up_k=0.0)
    return tuple(
        ThermalGrowth(links_mm, per_k, still, LENGTHS_HOLD_C, effect.ALWAYS_S)
        for _, per_k in stated.matching("growth", "growth")
    )
