"""How well the ballbar measures: its setup, and how its zero walks from magnet to magnet.

Source of the sizes: A. Nubiola, thesis, ETS Montreal 2014, sections 3.2 (2 um at 95 %) and 3.5 (the magnets'
snaps and handling add up to 3 um between two initialisations).
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.errors import ScenarioError
from truepose_simulators.physics.rigid import FloatArray


@dataclass(frozen=True, slots=True)
class BallbarSetup:
    """The ballbar and how its cups come to their places."""

    nominal_mm: float = 300.0  # with the bars for base triangle and legs
    tool_nominal_mm: float = 150.0  # with the bars for the tool triangle
    range_mm: float = 1.0  # either way of the nominal length
    resolution_mm: float = 0.0001
    noise_mm: float = 0.00051  # of one reading
    snap_mm: float = 0.0006  # by which the zero walks whenever a magnet takes or lets go of a ball
    zero_bound_mm: float = 0.003  # no farther from the zero of the last initialisation
    clamp_mm: float = 0.01  # per axis, between the ball that the robot held and the clamped cup
    bars_mm: float = 0.02  # by which bars are off their nominal length each time they are screwed on
    travel_mm: float = 3.0  # either way, before a magnet lets go

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            if getattr(self, name) < 0.0:
                raise ScenarioError(f'key "{name}" must be 0 or more, not {getattr(self, name)}')
        if min(self.range_mm, self.resolution_mm) <= 0.0:
            raise ScenarioError('keys "range_mm" and "resolution_mm" must be above 0')

    @property
    def stated_u_mm(self) -> float:
        """Standard uncertainty of a reading: noise, and a zero that is somewhere between its bounds."""
        return float(np.hypot(self.noise_mm, self.zero_bound_mm / 2.0))


def snapped_zero_mm(setup: BallbarSetup, zero_mm: float, rng: np.random.Generator) -> float:
    """Return the zero after one more snap; at its bounds it stops."""
    walked = zero_mm + setup.snap_mm * float(rng.standard_normal())
    return float(np.clip(walked, -setup.zero_bound_mm, setup.zero_bound_mm))


def walked_zeros_mm(setup: BallbarSetup, n: int, rng: np.random.Generator) -> FloatArray:
    """Zeros of `n` readings after one initialisation, the ballbar taken off and put on before each."""
    zeros, zero_mm = np.zeros(n), 0.0
    for reading in range(n):
        for _ in range(_SNAPS_PER_READING):
            zero_mm = snapped_zero_mm(setup, zero_mm, rng)
        zeros[reading] = zero_mm
    return zeros


# Both ends leave one pair of balls and come to another.
_SNAPS_PER_READING = 2


def rounded_mm(setup: BallbarSetup, length_mm: FloatArray) -> FloatArray:
    """Lengths as the display has them."""
    shown: FloatArray = np.round(length_mm / setup.resolution_mm) * setup.resolution_mm
    return shown
