"""Tables of the ballbar: legs, the fixtures' triangles, cup set-ups, and the tracker's readings of cups."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from truepose.domain.campaign import CupReadings, CupSetups, FixtureLengths, LegReadings
from truepose.exchange.tables.fields import (
    LENGTH,
    NO_REPEAT,
    Field,
    columns_of,
    joint_field,
    read_fields,
    read_stops_of,
    stop_cells,
    stop_fields,
    table_text,
    torque_names,
    written_fields,
)
from truepose.exchange.tables.points import POSITION_FIELD, UNCERTAINTY_FIELD, ignored_columns
from truepose.exchange.tables.table_reader import (
    POSITIVE,
    WHOLE,
    Column,
    TableData,
    at_least,
    between,
    one_of,
    read_table,
)
from truepose.messages.message import Message, message

Ignored = tuple[Message, ...]  # clauses that name a column each
_KINDS = ("tool", "base")
_OF_FOUR = (WHOLE, between(1, 4))  # points of a fixture
_PLACEMENT = Field("placement", Column("placement", rules=(WHOLE, at_least(1))))
_OF_ANY_FIXTURE = Field("placement", Column("placement", rules=(WHOLE, at_least(0))))
_BASE_POINT = Field("base_point", Column("base_point", rules=_OF_FOUR))
_LENGTH = (Field("length_mm", Column("length_mm", rules=(POSITIVE,)), LENGTH), UNCERTAINTY_FIELD)
_SIDE = (*(Field(name, Column(name, rules=_OF_FOUR)) for name in ("point_a", "point_b")), *_LENGTH)
_CUPS = (_PLACEMENT, _BASE_POINT, POSITION_FIELD, UNCERTAINTY_FIELD)


def _leg_fields(nests: Collection[int]) -> list[Field]:
    """Return what a row of measured legs holds besides its placement and its stop."""
    initialisation = Field("initialisation", Column("init", required=False, rules=(WHOLE,)))
    nest = Field("nest", Column("tool_point", rules=(WHOLE, one_of(nests, "the tool nests"))))
    return [initialisation, _BASE_POINT, nest, *_LENGTH]


def leg_columns(n_joints: int, nests: Collection[int]) -> list[Column]:
    """Return the columns of measured legs."""
    return columns_of([_PLACEMENT, *stop_fields(n_joints), *_leg_fields(nests)])


def read_leg_table(
    file: str, data: TableData, n_joints: int, nests: Collection[int]
) -> tuple[LegReadings, Ignored]:
    """Read legs; raises an InputFileError that names line and column."""
    columns, groups = leg_columns(n_joints, nests), [torque_names(n_joints)]
    table = read_table(file, data, columns, together=groups)
    stops = read_stops_of(table, n_joints, numbered_by=("placement",))
    legs = LegReadings(stops=stops, **read_fields(table, [_PLACEMENT, *_leg_fields(nests)]))
    legs, clauses = _numbered_apart(legs)
    return legs, (*ignored_columns(table), *clauses)


def leg_text(legs: LegReadings) -> str:
    """Return a `legs` or `validation_legs` table."""
    where, what = written_fields(legs, [_PLACEMENT]), written_fields(legs, _leg_fields(()))
    return table_text({**where, **stop_cells(legs.stops), **what})


def _numbered_apart(legs: LegReadings) -> tuple[LegReadings, tuple[Message, ...]]:
    """Tell stops apart that each placement numbers for itself: legs of one number share one stop."""
    stops = legs.stops
    pairs = np.unique(np.column_stack([stops.config, legs.placement]), axis=0)
    if len(np.unique(pairs[:, 0])) == len(pairs):
        return legs, ()
    # A power of ten, so that the number that the file has can still be read in the one that is shown.
    step = 10 ** len(str(stops.config.max()))
    _, place = np.unique(legs.placement, return_inverse=True)
    earlier = stops.repeat_of
    if earlier is not None:
        earlier = np.where(earlier == NO_REPEAT, NO_REPEAT, earlier + step * place)
    apart = replace(stops, config=stops.config + step * place, repeat_of=earlier)
    clause = message("ignored.shared_numbers", step=step)
    return replace(legs, stops=apart), (clause,)


def read_fixture_table(file: str, data: TableData) -> tuple[FixtureLengths, Ignored]:
    """Read the sides of the triangles; placement 0 is the tool's, all others are base fixtures'."""
    kind = Column("kind", words=_KINDS)
    table = read_table(file, data, [*columns_of([_OF_ANY_FIXTURE]), kind, *columns_of(_SIDE)])
    lengths = FixtureLengths(**read_fields(table, [_OF_ANY_FIXTURE, *_SIDE]))
    rightly = (table.numbers("kind") == _KINDS.index("base")) == (lengths.placement > 0)
    table.require(rightly, "kind", "placement 0 is the tool; every other placement is a base")
    table.require(lengths.point_a != lengths.point_b, "point_b", "a side must join two different points")
    return lengths, ignored_columns(table)


def fixture_text(fixture: FixtureLengths) -> str:
    """Return a `fixture` table."""
    placement = written_fields(fixture, [_OF_ANY_FIXTURE])
    kind = ["base" if number else "tool" for number in fixture.placement]
    return table_text({**placement, "kind": kind, **written_fields(fixture, _SIDE)})


def read_setup_table(file: str, data: TableData, n_joints: int) -> tuple[CupSetups, Ignored]:
    """Read the joint angles at which cups were clamped on the ball in tool nest 1."""
    fields = [_PLACEMENT, _BASE_POINT, joint_field(n_joints)]
    table = read_table(file, data, columns_of(fields))
    return CupSetups(**read_fields(table, fields)), ignored_columns(table)


def setup_text(setup: CupSetups) -> str:
    """Return a `setup` table."""
    joints = joint_field(setup.joints_rad.shape[1])
    return table_text(written_fields(setup, [_PLACEMENT, _BASE_POINT, joints]))


def read_cup_table(file: str, data: TableData) -> tuple[CupReadings, Ignored]:
    """Read the tracker's readings of base cups."""
    table = read_table(file, data, columns_of(_CUPS))
    return CupReadings(**read_fields(table, _CUPS)), ignored_columns(table)


def cup_text(cups: CupReadings) -> str:
    """Return a `cups` table."""
    return table_text(written_fields(cups, _CUPS))
