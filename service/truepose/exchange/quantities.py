"""Quantities by the names of columns and keys: their units, and which numbers they can be at all.

Beyond these limits no instrument could have said the number: it is a slip of a program or of a unit, and one
of them among a thousand good readings would spoil a sum of squares. Names say their unit (`x_mm`, `q1_deg`).
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

# fmt: off
_UNIT_TOKENS = frozenset({
    "m", "mm", "cm", "um", "nm", "km", "in", "inch", "ft", "m2", "mm2", "um2",
    "deg", "rad", "mrad", "urad", "grad", "degree", "degrees", "radian", "radians", "arcsec",
    "s", "ms", "us", "min", "h", "sec", "seconds", "s2", "hz",
    "c", "k", "f", "degc", "celsius", "kelvin",
    "n", "nmm", "knm", "kg", "g", "lb", "per", "ppm", "percent",
})
# fmt: on


def quantity(name: str) -> str:
    """Return `name` without the parts that are units: `q1_rad` gives `q1`."""
    return "_".join(part for part in name.split("_") if part.lower() not in _UNIT_TOKENS)


def unit(name: str) -> str:
    """Return the parts of `name` that are units, joined: `tau1_Nm` gives `Nm`; empty where there are none."""
    return "_".join(part for part in name.split("_") if part.lower() in _UNIT_TOKENS)


def in_other_unit(wanted: str, present: Iterable[str]) -> str | None:
    """Return the name in `present` that is the quantity `wanted` in another unit or without one, or None.

    A name that says a unit is preferred to one that says none.
    """
    if not unit(wanted):
        return None
    rivals = [name for name in present if name != wanted and quantity(name) == quantity(wanted)]
    return min(rivals, key=lambda name: not unit(name), default=None)


def unit_sentence(kind: str, found: str, wanted: str) -> str:
    """Say that `found` (a `kind`: column or key) stands where `wanted` is required."""
    says = f"has the unit {unit(found)}" if unit(found) else "has no unit"
    return f"{kind} {found} {says}; {wanted} in {unit(wanted)} is required"


# Where a name says no unit: no quantity in any unit comes near; and its square still is an ordinary float.
_ANY: Final = 1e30
_GREATEST: Final = {
    "mm": ("length", 1e6),  # a kilometre: the corner of a plant that a shop counts from lies nearer
    "deg": ("angle", 360_000.0),  # a thousand turns of an axis
    "Nm": ("torque", 1e6),  # fifty times the largest robot's
    "C": ("temperature", 1000.0),
    "kg": ("mass", 1e6),
    "s": ("time", 1e10),  # three hundred years: seconds since 1970 pass, milliseconds do not
}
_UNCERTAINTY: Final = "u"  # the part of a name that says so: u_mm, tool_nest_u_mm
# A picometre is less than any instrument claims, and the square of much less is nothing.
_BOUNDS_OF_UNCERTAINTY: Final = {"mm": (1e-9, 1000.0), "deg": (1e-9, 180.0)}


@dataclass(frozen=True, slots=True)
class Limits:
    """How large and how small a number can be, either sign; 0 always can."""

    what: str
    unit: str
    greatest: float
    least: float = 0.0

    def accepts(self, number: float) -> bool:
        """Whether a number can be meant."""
        return number == 0.0 or self.least <= abs(number) <= self.greatest

    def fault(self, number: float, shown: str) -> str:
        """Say of a number that cannot be meant, as it was written, why not."""
        if not self.unit:
            return f"{shown} is too large for any quantity"
        if abs(number) < self.least:
            return (
                f"{shown} {self.unit} is smaller than the {self.what} of any instrument "
                f"({self.least:g} {self.unit}); correct it"
            )
        return (
            f"{shown} {self.unit} is not a plausible {self.what}: "
            f"the limit is {self.greatest:,.0f} {self.unit}; correct it"
        )


def limits_of(name: str) -> Limits:
    """Return what the numbers under a name must keep to; the name is that of a column or key."""
    said = unit(name)
    # Before the unit alone: what is a good length may be no uncertainty. One of a kilometre gives a reading
    # no weight, one of nothing gives it all.
    if _UNCERTAINTY in name.split("_") and said in _BOUNDS_OF_UNCERTAINTY:
        least, greatest = _BOUNDS_OF_UNCERTAINTY[said]
        return Limits("standard uncertainty", said, greatest, least)
    if said not in _GREATEST:
        return Limits("quantity", "", _ANY)
    what, greatest = _GREATEST[said]
    return Limits(what, said, greatest)
