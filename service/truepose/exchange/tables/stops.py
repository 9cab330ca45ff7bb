"""Columns that say where the arm stood: configuration, joints and what was known of the stop."""

import math
from collections.abc import Sequence

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.exchange.tables.table import WHOLE, Column, Table, at_least, between

_N_MM_PER_N_M = 1000.0
NO_REPEAT = -1
# Controllers report 0.01 deg, and an arm may stop as far off its target; two configurations of a plan lie
# tens of degrees apart.
SAME_JOINTS_DEG = 0.5


def joint_names(n_joints: int) -> list[str]:
    """Return `q1_deg` to `qn_deg`."""
    return [f"q{joint}_deg" for joint in range(1, n_joints + 1)]


def torque_names(n_joints: int) -> list[str]:
    """Return `tau1_Nm` to `taun_Nm`."""
    return [f"tau{joint}_Nm" for joint in range(1, n_joints + 1)]


def direction_names(n_joints: int) -> list[str]:
    """Return `dir1` to `dirn`."""
    return [f"dir{joint}" for joint in range(1, n_joints + 1)]


def stop_columns(n_joints: int) -> list[Column]:
    """Return the columns of a stop; an empty cell stands for unknown where that makes sense."""
    return [
        Column("config", rules=(WHOLE, at_least(0))),
        *(Column(name) for name in joint_names(n_joints)),
        *(
            Column(name, required=False, rules=(WHOLE, between(-1, 1)), blank=0.0)
            for name in direction_names(n_joints)
        ),
        Column("time_s", required=False, blank=math.nan),
        Column("temperature_C", required=False, blank=math.nan),
        Column("attachment", required=False, rules=(WHOLE,)),
        *(Column(name, required=False, blank=math.nan) for name in torque_names(n_joints)),
        Column("group", required=False, rules=(WHOLE,)),
        Column("repeat_of", required=False, rules=(WHOLE, at_least(NO_REPEAT)), blank=NO_REPEAT),
    ]


def read_stops_of(table: Table, n_joints: int, *, numbered_by: Sequence[str] = ()) -> Stops:
    """Return the stops of a measured table read with `stop_columns`; a number is one place of the arm.

    Raises BadValueError where it is two. `numbered_by` names the columns that number their stops apart.
    """
    _require_one_place_each(table, ("config", *numbered_by), joint_names(n_joints))
    return stops_to_visit(table, n_joints)


def stops_to_visit(table: Table, n_joints: int) -> Stops:
    """Return the stops of a table whose numbers are nothing but names of its rows."""
    return Stops(
        config=table.whole("config"),
        joints_rad=np.radians(table.block(joint_names(n_joints))),
        direction=_directions(table, n_joints),
        time_s=table.optional_numbers("time_s"),
        temperature_c=table.optional_numbers("temperature_C"),
        attachment=table.optional_whole("attachment"),
        torque_n_mm=_torques(table, n_joints),
        group=table.optional_whole("group"),
        repeat_of=table.optional_whole("repeat_of"),
    )


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
        f"configuration {table.whole(number[0])[row]} stands on {table.counted} {table.lines[earlier[row]]} "
        f"with other joints ({joints[joint]} differs by {away_deg[row, joint]:.4g}); "
        "number each place of the arm once",
    )


def _directions(table: Table, n_joints: int) -> IntArray | None:
    """Return the signs, 0 for a joint that has no column; None where no joint has one."""
    names = direction_names(n_joints)
    if not any(name in table for name in names):
        return None
    unknown = np.zeros(len(table.lines))
    return np.column_stack([table.values.get(name, unknown) for name in names]).astype(np.int64)


def _torques(table: Table, n_joints: int) -> FloatArray | None:
    names = torque_names(n_joints)
    return table.block(names) * _N_MM_PER_N_M if names[0] in table else None
