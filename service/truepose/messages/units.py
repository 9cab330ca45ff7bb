"""Units that a reader chose: what is kept in mm, degrees and °C, as a number in theirs. Pure.

A shown number is never coarser than the kept one: 0.001 mm is 0.00004 in, one or two digits more.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cache, lru_cache
from types import MappingProxyType
from typing import Final, Self

CHOICES: Final[Mapping[str, tuple[str, ...]]] = MappingProxyType(
    {"length": ("mm", "inch"), "angle": ("deg", "rad"), "temperature": ("c", "f")}  # kept in the first
)
_EXACT: Final = 6  # digits of a number that was given as it is
_FORMAT: Final = re.compile(r"(?P<lead>.*?)\.(?P<digits>\d+)(?P<kind>[a-z%]?)")


@dataclass(frozen=True, slots=True)
class Conversion:
    """From a kept unit to a shown one."""

    symbol: str
    factor: float = 1.0
    offset: float = 0.0
    decimal: str = "."  # the sign before decimals, in the language of who reads

    @property
    def finer(self) -> int:
        """Decimals that a shown number needs beyond those of the kept one."""
        return max(0, math.ceil(-math.log10(self.factor)))

    def of(self, value: float) -> float:
        """Return a kept value as the shown one."""
        return self.factor * value + self.offset

    def formatted(self, value: float, spec: str) -> str:
        """Return a kept value as a Python format writes it, with the digits that the shown unit needs."""
        plain = format(value, spec) if self.factor == 1.0 else format(self.of(value), self._finer(spec))
        return self.localised(plain)

    def localised(self, number: str) -> str:
        """Return a number as it is printed with the reader's decimal sign."""
        return number.replace(".", self.decimal)

    def _finer(self, spec: str) -> str:
        match = _FORMAT.fullmatch(spec)
        if match is None:
            return f"{spec.removesuffix('g')}.{_EXACT}g"
        digits = int(match["digits"]) + (self.finer if match["kind"] == "f" else 1)
        return f"{match['lead']}.{digits}{match['kind']}"


class ConvertibleNumber(str):
    """A number as it is printed in its kept unit, which can print itself in another one.

    `unit` is "" where only the text around it says what it is of.
    """

    unit: str
    _again: Callable[[Conversion], str]

    def __new__(cls, again: Callable[[Conversion], str], unit: str = "") -> Self:
        """Print a number in its kept unit; `again` prints it in any."""
        made = super().__new__(cls, again(Conversion(unit)))
        made._again, made.unit = again, unit
        return made

    def shown(self, conversion: Conversion) -> str:
        """Return the number in another unit, with the decimal sign that goes with it."""
        return conversion.localised(self._again(conversion))


_FINE_MM, _COARSE_MM = 0.1, 10.0


def length_form(value_mm: float) -> str:
    """Return the Python format of a length: to 0.1 um below 0.1 mm, to 1 um below 10 mm, else to 10 um."""
    decimals = 4 if abs(value_mm) < _FINE_MM else 3 if abs(value_mm) < _COARSE_MM else 2
    return f".{decimals}f"


_INCH_MM: Final = 25.4  # exactly
_FAHRENHEIT_PER_K: Final = 1.8
_ICE_F: Final = 32.0
_RAD: Final = math.pi / 180.0
_SHOWN: Final = {
    "inch": {
        "mm": Conversion("in", 1.0 / _INCH_MM),
        "um": Conversion("in", 1e-3 / _INCH_MM),
        "\N{MICRO SIGN}m": Conversion("in", 1e-3 / _INCH_MM),
        "mm/h": Conversion("in/h", 1.0 / _INCH_MM),
        "mm/s": Conversion("in/s", 1.0 / _INCH_MM),
    },
    "rad": {"deg": Conversion("rad", _RAD), "deg/h": Conversion("rad/h", _RAD)},
    "f": {
        "°C": Conversion("°F", _FAHRENHEIT_PER_K, _ICE_F),
        "degC": Conversion("°F", _FAHRENHEIT_PER_K, _ICE_F),
        "K": Conversion("°F", _FAHRENHEIT_PER_K),
    },
}
_PRINTED: Final = {"um": "\N{MICRO SIGN}m"}  # documents keep ASCII
_DEGREES_PER_K: Final = {  # by angle and temperature
    ("rad", "c"): Conversion("rad/K", _RAD),
    ("deg", "f"): Conversion("deg/°F", 1.0 / _FAHRENHEIT_PER_K),
    ("rad", "f"): Conversion("rad/°F", _RAD / _FAHRENHEIT_PER_K),
}

