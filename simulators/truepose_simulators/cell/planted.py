"""Everything that is planted in one cell, asked by where it acts."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from truepose_simulators.physics.effects import Conditions, Effect, PlantedChange, Site, plant_effect
from truepose_simulators.physics.effects.ports import (
    AirEffect,
    ArmEffect,
    FixtureEffect,
    FrameEffect,
    LabelEffect,
    LengthEffect,
    MassEffect,
    NestEffect,
    NestNumbers,
    ReadingEffect,
    ScaleEffect,
    ZeroEffect,
)
from truepose_simulators.physics.loads import MassChange
from truepose_simulators.physics.rigid import FloatArray, inverse, move, small_motion


class PlantedEffects:
    """The effects of one cell; what a change leaves to chance depends on the seed and its number alone."""

    def __init__(
        self, site: Site, changes: Sequence[PlantedChange] = (), identified: Sequence[Effect] = ()
    ) -> None:
        """Build the effects of all changes, `site.entropy` being the cell's; raises ScenarioError.

        `identified` act besides, as a model states them.
        """
        self._site = site
        self._identified = tuple(identified)
        self.changes = tuple(changes)
        effects = [
            *identified,
            *(_planted(change, number, site) for number, change in enumerate(changes)),
        ]
        self.arm = [effect for effect in effects if isinstance(effect, ArmEffect)]
        self._masses = [effect for effect in effects if isinstance(effect, MassEffect)]
        self._nests = [effect for effect in effects if isinstance(effect, NestEffect)]
        self._frame = [effect for effect in effects if isinstance(effect, FrameEffect)]
        self._scale = [effect for effect in effects if isinstance(effect, ScaleEffect)]
        self._lengths = [effect for effect in effects if isinstance(effect, LengthEffect)]
        self._zeros = [effect for effect in effects if isinstance(effect, ZeroEffect)]
        self._fixtures = [effect for effect in effects if isinstance(effect, FixtureEffect)]
        self._air = [effect for effect in effects if isinstance(effect, AirEffect)]
        self._labels = [effect for effect in effects if isinstance(effect, LabelEffect)]
        self._readings = [effect for effect in effects if isinstance(effect, ReadingEffect)]

    def __bool__(self) -> bool:
        return bool(self.changes or self._identified)

    def with_change(self, change: PlantedChange) -> "PlantedEffects":
        """Return these effects and one more; raises ScenarioError."""
        return PlantedEffects(self._site, (*self.changes, change), self._identified)

    def mass_changes(self, conditions: Conditions) -> list[MassChange]:
        """Masses that are there besides the stated ones."""
        return [change for effect in self._masses for change in effect.mass_changes(conditions)]

    def nest_offsets_mm(self, conditions: Conditions) -> FloatArray:
        """Where tool nests are besides their certificate, flange frame, (n, nests, 3) or broadcasting."""
        return sum((effect.nest_offsets_mm(conditions) for effect in self._nests), start=np.zeros((1, 1, 3)))

    def frame_motion(self, time_s: FloatArray) -> FloatArray:
        """Motion of the instrument's frame about the world's origin [mm, rad], shape (n, 6)."""
        still = np.zeros((len(time_s), 6))
        return sum((effect.frame_motion(time_s) for effect in self._frame), start=still)

    def relative_scale(self, time_s: FloatArray) -> FloatArray:
        """Share by which the instrument reads lengths too long, shape (n,)."""
        return sum((effect.relative_scale(time_s) for effect in self._scale), start=np.zeros(len(time_s)))

    def relative_length(self, time_s: FloatArray) -> FloatArray:
        """Share by which the ballbar reads lengths too long, shape (n,)."""
        return sum((effect.relative_length(time_s) for effect in self._lengths), start=np.zeros(len(time_s)))

    def zero_mm(self, initialisation: NestNumbers, since_s: FloatArray, time_s: FloatArray) -> FloatArray:
        """By how much the ballbar reads lengths too long since its initialisations, shape (n,)."""
        good = np.zeros(len(time_s))
        return sum((effect.zero_mm(initialisation, since_s, time_s) for effect in self._zeros), start=good)

    def fixture_motion(self, placement: NestNumbers, time_s: FloatArray) -> FloatArray:
        """Motion of base fixtures about the world's origin [mm, rad], shape (n, 6)."""
        still = np.zeros((len(time_s), 6))
        return sum((effect.fixture_motion(placement, time_s) for effect in self._fixtures), start=still)

    def shifted_mm(
        self, place_mm: FloatArray, placement: NestNumbers, then_s: FloatArray, time_s: FloatArray
    ) -> FloatArray:
        """Return where cups are at times that were at `place_mm` (n, 3) [world] `then_s`, shape (n, 3)."""
        # Only what the fixture has moved since: a cup that was clamped meanwhile stands where it was clamped.
        before, now = (small_motion(self.fixture_motion(placement, when)) for when in (then_s, time_s))
        return move(now @ inverse(before), place_mm)

    def length_errors_mm(
        self, true_mm: FloatArray, initialisation: NestNumbers, since_s: FloatArray, time_s: FloatArray
    ) -> FloatArray:
        """Return by how much the ballbar reads lengths too long since its initialisations, shape (n,)."""
        scaled: FloatArray = true_mm * self.relative_length(time_s)
        return scaled + self.zero_mm(initialisation, since_s, time_s)

    def wild_mm(self, time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """By how much lengths are off where readings are spoiled, either way, shape (n,)."""
        displaced = self.displacement_mm(time_s, rng)
        # A length has no direction: its error is as large as that of a point, and as often either way.
        error: FloatArray = np.copysign(np.linalg.norm(displaced, axis=1), displaced[:, 0])
        return error

    def warming_k(self, time_s: FloatArray) -> FloatArray:
        """By how much the air is warmer [K], shape (n,)."""
        return sum((effect.warming_k(time_s) for effect in self._air), start=np.zeros(len(time_s)))

    def nests_read(self, nest: NestNumbers, time_s: FloatArray, rng: np.random.Generator) -> NestNumbers:
        """Which nests (1-based) are truly read under their labels, shape (n,)."""
        for effect in self._labels:
            nest = effect.nests_read(nest, time_s, rng)
        return nest

    def displacement_mm(self, time_s: FloatArray, rng: np.random.Generator) -> FloatArray:
        """By how much readings are off, any frame, shape (n, 3)."""
        good = np.zeros((len(time_s), 3))
        return sum((effect.displacement_mm(time_s, rng) for effect in self._readings), start=good)


def _planted(change: PlantedChange, number: int, site: Site) -> Effect:
    return plant_effect(change, replace(site, entropy=(*site.entropy, number)))
