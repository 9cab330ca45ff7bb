"""Recipes: which fields a data packet holds, in which order and of which types."""

import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final, TypeAlias

from truepose_drivers.universal_robots.protocol.errors import UrProtocolError
from truepose_drivers.universal_robots.protocol.packets import Kind, Packet

Values: TypeAlias = Mapping[str, tuple[float, ...]]  # of single numbers tuples of one

NOT_FOUND: Final = "NOT_FOUND"  # in the place of a type: the controller does not know that field
IN_USE: Final = "IN_USE"  # another client writes it

# Format and count of each type; RTDE guide, "Data types".
_TYPES: Final[Mapping[str, tuple[str, int]]] = {
    "BOOL": ("?", 1),
    "UINT8": ("B", 1),
    "UINT32": ("I", 1),
    "UINT64": ("Q", 1),
    "INT32": ("i", 1),
    "DOUBLE": ("d", 1),
    "VECTOR3D": ("d", 3),
    "VECTOR6D": ("d", 6),
    "VECTOR6INT32": ("i", 6),
    "VECTOR6UINT32": ("I", 6),
}


@dataclass(frozen=True, slots=True)
class Recipe:
    """Fields and their types under the number that the controller gave them."""

    number: int
    fields: Mapping[str, str]

    def pack(self, values: Values) -> Packet:
        """Return the data packet of values; raises KeyError where a field has none."""
        numbers = [_written(kind, number) for name, kind in self.fields.items() for number in values[name]]
        return Packet(Kind.DATA, bytes([self.number]) + self._layout.pack(*numbers))

    def unpack(self, payload: bytes) -> dict[str, tuple[float, ...]]:
        """Return the values of a data packet; raises UrProtocolError where it is none of this recipe."""
        if len(payload) != self._layout.size + 1 or payload[0] != self.number:
            raise UrProtocolError(
                f"a data packet of {len(payload)} bytes for recipe {payload[:1].hex() or 'none'}; due were"
                f" {self._layout.size + 1} bytes for recipe {self.number:02x}"
            )
        numbers = iter(self._layout.unpack(payload[1:]))
        values = {
            name: tuple(next(numbers) for _ in range(_TYPES[kind][1])) for name, kind in self.fields.items()
        }
        _require_finite(values)
        return values

    @property
    def _layout(self) -> struct.Struct:
        return struct.Struct(
            ">" + "".join(_TYPES[kind][0] * _TYPES[kind][1] for kind in self.fields.values())
        )


def agreed_recipe(number: int, types: Iterable[str], wanted: Mapping[str, str]) -> Recipe:
    """Return the recipe of fields with the types that were expected; raises UrProtocolError."""
    stated = list(types)
    if stated != list(wanted.values()):
        raise UrProtocolError(
            f"types {','.join(stated)[:120]} were stated; due were {','.join(wanted.values())}"
        )
    return Recipe(number, wanted)


def _written(kind: str, number: float) -> float:
    return number if _TYPES[kind][0] == "d" else int(number)


def _require_finite(values: Values) -> None:
    for name, numbers in values.items():
        if not all(map(math.isfinite, numbers)):
            raise UrProtocolError(f"field {name} is {numbers}: no numbers")
