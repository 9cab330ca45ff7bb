"""Tables as a notebook has them, DataFrames or arrays, under the column names of the file format."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, Final, Protocol, TypeAlias

import numpy as np
import numpy.typing as npt

from truepose.domain.errors import ConfigurationError
from truepose.exchange.errors import BadValueError
from truepose.exchange.input_file import read_bytes
from truepose.exchange.tables.points import POSITION
from truepose.exchange.tables.table import Arrays, TableData

Column: TypeAlias = npt.NDArray[np.generic]


class Frame(Protocol):
    """A DataFrame of any library: it names its columns and gives each of them."""

    @property
    def columns(self) -> Any:
        """Names of the columns, in order."""

    def __getitem__(self, name: Any, /) -> Any:
        """Return one column, shape (n,)."""


Table: TypeAlias = Frame | Mapping[str, npt.ArrayLike] | npt.NDArray[np.void]
TableOrFile: TypeAlias = Table | Path | str

# Arrays of shape (n, J) or (n, 3) that stand for as many columns.
_BLOCKS: Final = {"joints_deg": "q{}_deg", "joints_rad": "q{}_rad", "dir": "dir{}", "tau_Nm": "tau{}_Nm"}
_POSITION: Final = "position_mm"


def named_data(given: TableOrFile, name: str) -> tuple[str, TableData]:
    """Return the name and the data of a table: those of a file where one is named.

    Raises
    ------
    InputFileError
        The file cannot be read, or what is given is no table.
    """
    if isinstance(given, str | Path):
        file = Path(given)
        return file.name, read_bytes(file)
    return name, columns_of(given, name)


def columns_of(table: Table, name: str) -> Arrays:
    """Return the columns of a table as the file format names them, in degrees where angles are in radians.

    Parameters
    ----------
    table : DataFrame, mapping of str to array, or structured array
        Columns of shape (n,), single values that hold for every row, and blocks: `joints_deg` or
        `joints_rad` of shape (n, J), `position_mm` (n, 3), `dir` (n, J), `tau_Nm` (n, J).
    name : str
        What errors call it.

    Raises
    ------
    ConfigurationError
        It is no table.
    BadValueError
        Columns of different lengths, a block of another shape, or a column that is there twice.
    """
    given = list(_given(table, name))
    n = next((len(values) for _, values in given if values.ndim), 1)
    columns: dict[str, Column] = {}
    for key, values in given:
        for column, entries in _spread(key, values, name):
            if column in columns:
                raise BadValueError("the column appears twice; keep one", file=name, column=column)
            columns[column] = _of_length(entries, n, name, column)
    return columns


def _given(table: Table, name: str) -> Iterator[tuple[str, Column]]:
    if isinstance(table, Mapping):
        yield from ((str(key), _array(values)) for key, values in table.items())
    elif isinstance(table, np.ndarray) and table.dtype.names:
        yield from ((key, table[key]) for key in table.dtype.names)
    elif hasattr(table, "columns"):
        _refuse_twice(table.columns, name)
        yield from ((str(key), _array(table[key])) for key in table.columns)
    else:
        raise ConfigurationError(
            f"{name}: a {type(table).__name__} is no table; give a DataFrame or a mapping of names to arrays."
        )


def _refuse_twice(names: Sequence[str], table: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise BadValueError("the column appears twice; keep one", file=table, column=str(name))
        seen.add(name)


def _array(values: npt.ArrayLike) -> Column:
    """Return values as an array: of numbers where all are, unknown ones as NaN."""
    try:
        return np.asarray(values, dtype=float)
    except (TypeError, ValueError):
        return np.asarray(values, dtype=object)


def _spread(key: str, values: Column, name: str) -> Iterator[tuple[str, Column]]:
    """Yield the columns that a key stands for, with their values."""
    if key == _POSITION or key in _BLOCKS:
        yield from _of_block(key, values, name)
    elif values.ndim > 1:
        raise BadValueError(
            f"the values have {values.ndim} dimensions; a column has one", file=name, column=key
        )
    else:
        yield _in_degrees(key, values)


def _of_block(key: str, values: Column, name: str) -> Iterator[tuple[str, Column]]:
    wanted = 3 if key == _POSITION else None
    if values.ndim != 2 or wanted not in {None, values.shape[1]}:
        shape = "(n, 3)" if wanted else "(n, joints)"
        raise BadValueError(f"the shape is {values.shape}; {shape} is required", file=name, column=key)
    for number, column in enumerate(values.T, start=1):
        own = POSITION[number - 1] if key == _POSITION else _BLOCKS[key].format(number)
        yield _in_degrees(own, column)


def _in_degrees(key: str, values: Column) -> tuple[str, Column]:
    """Return an angle of a joint in degrees where its name says radians; all else as it is."""
    joint = key.removeprefix("q").removesuffix("_rad")
    if key == f"q{joint}_rad" and joint.isdecimal() and values.dtype.kind == "f":
        return f"q{joint}_deg", np.degrees(values)
    return key, values


def _of_length(values: Column, n: int, name: str, column: str) -> Column:
    if values.ndim == 0:
        return np.full(n, values[()])
    if len(values) != n:
        raise BadValueError(
            f"{len(values)} values stand where other columns have {n}", file=name, column=column
        )
    return values
