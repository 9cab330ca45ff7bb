"""Tables on their own, outside a campaign: points to predict, readings to validate, visits."""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Readings, Stops, each_nest
from truepose.domain.contacts import Target
from truepose.exchange.document import read_bytes
from truepose.exchange.errors import BadValueError, MissingEntryError
from truepose.exchange.tables.ballbar import leg_columns, read_leg_table
from truepose.exchange.tables.contacts import contact_columns, read_contact_table
from truepose.exchange.tables.fields import (
    LENGTH,
    Field,
    columns_of,
    stop_fields,
    stops_to_visit,
    table_text,
    torque_names,
)
from truepose.exchange.tables.points import (
    POSITION_FIELD,
    ignored_columns,
    in_files,
    point_columns,
    read_point_table,
)
from truepose.exchange.tables.rows import MOST_ROWS, Numbered, numbered_rows, parts, read_header
from truepose.exchange.tables.table_reader import WHOLE, Column, TableData, column_names, one_of, read_table
from truepose.messages.message import Message

_COLUMNS: Final = ("campaign", "robot", "instrument", "day")


@dataclass(frozen=True, slots=True)
class Stated:
    """Which robot was measured, by what and on which day; empty or None: nobody said."""

    robot: str = ""
    instrument: str = ""
    day: date | None = None

    def or_else(self, other: "Stated") -> "Stated":
        """Return this, and of `other` what this does not say."""
        return Stated(self.robot or other.robot, self.instrument or other.instrument, self.day or other.day)


NOT_STATED: Final = Stated()


def read_visits(file: Path) -> Mapping[str, Stated]:
    """Read `campaign, robot, instrument, day`; an empty cell says nothing.

    Raises
    ------
    InputFileError
        A column is missing, a day is none, or a campaign appears in two rows.
    """
    return visits_from(file.name, read_bytes(file))


def visits_from(name: str, data: bytes) -> Mapping[str, Stated]:
    """Read the content of a table called `name`; raises as `read_visits`."""
    found: dict[str, Stated] = {}
    # Of two rows nobody can say which one counts.
    for line, campaign, stated in _rows(name, numbered_rows(name, data)):
        if campaign in found:
            raise BadValueError(f"{campaign!r} appears in two rows", file=name, line=line, column="campaign")
        found[campaign] = stated
    return found


def _rows(name: str, numbered: Iterator[Numbered]) -> Iterator[tuple[int, str, Stated]]:
    header_line, header = read_header(name, numbered)
    for column in _COLUMNS:
        if column not in header:
            raise MissingEntryError(
                f"column {column} is missing; it is required", file=name, line=header_line
            )
    for part in parts(name, header, numbered, MOST_ROWS):
        for line, row in part:
            cells = dict(zip(header, (cell.strip() for cell in row), strict=True))
            stated = Stated(cells["robot"], cells["instrument"], _day(name, line, cells["day"]))
            yield line, cells["campaign"], stated


def _day(name: str, line: int, text: str) -> date | None:
    try:
        return date.fromisoformat(text) if text else None
    except ValueError as error:
        raise BadValueError(
            f"{text!r} is not a date; write it as YYYY-MM-DD, such as 2026-03-03",
            file=name,
            line=line,
            column="day",
        ) from error


_PREDICTED = (
    Field("config", Column("config")),
    Field("nest", Column("nest")),
    POSITION_FIELD,
    Field("standard_uncertainty_mm", Column("u_mm"), LENGTH),
)


@dataclass(frozen=True, slots=True)
class PointsToPredict:
    """Rows of a table for `predict`; without a `nest` column every known nest is wanted at every row."""

    stops: Stops
    nest: IntArray | None  # (n,)
    ignored: tuple[Message, ...]  # one sentence for every column not understood

    def of_each_nest(self, known: Sequence[int]) -> tuple[Stops, IntArray]:
        """Return the stop and the nest of every prediction that is wanted, in the order of the rows."""
        return each_nest(self.stops, np.array(known)) if self.nest is None else (self.stops, self.nest)


@dataclass(frozen=True, slots=True)
class ValidationFile:
    """Readings of a table for `validate`."""

    readings: Readings
    ignored: tuple[Message, ...]


def points_to_predict(name: str, data: TableData, n_joints: int, nests: Collection[int]) -> PointsToPredict:
    """Read `config`, the joints and what else is known of each stop; measured values do not matter.

    Parameters
    ----------
    name : str
        Of the table, for error messages.
    data : bytes or mapping of str to ndarray
        Text of a CSV file, or columns of shape (n,).
    n_joints : int
        Joints of the model's robot.
    nests : collection of int
        Numbers of the tool nests that the model knows.

    Raises
    ------
    InputFileError
        With name, line or row, and column.
    """
    columns = [
        *columns_of(stop_fields(n_joints)),
        Column("nest", required=False, rules=(WHOLE, one_of(nests, "the known nests"))),
    ]
    measured = [
        column
        for columns in (point_columns, leg_columns, contact_columns)
        for column in columns(n_joints, nests)
    ]
    table = read_table(
        name,
        data,
        columns,
        together=[torque_names(n_joints)],
        passed_over={column.name for column in measured},
    )
    return PointsToPredict(
        stops=stops_to_visit(table, n_joints),
        nest=table.optional_whole("nest"),
        ignored=_sentences(name, ignored_columns(table)),
    )


def held_out_readings(
    name: str, data: TableData, n_joints: int, nests: Collection[int], targets: Sequence[Target] = ()
) -> ValidationFile:
    """Read points, legs or contacts, whichever the columns announce, as in a campaign; parameters as above.

    `targets` are those that the model knows.

    Raises
    ------
    InputFileError
        With name, line or row, and column; also where uncertainties along and across the beam are given
        without a covariance: the place of the tracker is not known here.
    """
    names = column_names(name, data)
    if "length_mm" in names and "x_mm" not in names:
        legs, ignored = read_leg_table(name, data, n_joints, nests)
        return ValidationFile(legs, _sentences(name, ignored))
    if "reading_mm" in names and "x_mm" not in names:
        contacts, ignored = read_contact_table(name, data, n_joints, nests, targets)
        return ValidationFile(contacts, _sentences(name, ignored))
    points, ignored = read_point_table(name, data, n_joints, nests, None)
    return ValidationFile(points, _sentences(name, ignored))


def write_predictions(
    file: Path,
    config: IntArray,
    nest: IntArray,
    position_mm: FloatArray,
    standard_uncertainty_mm: FloatArray,
) -> None:
    """Write predicted points in the order given; shapes (n,), (n,), (n, 3), (n,)."""
    arrays = (config, nest, position_mm, standard_uncertainty_mm)
    cells = [field.cells(values) for field, values in zip(_PREDICTED, arrays, strict=True)]
    text = table_text({name: column for columns in cells for name, column in columns.items()})
    file.write_text(text, encoding="utf-8", newline="\n")


def _sentences(name: str, clauses: tuple[Message, ...]) -> tuple[Message, ...]:
    return tuple(in_files([name], clause) for clause in clauses)
