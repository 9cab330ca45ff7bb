"""Points put beside the joint angles at which they were read: a campaign of them, and a folder to watch.

In the folder campaign folders and zips are taken as they are; a list of points `NAME.txt` with its joints
`NAME.joints.csv`, where `import.toml` in the folder states the rest.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign
from truepose.domain.errors import ConfigurationError
from truepose.exchange.campaigns.description import unknown_nests
from truepose.exchange.campaigns.folder import DESCRIPTION, campaign_from_arrays
from truepose.exchange.campaigns.point_list import UNITS_MM, NamedPoint, Vector, read_point_list
from truepose.exchange.campaigns.zip_file import read_campaign_at
from truepose.exchange.document import (
    NUMBER,
    TEXT,
    VECTOR,
    Form,
    Key,
    Node,
    each,
    file_document,
    read_bytes,
    read_keys,
)
from truepose.exchange.errors import BadValueError, InputFileError, MissingEntryError
from truepose.exchange.robots.named import campaign_keys, named_robot
from truepose.exchange.tables.rows import MOST_ROWS, numbered_rows, parts, read_header
from truepose.exchange.tables.table_reader import is_number, shown

_POINT: Final = "point"  # column of names in the table of joints
AT_THE_END: Final = "*{config}"
_FIELDS: Final = ("config", "nest")

RowKey = tuple[str, ...]


@dataclass(frozen=True, slots=True)
class JoinedTable:
    """The columns of a campaign's table, and what found no other half."""

    columns: Mapping[str, FloatArray]  # (n,) each, by the names of the file format
    lines: tuple[int, ...]  # (n,) of the table of joints
    points_alone: tuple[str, ...]  # names of points that belong to no row
    rows_alone: tuple[int, ...]  # lines of the table that have no point

    def __len__(self) -> int:
        return len(self.columns["u_mm"])

    def ones(self) -> FloatArray:
        """Return 1 for each reading, shape (n,): the only nest where none is named."""
        return np.ones(len(self))


@dataclass(frozen=True, slots=True)
class _Row:
    line: int
    cells: Mapping[str, str]

    def key(self, by: RowKey) -> RowKey:
        return tuple(_plain(self.cells[column].strip()) for column in by)


Pairs = Sequence[tuple[_Row, NamedPoint]]


def join_tables(
    points: Sequence[NamedPoint],
    file: str,
    data: bytes,
    *,
    names: str = AT_THE_END,
    u_mm: float | None = None,
) -> JoinedTable:
    """Put points beside the rows of a table of joints.

    Parameters
    ----------
    points : sequence of NamedPoint
    file, data
        The table of joints, CSV: columns of the file format without positions (`config`, `q1_deg`.., perhaps
        `nest` and what else is known of a stop), and `point` where it says the names of the points.
    names : str
        How names say the configuration, and perhaps the nest: `{config}` and `{nest}` among other characters,
        `*` for any. Not asked where the table has `point`.
    u_mm : float, optional
        Standard uncertainty per axis where the list has none.

    Raises
    ------
    InputFileError
        The table cannot be read, nothing belongs together, or nothing says how uncertain points are.
    ConfigurationError
        `names` has no `{config}`.
    """
    numbered = numbered_rows(file, data)
    header_line, header = read_header(file, numbered)
    by = (_POINT,) if _POINT in header else _fields(names)
    _require_columns(file, header_line, header, by)
    table = [
        _Row(line, dict(zip(header, cells, strict=True)))
        for part in parts(file, header, numbered, MOST_ROWS)
        for line, cells in part
    ]
    found = {_key(point, by, names): point for point in points}
    pairs = [(row, found[row.key(by)]) for row in table if row.key(by) in found]
    if not pairs:
        raise MissingEntryError(_nothing_fits(points, table, by), file=file)
    taken, used = {row.line for row, _ in pairs}, {point.name for _, point in pairs}
    numbers = [name for name in header if name != _POINT]
    return JoinedTable(
        {**_given(file, numbers, pairs), **_measured(file, pairs, u_mm)},
        tuple(row.line for row, _ in pairs),
        tuple(point.name for point in points if point.name not in used),
        tuple(row.line for row in table if row.line not in taken),
    )


def _fields(names: str) -> RowKey:
    if "{config}" not in names:
        raise ConfigurationError(f"{names!r} does not show where {{config}} is in a point's name.")
    return tuple(field for field in _FIELDS if f"{{{field}}}" in names)


def _require_columns(file: str, line: int, header: Sequence[str], by: RowKey) -> None:
    for column in by:
        if column not in header:
            raise MissingEntryError(
                f"column {column} is required: it says which point belongs to which row",
                file=file,
                line=line,
            )


def _key(point: NamedPoint, by: RowKey, names: str) -> RowKey:
    """Return what a point's name says of its row; nothing where it does not look as stated."""
    if by == (_POINT,):
        return (_plain(point.name),)
    match = re.fullmatch(_pattern(names), point.name)
    return () if match is None else tuple(_plain(match[field]) for field in by)


def _pattern(names: str) -> str:
    pattern = re.escape(names).replace(r"\*", ".*?")
    for field in _FIELDS:
        pattern = pattern.replace(rf"\{{{field}\}}", rf"(?P<{field}>[0-9]+)", 1)
    return pattern


def _plain(word: str) -> str:
    """Return a whole number without the zeros before it, and words as they are."""
    return (word.lstrip("0") or "0") if word.isascii() and word.isdecimal() else word


def _given(
    file: str, names: Sequence[str], pairs: Sequence[tuple[_Row, NamedPoint]]
) -> dict[str, FloatArray]:
    return {name: np.array([_number(file, row, name) for row, _ in pairs]) for name in names}


