"""Units in the names of columns and keys: `x_mm` and `x_m` are the same quantity in two units."""

from collections.abc import Iterable

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
