"""What tables hold, each described once: columns, arrays and cells; among them where the arm stood.

Digits: positions and lengths carry 1e-5 mm, a fiftieth of the best length instrument's noise (0.0005 mm);
angles 1e-9 deg, which moves the end of a 3 m arm by 5e-8 mm; torques 1e-6 N*m as robots report them.
Uncertainties carry eight significant digits, because a weight is relative. What was read from a file of
at most so many digits therefore comes back equal, and a second round trip changes nothing.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, TypeAlias

import numpy as np
import numpy.typing as npt

from truepose.domain.campaign import Stops
from truepose.exchange.tables.table_reader import WHOLE, Column, Table, at_least, between

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


NO_REPEAT = -1
# Controllers report 0.01 deg, and an arm may stop as far off its target; two configurations of a plan lie
# tens of degrees apart.
SAME_JOINTS_DEG = 0.5


def _n_mm(torque_n_m: Array) -> Array:
    return torque_n_m * 1000.0


def _n_m(torque_n_mm: Array) -> Array:
    return torque_n_mm * 1e-3


def joint_names(n_joints: int) -> list[str]:
    """Return `q1_deg` to `qn_deg`."""
    return [f"q{joint}_deg" for joint in range(1, n_joints + 1)]


def torque_names(n_joints: int) -> list[str]:
    """Return `tau1_Nm` to `taun_Nm`."""
    return [f"tau{joint}_Nm" for joint in range(1, n_joints + 1)]


def direction_names(n_joints: int) -> list[str]:
    """Return `dir1` to `dirn`."""
    return [f"dir{joint}" for joint in range(1, n_joints + 1)]


def stop_fields(n_joints: int) -> list[Field]:
    """Return what is known of a stop; an empty cell stands for unknown where that makes sense."""
    signs = (WHOLE, between(-1, 1))
    directions = [Column(n, required=False, rules=signs, blank=0.0) for n in direction_names(n_joints)]
    torques = [Column(name, required=False, blank=math.nan) for name in torque_names(n_joints)]
    earlier = Column("repeat_of", required=False, rules=(WHOLE, at_least(NO_REPEAT)), blank=NO_REPEAT)
    return [
        Field("config", Column("config", rules=(WHOLE, at_least(0)))),
        joint_field(n_joints),
        Field("direction", tuple(directions)),
        Field("torque_n_mm", tuple(torques), ".6f", _n_mm, _n_m),
        Field("time_s", Column("time_s", required=False, blank=math.nan), TIME),
        Field("temperature_c", Column("temperature_C", required=False, blank=math.nan), TEMPERATURE),
        Field("attachment", Column("attachment", required=False, rules=(WHOLE,))),
        Field("group", Column("group", required=False, rules=(WHOLE,))),
        Field("repeat_of", earlier, empty=NO_REPEAT),
    ]


def joint_field(n_joints: int) -> Field:
    """Return the angles of the joints."""
    columns = tuple(Column(name) for name in joint_names(n_joints))
    return Field("joints_rad", columns, ANGLE, np.radians, np.degrees)


def stop_cells(stops: Stops) -> Cells:
    """Return the cells of stops."""
    return written_fields(stops, stop_fields(stops.joints_rad.shape[1]))


def read_stops_of(table: Table, n_joints: int, *, numbered_by: Sequence[str] = ()) -> Stops:
    """Return the stops of a measured table read with `stop_fields`; a number is one place of the arm.

    Raises BadValueError where it is two. `numbered_by` names the columns that number their stops apart.
    """
    _require_one_place_each(table, ("config", *numbered_by), joint_names(n_joints))
    return stops_to_visit(table, n_joints)


def stops_to_visit(table: Table, n_joints: int) -> Stops:
    """Return the stops of a table whose numbers are nothing but names of its rows."""
    return Stops(**read_fields(table, stop_fields(n_joints)))


def _require_one_place_each(table: Table, number: Sequence[str], joints: Sequence[str]) -> None:
    """Refuse two places of the arm under one number: their readings would share what one stop shares."""
    _, first, which = np.unique(table.block(number), axis=0, return_index=True, return_inverse=True)
    earlier = first[which.reshape(-1)]
    joints_deg = table.block(joints)
    away_deg = np.abs(joints_deg - joints_deg[earlier])
    row = int(np.argmax(away_deg.max(axis=1) > SAME_JOINTS_DEG))
    joint = int(np.argmax(away_deg[row]))
    table.require(
        away_deg.max(axis=1) <= SAME_JOINTS_DEG,
        number[0],
        f"configuration {table.whole(number[0])[row]} is on {table.counted} {table.lines[earlier[row]]} "
        f"with other joints ({joints[joint]} differs by {away_deg[row, joint]:.4g}); "
        "give each set of joints its own number",
    )
