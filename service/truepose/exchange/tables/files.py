"""Tables on their own, outside a campaign: points to predict, points or legs to validate, predictions."""

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import Readings, Stops
from truepose.domain.measurement.targets import Target
from truepose.domain.sentences import Sentence
from truepose.exchange.input_file import read_bytes
from truepose.exchange.tables.contacts import contact_columns, read_contact_table
from truepose.exchange.tables.fields import LENGTH, Field, columns_of, table_text
from truepose.exchange.tables.legs import leg_columns, read_leg_table
from truepose.exchange.tables.points import (
    POSITION_FIELD,
    ignored_columns,
    in_files,
    point_columns,
    read_point_table,
)
from truepose.exchange.tables.stops import stop_fields, stops_to_visit, torque_names
from truepose.exchange.tables.table import WHOLE, Column, TableData, column_names, one_of, read_table
from truepose.identification.model.stops import each_nest

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
    ignored: tuple[Sentence, ...]  # one sentence for every column not understood

    def of_each_nest(self, known: Sequence[int]) -> tuple[Stops, IntArray]:
        """Return the stop and the nest of every prediction that is wanted, in the order of the rows."""
        return each_nest(self.stops, np.array(known)) if self.nest is None else (self.stops, self.nest)


@dataclass(frozen=True, slots=True)
class ValidationFile:
    """Readings of a table for `validate`."""

    readings: Readings
    ignored: tuple[Sentence, ...]


def read_points_to_predict(file: Path, n_joints: int, nests: Collection[int]) -> PointsToPredict:
    """Read the file of a table as `points_to_predict` does; raises InputFileError."""
    return points_to_predict(file.name, read_bytes(file), n_joints, nests)


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


def read_validation_file(
    file: Path, n_joints: int, nests: Collection[int], targets: Sequence[Target] = ()
) -> ValidationFile:
    """Read the file of a table as `held_out_readings` does; raises InputFileError."""
    return held_out_readings(file.name, read_bytes(file), n_joints, nests, targets)


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


def _sentences(name: str, clauses: tuple[Sentence, ...]) -> tuple[Sentence, ...]:
    return tuple(in_files([name], clause) for clause in clauses)
