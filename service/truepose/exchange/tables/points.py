"""Tables of measured tool nests (`calibration`, `validation`) and of fixed nests (`reference`)."""

import math
from collections.abc import Collection, Sequence

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import FixedNestReadings, PointReadings, Stops
from truepose.exchange.errors import MissingEntryError
from truepose.exchange.tables.fields import (
    LENGTH,
    SAME_JOINTS_DEG,
    TIME,
    UNCERTAINTY,
    Field,
    columns_of,
    read_fields,
    read_stops_of,
    stop_cells,
    stop_fields,
    table_text,
    torque_names,
    written_fields,
)
from truepose.exchange.tables.table_reader import (
    POSITIVE,
    WHOLE,
    Column,
    Rule,
    Table,
    TableData,
    at_least,
    one_of,
    read_table,
)
from truepose.messages.message import Message, message

POSITION = ("x_mm", "y_mm", "z_mm")
QUATERNION = ("qw", "qx", "qy", "qz")
BEAM = ("u_along_mm", "u_across_mm")
COVARIANCE = ("cxx", "cxy", "cxz", "cyy", "cyz", "czz")
UPPER_TRIANGLE = np.triu_indices(3)  # row by row, the order of COVARIANCE
# Controllers print quaternions with three decimals: four roundings of 0.0005 change the length by 0.001 at
# most. Twice that still tells a rounded quaternion from one that is none.
_QUATERNION_TOLERANCE = 2e-3
# A quaternion of full precision is left as it is, so that writing and reading it again changes nothing.
_ROUNDING = 1e-14

# The squares of what `u_mm` may be.
_GREATEST_COVARIANCE_MM2 = 1e6
_LEAST_VARIANCE_MM2 = 1e-18

Vector = tuple[float, float, float]


def _upper_triangle(covariance_mm2: FloatArray) -> FloatArray:
    return covariance_mm2[:, *UPPER_TRIANGLE]


POSITION_FIELD = Field("position_mm", tuple(Column(name) for name in POSITION), LENGTH)
UNCERTAINTY_FIELD = Field("standard_uncertainty_mm", Column("u_mm", rules=(POSITIVE,)), UNCERTAINTY)
_ROTATION = Column("u_rot_deg", required=False, rules=(POSITIVE,), blank=math.nan)


def _point_fields(nests: Collection[int]) -> list[Field]:
    """Return what a row of measured points holds besides its stop."""
    quaternion, covariance = (
        [Column(name, required=False) for name in names] for names in (QUATERNION, COVARIANCE)
    )
    return [
        Field("nest", Column("nest", rules=(WHOLE, one_of(nests, "the tool nests")))),
        POSITION_FIELD,
        UNCERTAINTY_FIELD,
        Field("quaternion", tuple(quaternion), ".15f"),
        Field("rotation_uncertainty_rad", _ROTATION, UNCERTAINTY, np.radians, np.degrees),
        # All digits: rounding must not cost a covariance its definiteness.
        Field("covariance_mm2", tuple(covariance), ".16e", outward=_upper_triangle),
    ]


def point_columns(n_joints: int, nests: Collection[int]) -> list[Column]:
    """Return the columns of measured points."""
    beam = (Column(name, required=False, rules=(POSITIVE,)) for name in BEAM)
    return [*columns_of([*stop_fields(n_joints), *_point_fields(nests)]), *beam]


def point_groups(n_joints: int) -> list[tuple[str, ...]]:
    """Return the optional columns that come all or not at all."""
    return [tuple(torque_names(n_joints)), QUATERNION, BEAM, COVARIANCE]


def read_point_table(
    file: str, data: TableData, n_joints: int, nests: Collection[int], tracker_position_mm: Vector | None
) -> tuple[PointReadings, tuple[Message, ...]]:
    """Read measured points; return them and one clause for every column ignored.

    Raises an InputFileError that names line and column.
    """
    table = read_table(file, data, point_columns(n_joints, nests), together=point_groups(n_joints))
    said = read_fields(table, _point_fields(nests))
    # Last: covariances may come from two kinds of columns, and quaternions are brought to length 1.
    said |= {"covariance_mm2": _covariance(table, tracker_position_mm), "quaternion": _quaternion(table)}
    readings = PointReadings(stops=read_stops_of(table, n_joints), **said)
    return readings, (*ignored_columns(table), *_superseded(table), *_doubtful_repeats(readings.stops))


def point_text(readings: PointReadings) -> str:
    """Return a `calibration` or `validation` table."""
    return table_text({**stop_cells(readings.stops), **written_fields(readings, _point_fields(()))})


def _reference_fields(rule: Rule) -> list[Field]:
    time_s, fixed_nest = Column("time_s"), Column("fixed_nest", rules=(WHOLE, rule))
    return [Field("time_s", time_s, TIME), Field("fixed_nest", fixed_nest), POSITION_FIELD, UNCERTAINTY_FIELD]


