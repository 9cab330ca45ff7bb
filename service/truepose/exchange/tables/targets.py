"""Tables of targets to correct, of any length, of what became of them, and of planned configurations."""

import math
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, TextIO

import numpy as np

from truepose.correction import ANY_BRANCH, FLANGE, Corrections, Goals
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.exchange.quantities import in_other_unit
from truepose.exchange.tables.fields import (
    ANGLE,
    Field,
    columns_of,
    joint_names,
    read_fields,
    stop_cells,
    stop_fields,
    table_text,
    torque_names,
)
from truepose.exchange.tables.points import (
    POSITION,
    POSITION_FIELD,
    QUATERNION,
    ignored_columns,
    in_files,
    unit_quaternions,
)
from truepose.exchange.tables.rows import read_text, written_text
from truepose.exchange.tables.table_reader import (
    WHOLE,
    Cells,
    Column,
    Table,
    TableData,
    TablePart,
    column_names,
    one_of,
    table_parts,
)
from truepose.kinematics.frames import rotation_from_quaternion
from truepose.kinematics.inverse import BRANCH_NAMES
from truepose.messages.message import Message
from truepose.planning.prediction.plan import BallbarPoses, PromisedPlan

# Rows are read some thousand at a time and none is kept, so that memory sets no limit here as it does
# elsewhere.
_MOST_ROWS: Final = 10_000_000
_NAME: Final = "target"
_BRANCH: Final = "branch"
_NUMBERS: Final = tuple(str(number) for number in range(len(BRANCH_NAMES)))
_NO_CELLS: Final[Mapping[str, Cells]] = {}
_OF_A_STOP: Final = ("direction", "torque_n_mm", "time_s", "temperature_c", "attachment")


@dataclass(frozen=True, slots=True)
class Targets:
    """Some rows of a table of targets."""

    names: tuple[str, ...]  # (n,) as they stood
    lines: IntArray  # (n,) where they stood, from 1; of arrays the rows, from 0
    stops: Stops  # with the joints that are given, NaN where none are
    poses: Goals | None  # in the frame that the table is meant in; None: its rows are joints only
    branch: IntArray  # (n,) asked for, ANY_BRANCH where nobody asks
    own: Mapping[str, Cells]  # every column as it stood
    ignored: tuple[Message, ...]  # one sentence for every column not understood
    share: float  # of the table that has been read with them, 0 to 1


def targets_of(
    name: str, data: TableData, n_joints: int, nests: Collection[int], most_rows: int = _MOST_ROWS
) -> Iterator[Targets]:
    """Yield targets some thousand at a time, numbered on from row to row.

    Parameters
    ----------
    name : str
        Of the table, for error messages.
    data : bytes or mapping of str to ndarray
        `target`, the position, the quaternion, and what else is known: joints, branch, nest, stop. Without
        any column of a pose the joints are what the controller itself would be sent to.
    n_joints : int
    nests : collection of int
        Numbers of the tool nests that the model knows.
    most_rows : int
        More are refused.

    Raises
    ------
    InputFileError
        With name, line or row, and column.
    """
    fields = _fields(n_joints, nests, posed=_has_poses(column_names(name, data), n_joints))
    together = [joint_names(n_joints), torque_names(n_joints)]
    columns = columns_of(fields)
    lines = data.count(b"\n") if isinstance(data, bytes) else 0
    first = 0
    for part in table_parts(name, data, columns, together=together, passed_over={_NAME}, most_rows=most_rows):
        first += len(part.table.lines)
        share = min(1.0, int(part.table.lines[-1]) / lines) if lines else 1.0
        yield _targets(part, n_joints, fields, first - len(part.table.lines), share)


def _has_poses(columns: Collection[str], n_joints: int) -> bool:
    """Whether a table has poses, or should: one without them has all joints, and nothing of a pose."""
    of_a_pose = any(name in columns or in_other_unit(name, columns) for name in (*POSITION, *QUATERNION))
    return of_a_pose or not set(joint_names(n_joints)).issubset(columns)


def _fields(n_joints: int, nests: Collection[int], *, posed: bool) -> list[Field]:
    branch = Column(_BRANCH, required=False, words=(*BRANCH_NAMES, *_NUMBERS), blank=ANY_BRANCH)
    blank = math.nan if posed else None
    joints = tuple(Column(name, required=False, blank=blank) for name in joint_names(n_joints))
    return [
        *(_pose_fields(nests) if posed else ()),
        Field("branch", branch),
        Field("joints_rad", joints, ANGLE, np.radians, np.degrees),
        *(field for field in stop_fields(n_joints) if field.name in _OF_A_STOP),
    ]


def _pose_fields(nests: Collection[int]) -> list[Field]:
    known = (WHOLE, one_of({FLANGE, *nests}, "the tool nests (0 is the flange)"))
    return [
        POSITION_FIELD,
        Field("quaternion", tuple(Column(name) for name in QUATERNION), ".9f"),
        Field("nest", Column("nest", required=False, rules=known, blank=FLANGE)),
    ]


def _targets(part: TablePart, n_joints: int, fields: Sequence[Field], first: int, share: float) -> Targets:
    table = part.table
    said, n = read_fields(table, fields), len(part.table.lines)
    _require_whole_rows(table, said["joints_rad"])
    branch, joints = said["branch"], said["joints_rad"]
    stops = Stops(
        np.arange(first, first + n),
        np.full((n, n_joints), np.nan) if joints is None else joints,
        **{name: said[name] for name in _OF_A_STOP},
    )
    return Targets(
        names=_names(part, first),
        lines=table.lines,
        stops=stops,
        poses=_poses(table, stops, said) if "position_mm" in said else None,
        own=part.cells,
        branch=np.full(n, ANY_BRANCH)
        if branch is None
        else np.where(branch < 0, branch, branch % len(BRANCH_NAMES)),
        share=share,
        ignored=tuple(in_files([table.file], clause) for clause in ignored_columns(table)),
    )


