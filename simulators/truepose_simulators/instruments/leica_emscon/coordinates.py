"""From the instrument's own frame and units to what the user sees, and back.

A point goes through the station's orientation (p' = R p + t, where the station stands), the transformation
(p'' = m R^T (p' - t), where the object's frame stands, m a scale), the coordinate type and the units. R is
RotX RotY RotZ of the three angles. The public sources do not state these two directions; they follow the
names of the commands.

Coordinate types: left-handed types reverse the named axis; cylindrical ones are radius, angle, height;
spherical ones horizontal angle, zenith angle, distance. Clockwise angles run against the right-handed sense.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum, auto

import numpy as np

from truepose_drivers.leica_emscon.protocol import settings
from truepose_simulators.physics.rigid import FloatArray, inverse, move


class Quantity(Enum):
    """What a member of a packet measures."""

    LENGTH = auto()
    ANGLE = auto()
    TEMPERATURE = auto()
    PRESSURE = auto()
    NUMBER = auto()


_MM: Mapping[int, float] = {
    settings.LengthUnit.METER: 1000.0,
    settings.LengthUnit.MILLIMETER: 1.0,
    settings.LengthUnit.MICRON: 1e-3,
    settings.LengthUnit.FOOT: 304.8,
    settings.LengthUnit.YARD: 914.4,
    settings.LengthUnit.INCH: 25.4,
}
_RAD: Mapping[int, float] = {
    settings.AngleUnit.RADIAN: 1.0,
    settings.AngleUnit.DEGREE: math.pi / 180.0,
    settings.AngleUnit.GON: math.pi / 200.0,
}
# Conventional millimetre of mercury and inch of water at 4 C, ISO 80000-4 annex.
_HPA: Mapping[int, float] = {
    settings.PressureUnit.MBAR: 1.0,
    settings.PressureUnit.HECTOPASCAL: 1.0,
    settings.PressureUnit.KILOPASCAL: 10.0,
    settings.PressureUnit.MM_HG: 1.33322387415,
    settings.PressureUnit.PSI: 68.94757293,
    settings.PressureUnit.IN_H2O: 2.490889,
    settings.PressureUnit.IN_HG: 33.86389,
}


@dataclass(frozen=True, slots=True)
class Units:
    """Units in force; the defaults are those of a server after power-up."""

    length: settings.LengthUnit = settings.LengthUnit.METER
    angle: settings.AngleUnit = settings.AngleUnit.RADIAN
    temperature: settings.TemperatureUnit = settings.TemperatureUnit.CELSIUS
    pressure: settings.PressureUnit = settings.PressureUnit.MBAR

    def to_wire(self, quantity: Quantity, value: float) -> float:
        """Convert an inside value to the user's unit."""
        if quantity is Quantity.TEMPERATURE and self.temperature == settings.TemperatureUnit.FAHRENHEIT:
            return value * 1.8 + 32.0
        return value / self._factor(quantity)

    def from_wire(self, quantity: Quantity, value: float) -> float:
        """Convert a value in the user's unit to the inside."""
        if quantity is Quantity.TEMPERATURE and self.temperature == settings.TemperatureUnit.FAHRENHEIT:
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


_CYLINDRICAL = (settings.CoordinateSystemType.CCW, settings.CoordinateSystemType.CCC)
_SPHERICAL = (settings.CoordinateSystemType.SCW, settings.CoordinateSystemType.SCC)
_CLOCKWISE = (settings.CoordinateSystemType.CCW, settings.CoordinateSystemType.SCW)
_REVERSED_AXIS = {
    settings.CoordinateSystemType.LHRX: 0,
    settings.CoordinateSystemType.LHRY: 1,
    settings.CoordinateSystemType.LHRZ: 2,
}
# Central differences over this step are exact to 1e-9 of the result at the distances of a cell.
_STEP_MM = 1e-2


@dataclass(frozen=True, slots=True)
class CoordinateView:
    """How the user wants to see coordinates."""

    units: Units = field(default_factory=Units)
    kind: settings.CoordinateSystemType = settings.CoordinateSystemType.RHR
    placement: FloatArray = field(default_factory=lambda: np.eye(4))  # user frame from instrument frame
    scale: float = 1.0

    @property
    def quantities(self) -> tuple[Quantity, Quantity, Quantity]:
        """What the three coordinates measure."""
        if self.kind in _SPHERICAL:
            return Quantity.ANGLE, Quantity.ANGLE, Quantity.LENGTH
        if self.kind in _CYLINDRICAL:
            return Quantity.LENGTH, Quantity.ANGLE, Quantity.LENGTH
        return Quantity.LENGTH, Quantity.LENGTH, Quantity.LENGTH

    def to_wire(self, position_mm: FloatArray) -> tuple[float, float, float]:
        """Return the user's coordinates of a point of the instrument frame."""
        placed = self.scale * move(self.placement, position_mm)
        x, y, z = self._from_cartesian(placed.tolist())
        first, second, third = self.quantities
        to_wire = self.units.to_wire
        return to_wire(first, x), to_wire(second, y), to_wire(third, z)

    def from_wire(self, coordinates: tuple[float, float, float]) -> FloatArray:
        """Return the point of the instrument frame [mm] that the user's coordinates mean."""
        inside = [
            self.units.from_wire(quantity, value)
            for quantity, value in zip(self.quantities, coordinates, strict=True)
        ]
        return move(inverse(self.placement), np.array(self._to_cartesian(inside)) / self.scale)

    def covariance_to_wire(self, position_mm: FloatArray, covariance_mm2: FloatArray) -> FloatArray:
        """Return the covariance of the user's coordinates, in the user's units, shape (3, 3)."""
        steps = _STEP_MM * np.eye(3)
        ahead = np.array([self.to_wire(position_mm + step) for step in steps])
        behind = np.array([self.to_wire(position_mm - step) for step in steps])
        # To first order J C J', whatever the type of coordinates and the units are.
        jacobian = (ahead - behind).T / (2.0 * _STEP_MM)
        result: FloatArray = jacobian @ covariance_mm2 @ jacobian.T
        return result

    def _from_cartesian(self, xyz: list[float]) -> list[float]:
        if self.kind in _REVERSED_AXIS:
            xyz[_REVERSED_AXIS[self.kind]] *= -1.0
            return xyz
        if self.kind == settings.CoordinateSystemType.RHR:
            return xyz
        x, y, z = xyz
        bearing = self._sense * math.atan2(y, x)
        radius = math.hypot(x, y)
        if self.kind in _CYLINDRICAL:
            return [radius, bearing, z]
        return [bearing, math.atan2(radius, z), math.hypot(radius, z)]

    def _to_cartesian(self, values: list[float]) -> list[float]:
        if self.kind in _REVERSED_AXIS:
            values[_REVERSED_AXIS[self.kind]] *= -1.0
            return values
        if self.kind == settings.CoordinateSystemType.RHR:
            return values
        if self.kind in _CYLINDRICAL:
            radius, bearing, z = values
        else:
            bearing, zenith, distance = values
            radius, z = distance * math.sin(zenith), distance * math.cos(zenith)
        bearing *= self._sense
        return [radius * math.cos(bearing), radius * math.sin(bearing), z]

    @property
    def _sense(self) -> float:
        return -1.0 if self.kind in _CLOCKWISE else 1.0
