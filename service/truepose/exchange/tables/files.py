"""Tables on their own, outside a campaign: points to predict, points or legs to validate, predictions."""

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import LegReadings, PointReadings, Stops
from truepose.exchange.input_file import read_bytes
from truepose.exchange.tables.legs import leg_columns, read_leg_table
from truepose.exchange.tables.points import ignored_columns, point_columns, read_point_table
from truepose.exchange.tables.stops import stop_columns, stops_to_visit, torque_names
from truepose.exchange.tables.table import WHOLE, Column, column_names, one_of, read_table
from truepose.exchange.tables.text import prediction_text


@dataclass(frozen=True, slots=True)
class PointsToPredict:
    """Rows of a file for `predict`; without a `nest` column every known nest is wanted at every row."""

    stops: Stops
    nest: IntArray | None  # (n,)
    ignored: tuple[str, ...]  # one sentence for every column not understood


@dataclass(frozen=True, slots=True)
class ValidationFile:
    """Readings of a file for `validate`."""

    readings: PointReadings | LegReadings
    ignored: tuple[str, ...]


def read_points_to_predict(file: Path, n_joints: int, nests: Collection[int]) -> PointsToPredict:
    """Read `config`, the joints and what else is known of each stop; measured values do not matter.

    Parameters
    ----------
    file : Path
    n_joints : int
        Joints of the model's robot.
    nests : collection of int
        Numbers of the tool nests that the model knows.

    Raises
    ------
    InputFileError
        With file, line and column.
    """
    columns = [
        *stop_columns(n_joints),
        Column("nest", required=False, rules=(WHOLE, one_of(nests, "the known nests"))),
    ]
    measured = [*point_columns(n_joints, nests), *leg_columns(n_joints, nests)]
    table = read_table(
        file.name,
        read_bytes(file),
        columns,
        together=[torque_names(n_joints)],
        passed_over={column.name for column in measured},
    )
    return PointsToPredict(
        stops=stops_to_visit(table, n_joints),
        nest=table.optional_whole("nest"),
        ignored=_sentences(file, ignored_columns(table)),
    )


def read_points(
    file: Path,
    n_joints: int,
    nests: Collection[int],
    tracker_position_mm: tuple[float, float, float] | None = None,
) -> ValidationFile:
    """Read measured points as in `validation` of a campaign.

    Raises
    ------
    InputFileError
        With file, line and column; also where uncertainties along and across the beam are given without
        the place of the tracker and without a covariance.
    """
    readings, ignored = read_point_table(file.name, read_bytes(file), n_joints, nests, tracker_position_mm)
    return ValidationFile(readings, _sentences(file, ignored))


def read_legs(file: Path, n_joints: int, nests: Collection[int]) -> ValidationFile:
    """Read measured legs as in `validation_legs` of a campaign; raises InputFileError."""
    readings, ignored = read_leg_table(file.name, read_bytes(file), n_joints, nests)
    return ValidationFile(readings, _sentences(file, ignored))


def read_validation_file(file: Path, n_joints: int, nests: Collection[int]) -> ValidationFile:
    """Read points or legs, whichever the header announces; raises InputFileError."""
    names = column_names(file.name, read_bytes(file))
    if "length_mm" in names and "x_mm" not in names:
        return read_legs(file, n_joints, nests)
    return read_points(file, n_joints, nests)


def write_predictions(
    file: Path,
    config: IntArray,
    nest: IntArray,
    position_mm: FloatArray,
    standard_uncertainty_mm: FloatArray,
) -> None:
    """Write predicted points in the order given; shapes (n,), (n,), (n, 3), (n,)."""
    text = prediction_text(config, nest, position_mm, standard_uncertainty_mm)
    file.write_text(text, encoding="utf-8", newline="\n")


def _sentences(file: Path, clauses: tuple[str, ...]) -> tuple[str, ...]:
    return tuple(f"{file.name}: {clause}." for clause in clauses)
