"""Units that a reader chose: what is kept in mm, degrees and °C, as a number in theirs. Pure.

A shown number is never coarser than the kept one: 0.001 mm is 0.00004 in, one or two digits more.
"""

import math
import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
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

    @property
    def finer(self) -> int:
        """Decimals that a shown number needs beyond those of the kept one."""
        return max(0, math.ceil(-math.log10(self.factor)))

    def of(self, value: float) -> float:
        """Return a kept value as the shown one."""
        return self.factor * value + self.offset

    def formatted(self, value: float, spec: str) -> str:
        """Return a kept value as a Python format writes it, with the digits that the shown unit needs."""
        return format(value, spec) if self.factor == 1.0 else format(self.of(value), self._finer(spec))

    def _finer(self, spec: str) -> str:
        match = _FORMAT.fullmatch(spec)
        if match is None:
            return f"{spec.removesuffix('g')}.{_EXACT}g"
        digits = int(match["digits"]) + (self.finer if match["kind"] == "f" else 1)
        return f"{match['lead']}.{digits}{match['kind']}"


class Printed(str):
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
        """Return the number in another unit."""
        return self._again(conversion)


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
_DEGREES_PER_K: Final = {  # by angle and temperature
    ("rad", "c"): Conversion("rad/K", _RAD),
    ("deg", "f"): Conversion("deg/°F", 1.0 / _FAHRENHEIT_PER_K),
    ("rad", "f"): Conversion("rad/°F", _RAD / _FAHRENHEIT_PER_K),
}

_UNIT: Final = "(?:mm/h|mm/s|deg/h|deg/K|mm|um|\N{MICRO SIGN}m|deg|°C|K)(?![A-Za-z0-9_/*^²(])"
_BLANK: Final = re.compile(
    rf"\{{(?P<name>\w+)(?::(?P<spec>[^{{}}]*))?\}}(?:(?P<gap>\)? ?)(?P<unit>{_UNIT}))?"
)
_HEAD: Final = re.compile(rf"\[(?P<unit>{_UNIT})(?=[\],;])")
_LITERAL: Final = re.compile(rf"(?<![\w.,:{{])(?P<number>\d+(?:[.,]\d+)?)(?P<gap> ?)(?P<unit>{_UNIT})")
_NAMED: Final = re.compile(r"(?:^|_)(mm_per_h|deg_per_h|deg_per_k|mm|um|deg|c)$")
_OF_NAMES: Final = {"mm_per_h": "mm/h", "deg_per_h": "deg/h", "deg_per_k": "deg/K", "c": "°C"}
_BESIDE: Final = "|"  # between the format of a blank, its unit, and what joins it to the word for that


@dataclass(frozen=True, slots=True)
class Units:
    """What a reader chose, one of each of `CHOICES`."""

    length: str = "mm"
    angle: str = "deg"
    temperature: str = "c"

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
        if unit == "deg/K":
            return _DEGREES_PER_K.get((self.angle, self.temperature), Conversion(unit))
        return next((_SHOWN[token][unit] for token in self.tokens if unit in _SHOWN[token]), Conversion(unit))

    def printed(self, number: Printed) -> str:
        """Return a printed number as the reader has it; one of no unit as it is."""
        return number.shown(self.conversion(number.unit))

    def number(self, number: str, unit: str) -> str:
        """Return a number that was kept in a unit, without that; a dash as it is."""
        return number.shown(self.conversion(unit)) if isinstance(number, Printed) else number

    def quantity(self, number: str, unit: str) -> str:
        """Return a number that was kept in a unit, with the shown one."""
        return f"{self.number(number, unit)} {self.conversion(unit).symbol}".rstrip()

    def text(self, text: str) -> str:
        """Return a text of the catalogue whose blanks know their units and whose heads name the shown ones.

        A blank's unit stands behind it (`{worst:.3f} mm`), or its name ends in it (`{low_mm:.3f} to …`).
        """
        if not self.tokens:
            return text
        blanks = _BLANK.sub(_with_unit, text)
        heads = _HEAD.sub(lambda head: f"[{self.conversion(head['unit']).symbol}", blanks)
        return _LITERAL.sub(self._literal, heads)

    def _literal(self, match: re.Match[str]) -> str:
        conversion, number = self.conversion(match["unit"]), match["number"].replace(",", ".")
        shown = conversion.formatted(float(number), f".{len(number.partition('.')[2])}f")
        written = shown.replace(".", ",") if "," in match["number"] else shown
        return f"{written}{match['gap']}{conversion.symbol}"

    def filled(self, value: float | Printed, form: str, unit: str, gap: str | None) -> str:
        """Return what fills in a blank of `text`, as `blank` has read its format."""
        conversion = self.conversion(unit or (value.unit if isinstance(value, Printed) else ""))
        number = value.shown(conversion) if isinstance(value, Printed) else conversion.formatted(value, form)
        return number if gap is None else f"{number}{gap}{conversion.symbol}"


KEPT: Final = Units()


def blank(spec: str) -> tuple[str, str, str | None]:
    """Return the format of a blank's number, its unit, and what joins the number to the word for that."""
    form, *beside = spec.split(_BESIDE)
    return form, beside[0] if beside else "", beside[1] if len(beside) > 1 else None


def _with_unit(found: re.Match[str]) -> str:
    """Return a blank with its unit in its format; the word for it is filled in with the number."""
    name, spec, unit = found["name"], found["spec"] or "", found["unit"]
    named = _NAMED.search(name)
    if named is None and (unit is None or "_per_" in name):  # of compounds that are shown as they are kept
        return found[0]
    if named is not None and unit is None:
        return f"{{{name}:{spec}{_BESIDE}{_OF_NAMES.get(named[1], named[1])}}}"
    return f"{{{name}:{spec}{_BESIDE}{unit}{_BESIDE}{found['gap']}}}"
