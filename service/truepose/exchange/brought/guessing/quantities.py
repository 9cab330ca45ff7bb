"""What a column can be, and in which units people write it."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Final

AXES: Final = "xyz"
NOTHING: Final = "nothing"
_ANGLE: Final = MappingProxyType({"deg": 1.0, "rad": 57.29577951308232, "mrad": 0.05729577951308232})
_LENGTH: Final = MappingProxyType({"mm": 1.0, "m": 1000.0, "cm": 10.0, "um": 1e-3, "in": 25.4})
_TORQUE: Final = MappingProxyType({"Nm": 1.0, "Nmm": 1e-3, "kNm": 1000.0})
_TIME: Final = MappingProxyType({"s": 1.0, "ms": 1e-3, "us": 1e-6, "min": 60.0, "h": 3600.0})
_TEMPERATURE: Final = MappingProxyType({"C": 1.0, "K": 1.0, "F": 5.0 / 9.0})
_ZERO_C: Final = {"K": 273.15, "F": 32.0}
_NO_UNIT: Final[Mapping[str, float]] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Quantity:
    """A kind of column; with `numbered` there is one a joint or an axis."""

    name: str  # as the catalogue and requests know it
    column: str  # of the file format; `{}` is the number of the joint, or the axis
    units: Mapping[str, float] = field(
        default_factory=lambda: _NO_UNIT
    )  # size of each in the format's own unit, which is the first
    numbered: str = ""  # "joint", "axis", or not

    def named(self, number: int) -> str:
        """Return the column of the file format for a joint, or an axis from 1."""
        return self.column.format(AXES[number - 1] if self.numbered == "axis" else number)


_TABLE: Final = (
    Quantity("joint", "q{}_deg", _ANGLE, "joint"),
    Quantity("position", "{}_mm", _LENGTH, "axis"),
    Quantity("nest", "nest"),
    Quantity("config", "config"),
    Quantity("direction", "dir{}", numbered="joint"),
    Quantity("torque", "tau{}_Nm", _TORQUE, "joint"),
    Quantity("time", "time_s", _TIME),
    Quantity("temperature", "temperature_C", _TEMPERATURE),
    Quantity("uncertainty", "u_mm", _LENGTH),
    Quantity("attachment", "attachment"),
    Quantity("qw", "qw"),
    Quantity("qx", "qx"),
    Quantity("qy", "qy"),
    Quantity("qz", "qz"),
    Quantity("length", "length_mm", _LENGTH),
    Quantity("base_point", "base_point"),
    Quantity("tool_point", "tool_point"),
    Quantity("placement", "placement"),
    Quantity("init", "init"),
    Quantity("repeat_of", "repeat_of"),
    Quantity("group", "group"),
    Quantity("rotation_uncertainty", "u_rot_deg"),
    Quantity("uncertainty_along", "u_along_mm"),
    Quantity("uncertainty_across", "u_across_mm"),
    Quantity(NOTHING, ""),
)
QUANTITIES: Final[Mapping[str, Quantity]] = MappingProxyType({one.name: one for one in _TABLE})
OF_THE_FORMAT: Final = MappingProxyType({
    one.column: one for one in _TABLE if one.column and not one.numbered
})
LABELS: Final = frozenset({"nest", "config", "base_point", "tool_point", "placement", "attachment", "init"})


@dataclass(frozen=True, slots=True)
class Meaning:
    """What a column is."""

    quantity: str  # of QUANTITIES
    number: int = 0  # of the joint, or the axis from 1; 0: neither
    unit: str = ""
    point: int = 0  # which of several points of its row, from 1; 0: there is one

    @property
    def column(self) -> str:
        """Its name in the file format; "" where it is nothing."""
        return QUANTITIES[self.quantity].named(self.number)

    def converted(self, value: float) -> float:
        """Return a number of this column in the unit of the file format."""
        size = QUANTITIES[self.quantity].units.get(self.unit, 1.0)
        offset = _ZERO_C.get(self.unit, 0.0) if self.quantity == "temperature" else 0.0
        return (value - offset) * size


MEANS_NOTHING: Final = Meaning(NOTHING)