def _number(file: str, row: _Row, name: str) -> float:
    cell = row.cells.get(name, "").strip()
    if not cell:
        return float("nan")  # an empty cell, which the format's own reader judges
    if not is_number(cell):
        raise BadValueError(f"{shown(cell)} is not a number", file=file, line=row.line, column=name)
    return float(cell)


def _measured(file: str, pairs: Pairs, u_mm: float | None) -> dict[str, FloatArray]:
    """Return positions and their uncertainty; of three standard uncertainties the root mean square counts."""
    places = np.array([point.position_mm for _, point in pairs])
    spread = [point.uncertainty_mm for _, point in pairs]
    if u_mm is None and None in spread:
        raise MissingEntryError(
            "the points have no uncertainties; specify one for all of them (--u-mm)",
            file=file,
        )
    own = [np.full(3, u_mm) if one is None or u_mm is not None else np.array(one) for one in spread]
    return {
        **{f"{axis}_mm": places[:, number] for number, axis in enumerate("xyz")},
        "u_mm": np.sqrt(np.mean(np.square(own), axis=1)),
    }


def _nothing_fits(points: Sequence[NamedPoint], table: Sequence[_Row], by: RowKey) -> str:
    names = ", ".join(shown(point.name) for point in points[:3])
    rows = ", ".join(" ".join(row.key(by))[:30] for row in table[:3])
    return f"no point matches a row: points are called {names}, rows have {' and '.join(by)} {rows}"


STATED: Final = "import.toml"  # where a folder of lists states it


@dataclass(frozen=True, slots=True)
class Stated:
    """What neither file says."""

    robot: str  # shipped name, or a file
    unit: str | None = None  # of the points, a key of UNITS_MM; None: the list says it
    u_mm: float | None = None  # standard uncertainty per axis; None: the list says it
    names: str = AT_THE_END
    nests_mm: Sequence[Vector] = ()  # centres in the flange frame; none: they are found
    nest_u_mm: float | None = None


def import_points(points: Path, joints: Path, stated: Stated) -> tuple[Campaign, JoinedTable]:
    """Return the campaign, and what belongs to nothing; raises InputFileError, UnknownRobotError."""
    listed = read_point_list(points.name, read_bytes(points), stated.unit)
    found = join_tables(listed, joints.name, read_bytes(joints), names=stated.names, u_mm=stated.u_mm)
    described = {
        **campaign_keys(named_robot(stated.robot)),
        "tool_nests_mm": [list(centre) for centre in stated.nests_mm]
        or unknown_nests([found.columns.get("nest", found.ones())]),
        "tool_nest_u_mm": stated.nest_u_mm,
        "base_in_world_nominal": None,
    }
    tables = {"calibration": {"nest": found.ones(), **found.columns}}
    try:
        return campaign_from_arrays(described, tables), found
    except InputFileError as error:
        if error.row is None:
            raise
        line = found.lines[error.row]
        raise type(error)(error.sentence, file=joints.name, line=line, column=error.column) from error


def _unit(node: Node) -> str:
    if node.text() not in UNITS_MM:
        node.fail(f"must be one of {', '.join(UNITS_MM)}")
    return node.text()


_KEYS: Final = (
    Key("robot", "robot", TEXT),
    Key("unit", "unit", Form(_unit), absent=None),
    Key("u_mm", "u_mm", NUMBER, absent=None),
    Key("names", "names", TEXT, absent=AT_THE_END),
    Key("nests_mm", "nests_mm", each(VECTOR), absent=()),
    Key("nest_u_mm", "nest_u_mm", NUMBER, absent=None),
)


def read_stated(file: Path) -> Stated:
    """Read `import.toml`; a robot's file is looked for beside it. Raises InputFileError."""
    root, known = file_document(file), sorted(key.name for key in _KEYS)
    for unknown in root.unlisted(known):
        unknown.fail(f"the keys are {', '.join(known)}")
    stated = Stated(**read_keys(root, _KEYS))
    beside = file.parent / stated.robot
    return replace(stated, robot=str(beside)) if beside.is_file() else stated


_LISTS: Final = frozenset({".txt", ".asc", ".pts", ".csv"})
_JOINTS: Final = ".joints.csv"


@dataclass(frozen=True, slots=True)
class Arrival:
    """Something that lies in the folder; another state of it is another arrival."""

    name: str
    files: tuple[Path, ...]
    states: tuple[tuple[int, int], ...]  # size and time of change [ns] of each

    def read(self) -> Campaign:
        """Return the campaign; raises InputFileError, UnknownRobotError."""
        first, *rest = self.files
        if not rest:
            return read_campaign_at(first)
        return import_points(first, rest[0], read_stated(first.parent / STATED))[0]


def arrivals(folder: Path) -> Iterator[Arrival]:
    """Yield what lies in a folder, by name; what vanishes meanwhile is passed over."""
    for path in sorted(folder.iterdir()):
        try:
            yield from _arrived(path)
        except FileNotFoundError:
            continue


def _arrived(path: Path) -> Iterator[Arrival]:
    joints = path.with_name(path.stem + _JOINTS)
    if path.is_dir() and (path / DESCRIPTION).is_file():
        inside = sorted(file for file in path.iterdir() if file.is_file())
        yield Arrival(path.name, (path,), tuple(map(_state, inside)))
    elif path.suffix.lower() == ".zip":
        yield Arrival(path.stem, (path,), (_state(path),))
    elif path.suffix.lower() in _LISTS and not path.name.endswith(_JOINTS) and joints.is_file():
        yield Arrival(path.stem, (path, joints), (_state(path), _state(joints)))


def _state(file: Path) -> tuple[int, int]:
    found = file.stat()
    return found.st_size, found.st_mtime_ns
