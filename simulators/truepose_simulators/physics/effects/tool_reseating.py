"""A tool that sits a little differently after each mounting: chips under the flange, a worn pin."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.effects import effect
from truepose_simulators.physics.effects.rigid_change import motion_in_world
from truepose_simulators.physics.rigid import FloatArray

_TOOL = -1


@dataclass(frozen=True, slots=True)
class ReseatingDetails:
    """How much the tool turns."""

    rotation_rad: float = 0.0  # standard deviation about each axis

    def __post_init__(self) -> None:
        if not 0.0 <= self.rotation_rad <= 0.1:
            raise ScenarioError(f'key "rotation_rad" must be 0 to 0.1, not {self.rotation_rad:g}')


@dataclass(frozen=True, slots=True)
class ReseatedTool:
    """Every mounting has its own small motion of the tool; none of them, the first included, is right."""

    scale: FloatArray  # (6,) standard deviations [mm, rad]
    site: effect.Site
    from_s: float

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return where the tool of each mounting sits, in the flange frame."""
        del loads
        mountings, which = np.unique(conditions.attachment, return_inverse=True)
        drawn = np.array([self.seat(int(mounting)) for mounting in mountings]).reshape(-1, 6)
        return effect.Deflection.of_body(
            conditions, _TOOL, drawn[which] * conditions.since(self.from_s)[:, np.newaxis]
        )

    def seat(self, mounting: int) -> FloatArray:
        """Motion of the tool in one mounting, shape (6,) [mm, rad]."""
        seat: FloatArray = self.scale * self.site.rng(mounting).standard_normal(6)
        return seat


def plant(change: effect.PlantedChange, site: effect.Site) -> ReseatedTool:
    """Build the effect; the amplitude is the standard deviation along each axis [mm]."""
    effect.check_only(change, "tool")
    details = effect.read_details(ReseatingDetails, change)
    scale = np.repeat([change.amplitude, details.rotation_rad], 3)
    return ReseatedTool(scale, site, change.from_s)


@dataclass(frozen=True, slots=True)
class SeatedTool:
    """Mountings whose seat was identified; in any other the tool sits as it should."""

    seats: Mapping[int, FloatArray]  # (6,) [mm, rad] by mounting

    def deflect(self, conditions: effect.Conditions, loads: effect.Loads) -> effect.Deflection:
        """Return where the tool of each mounting sits, in the flange frame."""
        del loads
        motions = np.zeros((len(conditions), 6))
        for mounting, seat in self.seats.items():
            motions[conditions.attachment == mounting] = seat
        return effect.Deflection.of_body(conditions, _TOOL, motions)


def realise(stated: effect.IdentifiedEffect, site: effect.ModelArm) -> tuple[SeatedTool, ...]:
    """Build the identified seats, `seat_<mounting>_x`..`_rz` [mm, rad, flange frame]."""
    del site
    seats = stated.motions("seat_([0-9]+)", "seat_<mounting>")
    return (SeatedTool({int(number): motion_in_world(np.eye(4), seat) for number, seat in seats.items()}),)
