"""The user's units of emScon; inside mm, rad, C and hPa."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum, auto

from truepose_drivers.leica_emscon.protocol.settings import (
    AngleUnit,
    LengthUnit,
    PressureUnit,
    TemperatureUnit,
)


class Quantity(Enum):
    """What a member of a packet measures."""

    LENGTH = auto()
    ANGLE = auto()
    TEMPERATURE = auto()
    PRESSURE = auto()
    NUMBER = auto()


_MM: Mapping[int, float] = {
    LengthUnit.METER: 1000.0,
    LengthUnit.MILLIMETER: 1.0,
    LengthUnit.MICRON: 1e-3,
    LengthUnit.FOOT: 304.8,
    LengthUnit.YARD: 914.4,
    LengthUnit.INCH: 25.4,
}
_RAD: Mapping[int, float] = {
    AngleUnit.RADIAN: 1.0,
    AngleUnit.DEGREE: math.pi / 180.0,
    AngleUnit.GON: math.pi / 200.0,
}
# Conventional millimetre of mercury and inch of water at 4 C, ISO 80000-4 annex.
_HPA: Mapping[int, float] = {
    PressureUnit.MBAR: 1.0,
    PressureUnit.HECTOPASCAL: 1.0,
    PressureUnit.KILOPASCAL: 10.0,
    PressureUnit.MM_HG: 1.33322387415,
    PressureUnit.PSI: 68.94757293,
    PressureUnit.IN_H2O: 2.490889,
    PressureUnit.IN_HG: 33.86389,
}


@dataclass(frozen=True, slots=True)
class Units:
    """Units in force; the defaults are those of a server after power-up."""

    length: LengthUnit = LengthUnit.METER
    angle: AngleUnit = AngleUnit.RADIAN
    temperature: TemperatureUnit = TemperatureUnit.CELSIUS
    pressure: PressureUnit = PressureUnit.MBAR

    def to_wire(self, quantity: Quantity, value: float) -> float:
        """Convert an inside value to the user's unit."""
        if quantity is Quantity.TEMPERATURE and self.temperature == TemperatureUnit.FAHRENHEIT:
            return value * 1.8 + 32.0
        return value / self._factor(quantity)

    def from_wire(self, quantity: Quantity, value: float) -> float:
        """Convert a value in the user's unit to the inside."""
        if quantity is Quantity.TEMPERATURE and self.temperature == TemperatureUnit.FAHRENHEIT:
            return (value - 32.0) / 1.8
        return value * self._factor(quantity)

    def _factor(self, quantity: Quantity) -> float:
        match quantity:
            case Quantity.LENGTH:
                return _MM[self.length]
            case Quantity.ANGLE:
                return _RAD[self.angle]
            case Quantity.PRESSURE:
                return _HPA[self.pressure]
            case _:
                return 1.0
