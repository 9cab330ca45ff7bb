"""What a notebook gives: files, tables, arrays, and the robot they are of."""

import csv
import functools
import io
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, Final, ParamSpec, Protocol, TypeAlias, TypeVar

import numpy as np
import numpy.typing as npt

from truepose.domain.campaign import Campaign
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import Robot
from truepose.exchange.document import read_bytes
from truepose.exchange.errors import BadValueError
from truepose.exchange.import_wizard.single_table import SingleTable, single_table
from truepose.exchange.robots.named import campaign_keys, named_robot, without_masses
from truepose.exchange.tables.points import POSITION
from truepose.exchange.tables.table_reader import Arrays, TableData
from truepose.messages.message import Text

P = ParamSpec("P")
T = TypeVar("T")
Progress: TypeAlias = Callable[[float, Text], None]


def on_one_thread(compute: Callable[P, T]) -> Callable[P, T]:
    """Return what computes the same with linear algebra on one thread, and leaves the threads as they were.

    The answer has the bits of a command's and of a service's then, and is there sooner: matrices are too
    small for threads, which wait for each other (decision 0086).
    """

    @functools.wraps(compute)
    def computed(*args: P.args, **kwargs: P.kwargs) -> T:
        from threadpoolctl import threadpool_limits

        with threadpool_limits(limits=1, user_api="blas"):
            return compute(*args, **kwargs)

    return computed


def read_if_path(given: T | str | Path, kind: type[T], read: Callable[[str | Path], T], advice: str) -> T:
    """Return what is given, read first where it is a path.

    Raises
    ------
    ConfigurationError
        It is neither; the sentence says what is given and ends with `advice`.
    """
    if isinstance(given, str | Path):
        return read(given)
    if isinstance(given, kind):
        return given
    raise ConfigurationError(_refusal(given, kind.__name__.lower(), advice))


def path_of(given: str | Path, what: str, advice: str) -> Path:
    """Return a path; raises ConfigurationError where what is given names no file."""
    if isinstance(given, str | Path):
        return Path(given)
    raise ConfigurationError(_refusal(given, what, advice))


def effects_given(given: Sequence[str] | None) -> tuple[str, ...] | None:
    """Return the names of effects; a single one may stand without a list."""
    return (given,) if isinstance(given, str) else None if given is None else tuple(given)


def _refusal(given: object, what: str, advice: str) -> str:
    name = type(given).__name__
    return f"{'An' if name[0] in 'AEIOUaeiou' else 'A'} {name} is not a {what}: {advice}."


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
_FIRST_JOINT: Final = "q1_deg"


def named_data(given: TableOrFile, name: str) -> tuple[str, TableData]:
    """Return the name and the data of a table: those of a file where one is named.

    Raises
    ------
    InputFileError
        The file cannot be read, or what is given is not a table.
    """
    if isinstance(given, str | Path):
        file = Path(given)
        return file.name, read_bytes(file)
    return name, columns_of(given, name)


def readings_given(given: TableOrFile, name: str) -> SingleTable:
    """Return measured rows or stops: in the file format, or as any program calls its columns.

    Raises
    ------
    InputFileError
        The file cannot be read, or holds what nobody can have meant.
    ConfigurationError
        What is given is not a table.
    """
    if isinstance(given, str | Path):
        return single_table(Path(given).name, read_bytes(Path(given)))
    columns = columns_of(given, name)
    if _FIRST_JOINT in columns:
        return SingleTable(name, columns)
    found = single_table(name, _text(columns))
    return SingleTable(name, columns) if found.imported is None else found


def _text(columns: Arrays) -> bytes:
    """Return columns as the text of a CSV file, what is not known as an empty cell."""
    file = io.StringIO()
    cells = [
        ["" if value is None or value != value else value for value in column.tolist()]
        for column in columns.values()
    ]
    csv.writer(file).writerows([columns, *zip(*cells, strict=True)])
    return file.getvalue().encode()


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
        It is not a table.
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
            f"{name}: a {type(table).__name__} is not a table; give a DataFrame or a mapping of names to "
            "arrays."
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
            f"the values have {values.ndim} dimensions; a column must have one", file=name, column=key
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
            f"the column has length {len(values)}; other columns have length {n}", file=name, column=column
        )
    return values


RobotGiven: TypeAlias = str | Path | Table | Sequence[Mapping[str, float]]

_ANGLES = ("alpha", "theta_offset", "beta")


def known_robot(given: RobotGiven) -> Robot | None:
    """Return a shipped robot or that of a file, None where `given` is a table.

    Raises
    ------
    UnknownRobotError, InputFileError
        No shipped robot has that name; the file cannot be used.
    """
    return named_robot(given) if isinstance(given, str | Path) else None


def robot_keys(given: RobotGiven, robot: Robot | None) -> dict[str, object]:
    """Return the keys of `campaign.json` that describe the robot."""
    if robot is None:
        return without_masses() | {"robot": "robot of a table", "dhm_nominal": _rows(given)}
    return campaign_keys(robot)


def with_limits_of(campaign: Campaign, robot: Robot | None) -> Campaign:
    """Return the campaign whose robot also has what the file format of a campaign cannot hold."""
    if robot is None:
        return campaign
    more = {
        name: getattr(robot, name)
        for name in ("calibration_ranges", "joint_limits", "rated_payload_kg", "source")
    }
    return replace(campaign, robot=replace(campaign.robot, **more))


def _rows(given: Any) -> list[dict[str, object]]:
    """Return the rows of a Denavit-Hartenberg table, numbered where they are not."""
    if isinstance(given, Sequence):
        rows = [dict(row) for row in given]
    else:
        columns = columns_of(given, "robot")
        n = max(map(len, columns.values()), default=0)
        rows = [{name: values[k].item() for name, values in columns.items()} for k in range(n)]
    return [{"joint": number, **_row_in_degrees(row)} for number, row in enumerate(rows, start=1)]


def _row_in_degrees(row: Mapping[str, object]) -> dict[str, object]:
    turned = {f"{angle}_rad": f"{angle}_deg" for angle in _ANGLES}
    return {
        turned.get(name, name): float(np.degrees(value))
        if name in turned and isinstance(value, float | int)
        else value
        for name, value in row.items()
    }
