"""Tables of closed loops: contacts, the targets that they are against, certified distances of these."""

import math
from collections.abc import Collection, Sequence

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import NO_AXIS, ContactReadings, TargetDistances
from truepose.domain.contacts import CENTRES, SEEN_ALONG_AXES, Target, TargetKind
from truepose.domain.session import Vector
from truepose.exchange.errors import MissingEntryError
from truepose.exchange.tables.fields import (
    LENGTH,
    UNCERTAINTY,
    Cells,
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
from truepose.exchange.tables.points import UNCERTAINTY_FIELD, ignored_columns
from truepose.exchange.tables.table_reader import (
    POSITIVE,
    WHOLE,
    Column,
    Table,
    TableData,
    at_least,
    one_of,
    read_table,
)
from truepose.messages.message import Message

Ignored = tuple[Message, ...]  # clauses that name a column each
Targets = Sequence[Target]
_KINDS = tuple(kind.value for kind in TargetKind)
_AXES = ("x", "y", "z")
_SEEN = " or ".join(kind.value for kind in TargetKind if kind in SEEN_ALONG_AXES)
_AXIS = Column("axis", required=False, blank=NO_AXIS, words=_AXES)
_PLACE, _NORMAL = ("x_mm", "y_mm", "z_mm"), ("nx", "ny", "nz")
_LEAST_NORMAL = 1e-3


def _contact_fields(nests: Collection[int], targets: Collection[int]) -> list[Field]:
    """Return what a row of contacts holds besides its stop and its axis."""
    return [
        Field("target", Column("target", rules=(WHOLE, one_of(targets, "the targets")))),
        Field("nest", Column("nest", rules=(WHOLE, one_of(nests, "the tool nests")))),
        Field("reading_mm", Column("reading_mm"), LENGTH),
        UNCERTAINTY_FIELD,
    ]


def contact_columns(n_joints: int, nests: Collection[int]) -> list[Column]:
    """Return the columns of contacts."""
    return [*columns_of([*stop_fields(n_joints), *_contact_fields(nests, ())]), _AXIS]


def read_contact_table(
    file: str, data: TableData, n_joints: int, nests: Collection[int], targets: Targets
) -> tuple[ContactReadings, Ignored]:
    """Read contacts; raises an InputFileError that names line and column."""
    if not targets:
        raise MissingEntryError(
            "contacts need a table of targets: name one under files.targets",
            file=file,
        )
    own = _contact_fields(nests, [target.number for target in targets])
    columns = [*columns_of([*stop_fields(n_joints), *own]), _AXIS]
    table = read_table(file, data, columns, together=[torque_names(n_joints)])
    axis = table.optional_whole("axis")
    contacts = ContactReadings(stops=read_stops_of(table, n_joints), axis=axis, **read_fields(table, own))
    _check_axes(table, contacts, targets)
    return contacts, ignored_columns(table)


def _check_axes(table: Table, contacts: ContactReadings, targets: Targets) -> None:
    seen = [target.number for target in targets if target.kind in SEEN_ALONG_AXES]
    # A ball that a sensor sees is read along three axes: without its axis a reading could be any of them.
    along = np.isin(contacts.target, seen)
    column = "axis" if contacts.axis is not None else "target"
    table.require(
        ~along | (contacts.axes != NO_AXIS),
        column,
        f"a reading of {_SEEN} must be along an axis of its sensor: {', '.join(_AXES)}",
    )
    table.require(
        along | (contacts.axes == NO_AXIS),
        column,
        f"only a reading of {_SEEN} can be along an axis of a sensor",
    )


def contact_text(contacts: ContactReadings) -> str:
    """Return a `contacts` or `validation_contacts` table."""
    axes: Cells = {}
    if contacts.axis is not None:
        axes = {"axis": ["" if axis == NO_AXIS else _AXES[axis] for axis in contacts.axis.tolist()]}
    own = written_fields(contacts, _contact_fields((), ()))
    return table_text({**stop_cells(contacts.stops), **axes, **own})


def _target_columns() -> list[Column]:
    lengths = [
        Column("zero_mm", required=False, rules=(at_least(0),), blank=math.nan),
        Column("u_zero_mm", required=False, rules=(at_least(0),), blank=0.0),
        Column("form_mm", required=False, rules=(at_least(0),), blank=0.0),
    ]
    about = [Column(name, required=False, blank=math.nan) for name in (*_PLACE, *_NORMAL)]
    number, kind = Column("target", rules=(WHOLE, at_least(1))), Column("kind", words=_KINDS)
    return [number, kind, *lengths, *about]


def read_target_table(file: str, data: TableData) -> tuple[tuple[Target, ...], Ignored]:
    """Read the targets; raises an InputFileError that names line and column."""
    table = read_table(file, data, _target_columns(), together=[_PLACE, _NORMAL])
    numbers = table.whole("target")
    _, first = np.unique(numbers, return_index=True)
    table.require(np.isin(np.arange(len(numbers)), first), "target", "each target must be listed only once")
    columns = {name: _or_nan(table, name) for name in ("zero_mm", "u_zero_mm", "form_mm")}
    places, normals = (_vectors(table, names) for names in (_PLACE, _NORMAL))
    length = np.array([1.0 if n is None else np.linalg.norm(n) for n in normals])
    table.require(length > _LEAST_NORMAL, _NORMAL[0], "a direction must not be a zero vector")
    targets = tuple(
        Target(
            number=int(numbers[row]),
            kind=TargetKind(_KINDS[kind]),
            zero_mm=None if math.isnan(columns["zero_mm"][row]) else float(columns["zero_mm"][row]),
            zero_uncertainty_mm=float(np.nan_to_num(columns["u_zero_mm"][row])),
            form_mm=float(np.nan_to_num(columns["form_mm"][row])),
            place_mm=places[row],
            normal=normals[row],
        )
        for row, kind in enumerate(table.whole("kind").tolist())
    )
    return targets, ignored_columns(table)


def _or_nan(table: Table, name: str) -> FloatArray:
    found = table.optional_numbers(name)
    return np.full(len(table.lines), math.nan) if found is None else found


def _vectors(table: Table, names: tuple[str, ...]) -> list[Vector | None]:
    if names[0] not in table:
        return [None] * len(table.lines)
    rows = table.block(names)
    return [None if np.isnan(row).any() else (row[0], row[1], row[2]) for row in rows.tolist()]


def target_text(targets: Targets) -> str:
    """Return a `targets` table."""
    columns = {
        "target": [str(target.number) for target in targets],
        "kind": [target.kind.value for target in targets],
        "zero_mm": [_cell(target.zero_mm, LENGTH) for target in targets],
        "u_zero_mm": [_cell(target.zero_uncertainty_mm, UNCERTAINTY) for target in targets],
        "form_mm": [_cell(target.form_mm, UNCERTAINTY) for target in targets],
    }
    for names, vectors, form in (
        (_PLACE, [target.place_mm for target in targets], LENGTH),
        (_NORMAL, [target.normal for target in targets], ".9f"),
    ):
        if any(vector is not None for vector in vectors):
            columns |= {
                name: ["" if vector is None else _cell(vector[k], form) for vector in vectors]
                for k, name in enumerate(names)
            }
    return table_text(columns)


def _cell(value: float | None, form: str) -> str:
    return "" if value is None else format(value, form)


def _distance_fields(targets: Collection[int]) -> list[Field]:
    centres = (WHOLE, one_of(targets, "the targets that have a centre"))
    ends = [Field(name, Column(name, rules=centres)) for name in ("target_a", "target_b")]
    return [*ends, Field("distance_mm", Column("distance_mm", rules=(POSITIVE,)), LENGTH), UNCERTAINTY_FIELD]


def read_distance_table(file: str, data: TableData, targets: Targets) -> tuple[TargetDistances, Ignored]:
    """Read certified distances; raises an InputFileError that names line and column."""
    own = _distance_fields([target.number for target in targets if target.kind in CENTRES])
    table = read_table(file, data, columns_of(own))
    distances = TargetDistances(**read_fields(table, own))
    apart = distances.target_a != distances.target_b
    table.require(apart, "target_b", "a distance must be between two different targets")
    return distances, ignored_columns(table)


def distance_text(distances: TargetDistances) -> str:
    """Return a `target_distances` table."""
    return table_text(written_fields(distances, _distance_fields(())))
