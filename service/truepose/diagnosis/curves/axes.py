"""Axes: the variables over which curves are drawn, with their value at each reading."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.effects.causes import Scene
from truepose.effects.joints.joint_harmonics import ONE_PERIOD_FROM
from truepose.effects.shapes.times import SECONDS_PER_HOUR

N_MM_PER_N_M = 1e3
DRAWN = 200  # points of a line


@dataclass(frozen=True, slots=True)
class Axis:
    """A variable at the n readings; NaN where it is unknown."""

    variable: str
    unit: str
    x: FloatArray  # (n,)
    stepped: bool = False  # numbers of things instead of amounts

    @property
    def known(self) -> BoolArray:
        """Readings where it is known, shape (n,)."""
        return np.isfinite(self.x)

    def drawn(self, count: int) -> FloatArray:
        """Return evenly spread values from the least to the greatest."""
        known = self.x[self.known]
        if known.size == 0:
            return np.zeros(count)
        return np.linspace(float(known.min()), float(known.max()), count)

    def levels(self) -> FloatArray:
        """Return the values that occur, ascending."""
        return np.unique(self.x[self.known])


def angle_axis(turn_rad: FloatArray, joint: int, order: float = 1.0) -> Axis:
    """Return the angle of a joint (0-based), within one period where waves of that order are fast."""
    angle_deg = np.rad2deg(turn_rad)
    if order > ONE_PERIOD_FROM:
        variable = f"angle of joint {joint + 1} within one period"
        return Axis(variable, "deg", np.mod(angle_deg, 360.0 / order))
    return Axis(f"angle of joint {joint + 1}", "deg", angle_deg)


def level_axis(variable: str, numbers: FloatArray | IntArray) -> Axis:
    """Return an axis of numbers of nests or mountings, or of directions; 0, an unknown one, is left out."""
    values = numbers.astype(float)
    return Axis(variable, "", np.where(values == 0.0, np.nan, values), stepped=True)


def time_axis(scene: Scene, over: str) -> Axis | None:
    """Return the `temperature` or the `time`; None where it is unknown."""
    stops = scene.stops
    if over == "temperature":
        return None if stops.temperature_c is None else Axis("temperature", "degC", stops.temperature_c)
    if stops.time_s is None:
        return None
    return Axis("time", "h", (stops.time_s - scene.origin_s) / SECONDS_PER_HOUR)