# What the format of a blank may name; others are words of its text.
KNOWN: Final = frozenset({"mm", "um", "\N{MICRO SIGN}m", "mm/h", "mm/s", "deg", "deg/h", "deg/K", "°C", "K"})


@dataclass(frozen=True, slots=True)
class Units:
    """What a reader chose, one of each of `CHOICES`, and the decimal sign of the reader's language."""

    length: str = "mm"
    angle: str = "deg"
    temperature: str = "c"
    decimal: str = "."

    @classmethod
    def of(cls, tokens: Iterable[str]) -> Self:
        """Return the units that tokens name (`inch`, `rad`); of what is not named, the kept ones."""
        return cls(**{kind: token for token in tokens for kind, known in CHOICES.items() if token in known})

    @property
    def chosen(self) -> tuple[str, str, str]:
        """The token of each of `CHOICES`."""
        return self.length, self.angle, self.temperature

    @property
    def tokens(self) -> tuple[str, ...]:
        """What is not shown as it is kept."""
        kept = (known[0] for known in CHOICES.values())
        return tuple(token for token, first in zip(self.chosen, kept, strict=True) if token != first)

    def conversion(self, unit: str) -> Conversion:
        """Return how a kept unit is shown; that of ratios, seconds or torques is shown as it is kept."""
        return _conversion(self, unit)

    def printed(self, number: ConvertibleNumber) -> str:
        """Return a printed number as the reader has it; one of no unit as it is."""
        return number.shown(self.conversion(number.unit))

    def number(self, number: str, unit: str) -> str:
        """Return a number that was kept in a unit, without that; a dash as it is."""
        return number.shown(self.conversion(unit)) if isinstance(number, ConvertibleNumber) else number

    def quantity(self, number: str, unit: str) -> str:
        """Return a number that was kept in a unit, with the shown one."""
        return f"{self.number(number, unit)} {self.conversion(unit).symbol}".rstrip()

    def formatted(self, value: float | ConvertibleNumber, form: str, unit: str) -> str:
        """Return a kept number as a Python format writes it, without the word for its unit.

        A length without a format has the digits that lengths have everywhere.
        """
        if unit == "mm" and not form and isinstance(value, float):
            form = length_form(value)
        conversion = self.conversion(unit or (value.unit if isinstance(value, ConvertibleNumber) else ""))
        return (
            value.shown(conversion)
            if isinstance(value, ConvertibleNumber)
            else conversion.formatted(value, form)
        )


@lru_cache(maxsize=1024)  # of every number that a page prints; findings name units of their own
def _conversion(units: Units, unit: str) -> Conversion:
    kept = Conversion(_PRINTED.get(unit, unit))
    shown = next((_SHOWN[token][unit] for token in units.tokens if unit in _SHOWN[token]), kept)
    if unit == "deg/K":
        shown = _DEGREES_PER_K.get((units.angle, units.temperature), kept)
    return replace(shown, decimal=units.decimal)


KEPT: Final = Units()


@dataclass(frozen=True, slots=True)
class Format:
    """How a blank is filled in: `.3f mm` a length with the word for its unit, `.3f (mm)` without it."""

    form: str  # a Python format, or what becomes of a name
    unit: str = ""  # that in which the value is kept
    is_named: bool = False  # whether the word for the unit stands behind the number

    @classmethod
    @cache
    def of(cls, spec: str) -> Self:
        """Return what the format of a blank says."""
        form, _, last = spec.rpartition(" ")
        unit = last.removeprefix("(").removesuffix(")")
        return cls(form, unit, unit == last) if unit in KNOWN else cls(spec)


def constant(number: str) -> ConvertibleNumber:
    """Return a number that a text states itself, which keeps its digits and its decimal sign."""
    value, digits = number.replace(",", "."), len(number.replace(",", ".").partition(".")[2])
    sign = "," if "," in number else "."
    return ConvertibleNumber(lambda shown: shown.formatted(float(value), f".{digits}f").replace(".", sign))
