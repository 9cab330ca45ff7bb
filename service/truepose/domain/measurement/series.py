"""A series: readings that a program of one's own delivers as they come, each row numbered from 1."""

from dataclasses import dataclass
from typing import TypeAlias

Values: TypeAlias = tuple[float | None, ...]  # of one reading, a column each; None: it was not read


@dataclass(frozen=True, slots=True)
class Series:
    """What a program delivers: its columns are named as in the table that it would otherwise write."""

    name: str
    columns: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Delivery:
    """Some readings of a series, in one piece; `first` is the number of the first of them."""

    first: int
    readings: tuple[Values, ...]

    @property
    def next_number(self) -> int:
        """The number of the reading that follows."""
        return self.first + len(self.readings)
