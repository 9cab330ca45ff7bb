"""What the person at the cell has in hand: the ballbar, its base fixture, and how they act in this cell."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from truepose_simulators.cell.air import Air
from truepose_simulators.cell.planted import PlantedEffects
from truepose_simulators.instruments.ballbars.device import Around, Ballbar, Span
from truepose_simulators.person.fixture import ClampedCup, Fixture
from truepose_simulators.person.hands import Hands, Workplace
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.scenario import Scenario


@dataclass(frozen=True, slots=True)
class Equipment:
    """Ballbar and fixture, and the hands that hold them."""

    ballbar: Ballbar
    fixture: Fixture
    hands: Hands


def equip(
    scenario: Scenario,
    planted: Callable[[], PlantedEffects],
    air: Air,
    workplace: Workplace,
    seed: np.random.SeedSequence,
) -> Equipment:
    """Give the person of a cell their equipment; `planted` returns the effects as they are now."""
    handling, readings = (np.random.default_rng(part) for part in seed.spawn(2))
    noise = readings if scenario.noise else None

    def shifted_mm(cup: ClampedCup, time_s: float) -> FloatArray:
        when = np.array([cup.clamped_s]), np.array([time_s])
        shifted: FloatArray = planted().shifted_mm(cup.place_mm[np.newaxis], np.array([cup.placement]), *when)
        place: FloatArray = shifted[0]
        return place

    def distance_mm(span: Span, time_s: float) -> float:
        return hands.distance_mm(span, time_s)

    def error_mm(true_mm: float, initialisation: int, age_s: float, time_s: float) -> float:
        true, age, when = (np.array([value]) for value in (true_mm, age_s, time_s))
        return float(planted().length_errors_mm(true, np.array([initialisation]), age, when)[0])

    around = Around(distance_mm, error_mm, lambda time_s: air.sensed_c(time_s, noise))
    ballbar = Ballbar(scenario.ballbar, around, noise, handling if scenario.noise else None)
    fixture = Fixture(scenario.hands, shifted_mm, handling)
    hands = Hands(ballbar, fixture, workplace, scenario.ballbar.clamp_mm if scenario.noise else 0.0)
    return Equipment(ballbar, fixture, hands)
