"""Which numbers of a file can be the quantity that their name says at all.

Beyond these limits no instrument could have said the number: it is a slip of a program or of a unit, and one
of them among a thousand good readings would spoil a sum of squares. Names say their unit (`x_mm`, `q1_deg`).
"""

from dataclasses import dataclass
from typing import Final

from truepose.exchange.unit_suffix import unit

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
            f"{shown} {self.unit} is no {self.what} that anybody could have read: "
            f"{self.greatest:,.0f} {self.unit} is the most; correct it"
        )


def limits_of(name: str) -> Limits:
    """Return what the numbers under a name must keep to; the name is that of a column or key."""
    said = unit(name)
    if _UNCERTAINTY in name.split("_") and said in _BOUNDS_OF_UNCERTAINTY:
        least, greatest = _BOUNDS_OF_UNCERTAINTY[said]
        return Limits("standard uncertainty", said, greatest, least)
    if said not in _GREATEST:
        return Limits("quantity", "", _ANY)
    what, greatest = _GREATEST[said]
    return Limits(what, said, greatest)
