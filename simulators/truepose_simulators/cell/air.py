"""The air in the cell: a slow wave of temperature, and what a sensor says of it."""

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.rigid import FloatArray

PRESSURE_HPA = 1013.25
HUMIDITY_PERCENT = 45.0


@dataclass(frozen=True, slots=True)
class AirSetup:
    """How the temperature of the cell behaves."""

    temperature_c: float = 23.0
    wave_k: float = 0.3  # amplitude
    wave_period_s: float = 7200.0
    sensor_noise_k: float = 0.05

    def __post_init__(self) -> None:
        if self.wave_period_s <= 0.0:
            raise ScenarioError(f'key "wave_period_s" must be above 0, not {self.wave_period_s}')
        if self.sensor_noise_k < 0.0:
            raise ScenarioError(f'key "sensor_noise_k" must be 0 or more, not {self.sensor_noise_k}')


@dataclass(frozen=True, slots=True)
class Air:
    """Temperature as a function of cell time."""

    setup: AirSetup
    phase_rad: float
    warming_k: Callable[[FloatArray], FloatArray]  # what comes on top, at times of shape (n,)

    def temperature_c(self, time_s: FloatArray) -> FloatArray:
        """Return the true temperature [C], shape (n,)."""
        angle = 2.0 * math.pi * time_s / self.setup.wave_period_s + self.phase_rad
        wave: FloatArray = self.setup.temperature_c + self.setup.wave_k * np.sin(angle)
        return wave + self.warming_k(time_s)

    def sensed_c(self, time_s: float, rng: np.random.Generator | None) -> float:
        """Return what a sensor reads [C]; without generator it has no noise."""
        noise = 0.0 if rng is None else self.setup.sensor_noise_k * float(rng.standard_normal())
        return float(self.temperature_c(np.array([time_s]))[0]) + noise
