"""How far a slow motion has come after some time, per unit of its rate at the beginning.

`linear` goes on evenly (and came from before the origin of times); `exp<tau>` begins at the origin and dies
out with the time constant tau [s].
"""

from dataclasses import dataclass

import numpy as np

from truepose_simulators.physics.rigid import FloatArray

SHAPES = r"(linear|exp[0-9.e+]+)"
_S_PER_H = 3600.0


@dataclass(frozen=True, slots=True)
class Course:
    """One slow motion: `rate` [mm/h, rad/h], even where it has no time constant."""

    rate: FloatArray  # (6,)
    time_constant_s: float | None

    def come(self, time_s: FloatArray) -> FloatArray:
        """Return the way at times since the origin, shape (n,) -> (n, 6) [mm, rad]."""
        if self.time_constant_s is None:
            hours = time_s / _S_PER_H
        else:
            elapsed = np.maximum(time_s, 0.0) / self.time_constant_s
            hours = self.time_constant_s / _S_PER_H * (1.0 - np.exp(-elapsed))
        way: FloatArray = hours[:, np.newaxis] * self.rate
        return way


def courses(rates: dict[str, FloatArray]) -> tuple[Course, ...]:
    """Return the motions of rates by the name of their shape."""
    return tuple(
        Course(rate, None if shape == "linear" else float(shape.removeprefix("exp")))
        for shape, rate in rates.items()
    )