def _poses(table: Table, stops: Stops, said: Mapping[str, Any]) -> Goals:
    rotation = rotation_from_quaternion(unit_quaternions(table))
    nest = np.full(len(stops), FLANGE) if said["nest"] is None else said["nest"]
    return Goals(stops, nest, said["position_mm"], rotation)


def _require_whole_rows(table: Table, joints_rad: FloatArray | None) -> None:
    if joints_rad is not None:
        known = np.isfinite(joints_rad)
        table.require(
            np.asarray(known.all(axis=1) | ~known.any(axis=1)),
            joint_names(joints_rad.shape[1])[0],
            "some joints are given and some are empty: give all of them, or none",
        )


def _names(part: TablePart, first: int) -> tuple[str, ...]:
    """Return what targets are called: as they stand, else by their numbers from 1."""
    if _NAME in part.cells:
        return tuple(read_text(str(name).strip()) for name in part.cells[_NAME])
    return tuple(str(first + row) for row in range(1, len(part.table.lines) + 1))


def correction_cells(names: Sequence[str], found: Corrections) -> dict[str, list[str]]:
    """Return the cells of corrected targets by column."""
    joints = np.degrees(found.joints_rad)
    columns = zip(joint_names(joints.shape[1]), joints.T, strict=True)
    ok = found.solved
    return {
        _NAME: [_cell(name) for name in names],
        _BRANCH: ["" if number == ANY_BRANCH else BRANCH_NAMES[number] for number in found.branch.tolist()],
        **{name: _written(values, ".9f") for name, values in columns},
        "error_mm": _written(found.error_mm, ".6f"),
        "u_mm": _written(np.where(ok, found.uncertainty_mm, np.nan), ".6g"),
        "status": found.status.tolist(),
        "error_deg": _written(np.degrees(found.error_rad), ".8f"),
        "u_deg": _written(np.where(ok, np.degrees(found.uncertainty_rad), np.nan), ".6g"),
        "outside_mm": _written(found.outside_mm, ".3f"),
        "outside_deg": _written(np.degrees(found.outside_rad.max(axis=1)), ".4f"),
        "moved_deg": _written(np.where(ok, np.degrees(found.moved_rad), np.nan), ".4f"),
        "beyond_limit_deg": _written(np.degrees(found.beyond_limit_rad.max(axis=1)), ".4f"),
    }


def _written(values: FloatArray, form: str) -> list[str]:
    return [format(value, form) if np.isfinite(value) else "" for value in values.tolist()]


def _cell(text: str) -> str:
    """Return a text as a cell of CSV."""
    written = written_text(text)
    quoted = written.replace('"', '""')
    return f'"{quoted}"' if set(written) & set(',"\r\n') else written


class CorrectionWriter:
    """A table of corrected targets that grows part by part; a file's other columns stand behind."""

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream
        self._begun = False

    def write(self, names: Sequence[str], found: Corrections, own: Mapping[str, Cells] = _NO_CELLS) -> None:
        """Append rows in their order; of `own` columns those that the answer does not have."""
        cells = correction_cells(names, found)
        # The apostrophe that keeps a text from being a formula is taken off and put on again: else each pass
        # through this program would add one.
        kept = {
            _cell(read_text(name)): [_cell(read_text(str(cell))) for cell in column]
            for name, column in own.items()
            if name and name not in cells
        }
        text = table_text(cells | kept)
        self._stream.write(text.partition("\n")[2] if self._begun else text)
        self._begun = True


_NEST = Field("nest", Column("nest"))
_PLACEMENT = Field("placement", Column("placement"))


def write_plan(file: Path, plan: PromisedPlan) -> None:
    """Write `config, q1_deg..` and the `nest` that faces the tracker, or `placement, legs` of a ballbar.

    Stops of a closed loop say the `targets` that are read there as well.

    Configurations are numbered on from those that were measured.
    """
    if plan.poses is None and plan.targets is None:
        write_configurations(file, plan.joints_rad, plan.nest, plan.measured)
        return
    cells = _numbered(plan.joints_rad, plan.measured)
    cells |= _NEST.cells(plan.nest) if plan.poses is None else _pose_cells(plan.poses)
    if plan.targets is not None:
        cells["targets"] = [" ".join(map(str, own)) for own in plan.targets]
    file.write_text(table_text(cells), encoding="utf-8", newline="\n")


def write_configurations(
    file: Path, joints_rad: FloatArray, nest: IntArray | None, measured: int = 0
) -> None:
    """Write configurations (n, J) and the nest of each (n,), numbered on from those that were measured."""
    cells = _numbered(joints_rad, measured) | _NEST.cells(nest)
    file.write_text(table_text(cells), encoding="utf-8", newline="\n")


def _numbered(joints_rad: FloatArray, measured: int) -> dict[str, list[str]]:
    return stop_cells(Stops(measured + 1 + np.arange(len(joints_rad)), joints_rad))


def _pose_cells(poses: BallbarPoses) -> dict[str, list[str]]:
    legs = [" ".join(f"{base}-{nest}" for base, nest in own) for own in poses.legs]
    return {**_PLACEMENT.cells(poses.placement), "legs": legs}