def read_reference_table(
    file: str, data: TableData, n_fixed_nests: int
) -> tuple[FixedNestReadings, tuple[Message, ...]]:
    """Read looks at fixed nests; `n_fixed_nests` is 0 where none is certified and any number may be named."""
    among = one_of(range(1, n_fixed_nests + 1), "the fixed nests") if n_fixed_nests else at_least(1)
    fields = _reference_fields(among)
    table = read_table(file, data, columns_of(fields))
    return FixedNestReadings(**read_fields(table, fields)), ignored_columns(table)


def reference_text(readings: FixedNestReadings) -> str:
    """Return a `reference` table."""
    return table_text(written_fields(readings, _reference_fields(at_least(1))))


def ignored_columns(table: Table) -> tuple[Message, ...]:
    """Return one clause for every column that the format does not know."""
    return tuple(message("ignored.column", column=name) for name in table.unlisted)


def in_files(files: Sequence[str], clause: Message) -> Message:
    """Return the sentence of a clause on tables of these names."""
    return message("ignored.in_files", files=", ".join(files), clause=clause)


def _superseded(table: Table) -> tuple[Message, ...]:
    if COVARIANCE[0] not in table or BEAM[0] not in table:
        return ()
    return (message("ignored.beam", columns=BEAM, first=COVARIANCE[0], last=COVARIANCE[-1]),)


def _doubtful_repeats(stops: Stops) -> tuple[Message, ...]:
    """Return a clause when a revisit names a configuration of other joints: it would be no pure error."""
    if stops.repeat_of is None:
        return ()
    _, first = np.unique(stops.config, return_index=True)
    row_of = dict(zip(stops.config[first].tolist(), first.tolist(), strict=True))
    earlier = np.array([row_of.get(config, row) for row, config in enumerate(stops.repeat_of.tolist())])
    away_deg = np.degrees(np.abs(stops.joints_rad - stops.joints_rad[earlier]).max(axis=1))
    wrong = np.flatnonzero(away_deg > SAME_JOINTS_DEG)
    if len(wrong) == 0:
        return ()
    row = int(wrong[0])
    clause = message(
        "ignored.revisit",
        config=int(stops.config[row]),
        first=int(stops.repeat_of[row]),
        away_deg=float(away_deg[row]),
        wrong=len(wrong),
    )
    return (clause,)


def _covariance(table: Table, tracker_position_mm: Vector | None) -> FloatArray | None:
    """Return (n, 3, 3) covariances [mm2] from whichever columns give them, or None."""
    if COVARIANCE[0] in table:
        return _full_covariance(table)
    if BEAM[0] not in table:
        return None
    if tracker_position_mm is None:
        raise MissingEntryError(
            f"{' and '.join(BEAM)} need tracker_position_world_mm in campaign.json",
            file=table.file,
            line=table.header_line,
            column=BEAM[0],
        )
    return _beam_covariance(table, np.array(tracker_position_mm))


def _full_covariance(table: Table) -> FloatArray:
    covariance = np.empty((len(table.lines), 3, 3))
    rows, columns = UPPER_TRIANGLE
    entries = table.block(COVARIANCE)
    covariance[:, rows, columns] = entries
    covariance[:, columns, rows] = entries
    table.require(
        np.abs(entries).max(axis=1) <= _GREATEST_COVARIANCE_MM2,
        COVARIANCE[0],
        f"{COVARIANCE[0]} to {COVARIANCE[-1]} are too large: they are in mm2, and the limit is "
        f"{_GREATEST_COVARIANCE_MM2:,.0f} mm2; correct them, or remove the row",
    )
    # Beyond what rounding leaves: a weight is the inverse, and of a matrix that is nearly singular it is a
    # weight that nobody stated.
    definite = np.linalg.eigvalsh(covariance)[:, 0] > _LEAST_VARIANCE_MM2
    table.require(
        definite, COVARIANCE[0], f"{COVARIANCE[0]} to {COVARIANCE[-1]} are not a positive definite matrix"
    )
    return covariance


def _beam_covariance(table: Table, tracker_mm: FloatArray) -> FloatArray:
    """Turn the uncertainties along and across the beam into the world frame."""
    beam = table.block(POSITION) - tracker_mm
    distance = np.linalg.norm(beam, axis=1)
    table.require(
        distance > 0.0, "x_mm", "the point lies in the tracker itself, so its beam has no direction"
    )
    unit = beam / distance[:, None]
    along, across = (table.numbers(name)[:, None, None] ** 2 for name in BEAM)
    covariance: FloatArray = across * np.eye(3) + (along - across) * unit[:, :, None] * unit[:, None, :]
    return covariance


def _quaternion(table: Table) -> FloatArray | None:
    return unit_quaternions(table) if QUATERNION[0] in table else None


def unit_quaternions(table: Table) -> FloatArray:
    """Return the orientations of a table that has them, shape (n, 4) w first; raises BadValueError."""
    quaternion = table.block(QUATERNION)
    length = np.linalg.norm(quaternion, axis=1)
    unit = np.abs(length - 1.0) <= _QUATERNION_TOLERANCE
    table.require(unit, QUATERNION[0], f"{QUATERNION[0]} to {QUATERNION[-1]} are not a unit quaternion")
    length[np.abs(length - 1.0) < _ROUNDING] = 1.0
    normalised: FloatArray = quaternion / length[:, None]
    return normalised
