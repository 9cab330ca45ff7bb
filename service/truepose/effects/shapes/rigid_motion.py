"""Rigid motions as parameters: three shifts and three turns with a common prefix, and their own words."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.causes import Detail
from truepose.domain.results.identification import Unit
from truepose.effects.causes import Fitted, norm_with_uncertainty
from truepose.effects.ports import ParameterSpec

COMPONENTS = ("x", "y", "z", "rx", "ry", "rz")


class Widths(NamedTuple):
    """What is believed of a motion before any reading: standard deviations per axis, and their units."""

    shift: float
    turn: float
    shift_unit: Unit = "mm"
    turn_unit: Unit = "rad"


class Motion(NamedTuple):
    """A small motion as it was fitted: shift and turn about the three axes [mm and rad, or both per h]."""

    vector: FloatArray  # (6,)
    covariance: FloatArray  # (6, 6)

    @property
    def shift(self) -> tuple[float, float]:
        """Length of the shift and its standard uncertainty."""
        return norm_with_uncertainty(self.vector[:3], self.covariance[:3, :3])

    @property
    def turn_deg(self) -> tuple[float, float]:
        """Angle of the turn and its standard uncertainty, in degrees."""
        angle, uncertainty = norm_with_uncertainty(self.vector[3:], self.covariance[3:, 3:])
        return float(np.rad2deg(angle)), float(np.rad2deg(uncertainty))

    def details(self, per: str = "") -> tuple[Detail, ...]:
        """Return the components of the shift and the size of the turn; `per` is e.g. `/h`."""
        spread = np.sqrt(np.diag(self.covariance))
        shifts = [
            Detail(axis, float(self.vector[k]), f"mm{per}", float(spread[k]))
            for k, axis in enumerate(COMPONENTS[:3])
        ]
        return (*shifts, Detail("rotation", self.turn_deg[0], f"deg{per}", self.turn_deg[1]))

    def seen_at(self, point_mm: FloatArray) -> "Motion":
        """Return the motion whose shift is that of a point (3,), where this one's is that of the origin."""
        x, y, z = (float(value) for value in point_mm)
        carry = np.eye(6)
        carry[:3, 3:] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]  # turn x point
        return Motion(carry @ self.vector, carry @ self.covariance @ carry.T)


def motion_specs(prefix: str, widths: Widths) -> tuple[ParameterSpec, ...]:
    """Return the six parameters `<prefix>_x` .. `<prefix>_rz`."""
    shifts = (
        ParameterSpec(f"{prefix}_{name}", widths.shift_unit, 0.0, widths.shift) for name in COMPONENTS[:3]
    )
    turns = (ParameterSpec(f"{prefix}_{name}", widths.turn_unit, 0.0, widths.turn) for name in COMPONENTS[3:])
    return (*shifts, *turns)


def split_motion(name: str) -> tuple[str, int]:
    """Return prefix and component (0..5) of e.g. `seat_2_rx`."""
    prefix, _, component = name.rpartition("_")
    return prefix, COMPONENTS.index(component)


def fitted_motion(fitted: Fitted, share: Callable[[str], float]) -> Motion:
    """Add up fitted motions, each parameter counted by the share that its prefix has in the sum."""
    gather = np.zeros((6, len(fitted.names)))
    for k, name in enumerate(fitted.names):
        prefix, component = split_motion(name)
        gather[component, k] = share(prefix)
    return Motion(gather @ fitted.values, gather @ fitted.covariance @ gather.T)
