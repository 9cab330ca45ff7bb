"""Tables of a recording: dataclasses whose fields are arrays of as many rows, or such tables again."""

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Self, TypeAlias

import numpy as np

from truepose_simulators.physics.effects.ports import NestNumbers

Chosen: TypeAlias = NestNumbers | slice


@dataclass(frozen=True, slots=True)
class Rows:
    """Base of such a table."""

    def __len__(self) -> int:
        return len(getattr(self, fields(self)[0].name))

    def part(self, rows: Chosen) -> Self:
        """Return some of the rows."""
        return type(self)(*(_chosen(getattr(self, field.name), rows) for field in fields(self)))

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the rows of several tables one below the other."""
        columns = ([getattr(part, field.name) for part in parts] for field in fields(cls))
        return cls(*(np.concatenate(column) for column in columns))


def _chosen(column: Any, rows: Chosen) -> Any:
    return column.part(rows) if isinstance(column, Rows) else column[rows]
