"""Keep-out volumes: what nothing of the arm may enter, in the world frame."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TypeAlias

Vector: TypeAlias = tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Box:
    """A box along the axes of the world."""

    name: str
    lower_mm: Vector
    upper_mm: Vector


@dataclass(frozen=True, slots=True)
class Cylinder:
    """A round bar with flat ends."""

    name: str
    start_mm: Vector
    end_mm: Vector
    radius_mm: float


@dataclass(frozen=True, slots=True)
class HalfSpace:
    """All that lies behind a plane, such as a wall."""

    name: str
    point_mm: Vector  # of the plane
    outward: Vector  # towards the free side, of any length but none


KeepOut: TypeAlias = Box | Cylinder | HalfSpace


@dataclass(frozen=True, slots=True)
class KeepOuts:
    """All keep-out volumes of a cell; their names differ."""

    boxes: tuple[Box, ...] = ()
    cylinders: tuple[Cylinder, ...] = ()
    half_spaces: tuple[HalfSpace, ...] = ()

    def __iter__(self) -> Iterator[KeepOut]:
        """Iterate over all of them, boxes first."""
        yield from self.boxes
        yield from self.cylinders
        yield from self.half_spaces

    def __len__(self) -> int:
        return len(self.boxes) + len(self.cylinders) + len(self.half_spaces)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all of them."""
        return tuple(volume.name for volume in self)

    def without(self, name: str) -> "KeepOuts":
        """Return all but one."""
        return keep_outs_of([volume for volume in self if volume.name != name])

    def joined(self, others: "KeepOuts") -> "KeepOuts":
        """Return these and those of others that are not among them."""
        return keep_outs_of([*self, *(volume for volume in others if volume not in tuple(self))])


def keep_outs_of(volumes: list[KeepOut]) -> KeepOuts:
    """Return volumes of any kind together."""
    return KeepOuts(
        tuple(volume for volume in volumes if isinstance(volume, Box)),
        tuple(volume for volume in volumes if isinstance(volume, Cylinder)),
        tuple(volume for volume in volumes if isinstance(volume, HalfSpace)),
    )
