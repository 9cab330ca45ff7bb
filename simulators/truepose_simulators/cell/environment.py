"""The cell's own clock, which everyone in it sees, and its air."""

import asyncio
import math
import time
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.scenarios.table import require_above_0, require_at_least_0

Pace = Literal[0, 1]


class CellClock:
    """Cell time [s] since the start, at pace 1 (real time) or 0 (waiting costs no wall time).

    At pace 0 time stands still until somebody waits, moves or measures; each of these moves it on.
    """

    def __init__(
        self,
        pace: Pace = 0,
        *,
        wall_s: Callable[[], float] = time.monotonic,
        wall_sleep: Callable[[float], Awaitable[None]] = asyncio.sleep,
    ) -> None:
        self._pace = pace
        self._wall_s = wall_s
        self._wall_sleep = wall_sleep
        self._start_s = wall_s()
        self._virtual_s = 0.0

    @property
    def waits(self) -> bool:
        """Whether sleeping takes wall time, so that others may act meanwhile."""
        return self._pace == 1

    @property
    def now_s(self) -> float:
        """Present cell time [s]."""
        return self._wall_s() - self._start_s if self.waits else self._virtual_s

    def go_at(self, pace: Pace) -> None:
        """From now on go at this pace, from the present time on."""
        now_s = self.now_s
        self._pace = pace
        self._start_s = self._wall_s() - now_s
        self._virtual_s = now_s

    async def sleep(self, duration_s: float) -> None:
        """Let `duration_s` (0 or more) of cell time go by."""
        if self.waits:
            await self._wall_sleep(duration_s)
        else:
            self._virtual_s += duration_s


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
        require_above_0(self, "wave_period_s")
        require_at_least_0(self, "sensor_noise_k")


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
