"""Array types used across the numerics, and tables of them.

A table is a frozen dataclass of columns that have one row for each of n things; taking rows of it takes them
of every column.
"""

from dataclasses import dataclass, fields, replace
from typing import Any, Self, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

# Written out: `npt.NDArray` is an opaque alias since numpy 2.5, and type hints are read at run time.
FloatArray: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[np.float64]]
IntArray: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[np.int64]]
BoolArray: TypeAlias = np.ndarray[tuple[Any, ...], np.dtype[np.bool_]]
Scalar = TypeVar("Scalar", bound=np.generic)


def distinct_values(values: npt.NDArray[Scalar], axis: int | None = None) -> npt.NDArray[Scalar]:
    """Return the distinct values in order; of rows with `axis` 0.

    As `np.unique`, which without counts loads the masked arrays: a fiftieth of a command's time.

    Parameters
    ----------
    values : ndarray
    axis : int, optional
        None: of all entries.

    Returns
    -------
    ndarray
        Of the same type, ascending.
    """
    values_in_order: npt.NDArray[Scalar] = np.unique(values, axis=axis, return_counts=True)[0]
    return values_in_order


@dataclass(frozen=True, slots=True)
class Table:
    """Columns of n rows, some of them tables themselves; what is no column is of all rows."""

    def taken(self, rows: IntArray) -> Self:
        """Return some rows.

        Parameters
        ----------
        rows : ndarray of int, shape (m,)
            Indices, in any order; one may come more than once.
        """
        columns = {field.name: _taken(getattr(self, field.name), rows) for field in fields(self)}
        return replace(self, **columns)


def _taken(column: object, rows: IntArray) -> object:
    # A table among the columns has the same rows, and no array that could be indexed by itself.
    if isinstance(column, Table):
        return column.taken(rows)
    return column[rows] if isinstance(column, np.ndarray) else column
