"""Causes by their names, and the numbers that they are told with."""

from dataclasses import dataclass
from typing import Literal

from truepose.domain.arrays import FloatArray

Shape = Literal["line", "wave", "curve", "jump", "drift", "settling", "sign", "group"]


@dataclass(frozen=True, slots=True)
class Cause:
    """A physical cause by its name, e.g. `joint_gain` of `joint 2`."""

    effect: str
    subject: str


@dataclass(frozen=True, slots=True)
class Detail:
    """One more number of a finding: an order, a time, a rotation; in the unit it states."""

    name: str
    value: float
    unit: str
    standard_uncertainty: float


@dataclass(frozen=True, slots=True)
class Spectrum:
    """Waves of one joint by their order, k of them."""

    order: FloatArray  # (k,) ascending, periods per turn
    amplitude_deg: FloatArray  # (k,) less what noise adds; 0 where that explains all of it
    standard_uncertainty_deg: FloatArray  # (k,)
