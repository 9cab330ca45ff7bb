"""What tables hold, each described once: its columns, the array that they are, how cells are written.

Digits: positions and lengths carry 1e-5 mm, a fiftieth of the best length instrument's noise (0.0005 mm);
angles 1e-9 deg, which moves the end of a 3 m arm by 5e-8 mm; torques 1e-6 N*m as robots report them.
Uncertainties carry eight significant digits, because a weight is relative. What was read from a file of
at most so many digits therefore comes back equal, and a second round trip changes nothing.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from truepose.exchange.tables.table import Column, Table

WHOLE_NUMBER: Final = "d"
ANGLE: Final = ".9f"
LENGTH: Final = ".5f"
UNCERTAINTY: Final = ".8g"
TIME: Final = ".4f"
TEMPERATURE: Final = ".4f"
Array: TypeAlias = npt.NDArray[Any]
Cells: TypeAlias = dict[str, list[str]]  # of columns by name


def _as_it_is(values: Array) -> Array:
    return values


@dataclass(frozen=True, slots=True)
class Field:
    """An array of the domain and its column, or its columns side by side."""

    name: str  # of the array: a field of the dataclass that holds the table
    columns: Column | tuple[Column, ...]
    form: str = WHOLE_NUMBER  # of a cell
    inward: Callable[[Array], Array] = _as_it_is  # from the unit of the file to that of the domain
    outward: Callable[[Array], Array] = _as_it_is
    empty: float | None = None  # what is written as an empty cell, besides NaN

    @property
    def all_columns(self) -> tuple[Column, ...]:
        """The columns, be it one."""
        return self.columns if isinstance(self.columns, tuple) else (self.columns,)

    def read(self, table: Table) -> Array | None:
        """Return the array, shape (n,) or (n, columns); None where no column is there."""
        if not any(column.name in table for column in self.all_columns):
            return None
        blank = np.zeros(len(table.lines))
        values = [table.values.get(column.name, blank) for column in self.all_columns]
        block = np.column_stack(values) if isinstance(self.columns, tuple) else values[0]
        return self.inward(block.astype(np.int64) if self.form == WHOLE_NUMBER else block)

    def cells(self, values: Array | None) -> Cells:
        """Return the cells of an array; no columns for None."""
        if values is None:
            return {}
        columns = self.outward(values).reshape(len(values), -1).T
        return {
            column.name: self._written(entries.tolist())
            for column, entries in zip(self.all_columns, columns, strict=True)
        }

    def _written(self, values: list[Any]) -> list[str]:
        form, empty = self.form, self.empty
        return ["" if value != value or value == empty else format(value, form) for value in values]


def columns_of(fields: Sequence[Field]) -> list[Column]:
    """Return the columns of fields, in order."""
    return [column for field in fields for column in field.all_columns]


def read_fields(table: Table, fields: Sequence[Field]) -> dict[str, Any]:
    """Return the arrays of fields by name."""
    return {field.name: field.read(table) for field in fields}


def written_fields(value: object, fields: Sequence[Field]) -> Cells:
    """Return the cells of the arrays that `value` has under the names of fields."""
    return {
        name: cells for field in fields for name, cells in field.cells(getattr(value, field.name)).items()
    }


def table_text(columns: Mapping[str, Sequence[str]]) -> str:
    """Return CSV text of columns of equal length, in their order."""
    rows = zip(*columns.values(), strict=True)
    return "\n".join([",".join(columns), *map(",".join, rows), ""])
