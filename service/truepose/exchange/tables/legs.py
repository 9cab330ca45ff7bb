"""Tables of the ballbar: legs, the fixtures' triangles, cup set-ups, and the tracker's readings of cups."""

from collections.abc import Collection
from dataclasses import replace

import numpy as np

from truepose.domain.campaign import CupReadings, CupSetups, FixtureLengths, LegReadings
from truepose.exchange.tables.points import POSITION, ignored_columns
from truepose.exchange.tables.stops import NO_REPEAT, joint_names, read_stops_of, stop_columns, torque_names
from truepose.exchange.tables.table import (
    POSITIVE,
    WHOLE,
    Column,
    TableData,
    at_least,
    between,
    one_of,
    read_table,
)

Ignored = tuple[str, ...]  # clauses that name a column each
_KINDS = ("tool", "base")
_PLACEMENT = Column("placement", rules=(WHOLE, at_least(1)))
_BASE_POINT = Column("base_point", rules=(WHOLE, between(1, 4)))
_UNCERTAINTY = Column("u_mm", rules=(POSITIVE,))
_LENGTH = Column("length_mm", rules=(POSITIVE,))


def leg_columns(n_joints: int, nests: Collection[int]) -> list[Column]:
    """Return the columns of measured legs."""
    return [
        _PLACEMENT,
        *stop_columns(n_joints),
        Column("init", required=False, rules=(WHOLE,)),
        _BASE_POINT,
        Column("tool_point", rules=(WHOLE, one_of(nests, "the tool nests"))),
        _LENGTH,
        _UNCERTAINTY,
    ]


def read_leg_table(
    file: str, data: TableData, n_joints: int, nests: Collection[int]
) -> tuple[LegReadings, Ignored]:
    """Read legs; raises an InputFileError that names line and column."""
    columns, groups = leg_columns(n_joints, nests), [torque_names(n_joints)]
    table = read_table(file, data, columns, together=groups)
    legs = LegReadings(
        stops=read_stops_of(table, n_joints, numbered_by=("placement",)),
        placement=table.whole("placement"),
        base_point=table.whole("base_point"),
        nest=table.whole("tool_point"),
        length_mm=table.numbers("length_mm"),
        standard_uncertainty_mm=table.numbers("u_mm"),
        initialisation=table.optional_whole("init"),
    )
    legs, clauses = _numbered_apart(legs)
    return legs, (*ignored_columns(table), *clauses)


def _numbered_apart(legs: LegReadings) -> tuple[LegReadings, tuple[str, ...]]:
    """Tell stops apart that each placement numbers for itself: legs of one number share one stop."""
    stops = legs.stops
    pairs = np.unique(np.column_stack([stops.config, legs.placement]), axis=0)
    if len(np.unique(pairs[:, 0])) == len(pairs):
        return legs, ()
    step = 10 ** len(str(stops.config.max()))
    _, place = np.unique(legs.placement, return_inverse=True)
    earlier = stops.repeat_of
    if earlier is not None:
        earlier = np.where(earlier == NO_REPEAT, NO_REPEAT, earlier + step * place)
    apart = replace(stops, config=stops.config + step * place, repeat_of=earlier)
    clause = f"placements share numbers of configurations; {step} is added to them for each further placement"
    return replace(legs, stops=apart), (clause,)


def read_fixture_table(file: str, data: TableData) -> tuple[FixtureLengths, Ignored]:
    """Read the sides of the triangles; placement 0 is the tool's, all others are base fixtures'."""
    columns = [
        Column("placement", rules=(WHOLE, at_least(0))),
        Column("kind", words=_KINDS),
        Column("point_a", rules=(WHOLE, between(1, 4))),
        Column("point_b", rules=(WHOLE, between(1, 4))),
        _LENGTH,
        _UNCERTAINTY,
    ]
    table = read_table(file, data, columns)
    placement, point_a, point_b = (table.whole(name) for name in ("placement", "point_a", "point_b"))
    is_base = table.numbers("kind") == _KINDS.index("base")
    table.require(is_base == (placement > 0), "kind", "placement 0 is the tool and every other one a base")
    table.require(point_a != point_b, "point_b", "a side joins two different points")
    lengths = FixtureLengths(placement, point_a, point_b, table.numbers("length_mm"), table.numbers("u_mm"))
    return lengths, ignored_columns(table)


def read_setup_table(file: str, data: TableData, n_joints: int) -> tuple[CupSetups, Ignored]:
    """Read the joint angles at which cups were clamped on the ball in tool nest 1."""
    names = joint_names(n_joints)
    table = read_table(file, data, [_PLACEMENT, _BASE_POINT, *(Column(name) for name in names)])
    joints_rad = np.radians(table.block(names))
    return CupSetups(table.whole("placement"), table.whole("base_point"), joints_rad), ignored_columns(table)


def read_cup_table(file: str, data: TableData) -> tuple[CupReadings, Ignored]:
    """Read the tracker's readings of base cups."""
    columns = [_PLACEMENT, _BASE_POINT, *(Column(name) for name in POSITION), _UNCERTAINTY]
    table = read_table(file, data, columns)
    readings = CupReadings(
        placement=table.whole("placement"),
        base_point=table.whole("base_point"),
        position_mm=table.block(POSITION),
        standard_uncertainty_mm=table.numbers("u_mm"),
    )
    return readings, ignored_columns(table)
