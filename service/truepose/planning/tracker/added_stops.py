"""Configurations that somebody wants to add to a plan: judged one by one, numbered, made stops of it.

The rules are those by which a plan chooses its own (`workspace.space`), but nothing is left out silently:
what cannot be measured is named with its reason.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell import Cell
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.messages.message import Text
from truepose.planning.errors import WorkSpaceError
from truepose.planning.workspace.bodies import are_outside_keep_outs
from truepose.planning.workspace.candidates import cosines_in_sight, is_seen
from truepose.planning.workspace.space import (
    WorkSpace,
    is_clear,
    nominal_chain,
    require_consistent,
    space_of_cell,
)

_SLACK_RAD = 1e-9  # a configuration on the limit is inside it; both come from degrees
_SAME_RAD = 1e-9  # turns the end of a 2 m arm by 2 nm; clients send degrees with nine decimals


@dataclass(frozen=True, slots=True)
class WantedStop:
    """A configuration to add; without a nest the one that faces the tracker best is measured.

    Attributes
    ----------
    joints_rad : tuple of float
    nest : int or None
        1-based.
    """

    joints_rad: tuple[float, ...]
    nest: int | None = None


@dataclass(frozen=True, slots=True)
class Exclusion:
    """A configuration that cannot be measured, and why."""

    number: int  # 1-based, of those wanted
    reason: str


@dataclass(frozen=True, slots=True)
class Addition:
    """What becomes of the configurations wanted."""

    stops: tuple[PlannedStop, ...]
    left_out: tuple[Exclusion, ...]
    notice: Text = ""  # on the ways to them: for whoever confirms


def addition(
    cell: Cell, plan: SessionPlan, wanted: Sequence[WantedStop], *, leave_out_unfit: bool = False
) -> Addition:
    """Return stops that follow those of `plan`; one with the joints and nest of an earlier stop repeats it.

    Parameters
    ----------
    cell : Cell
    plan : SessionPlan
        Which is not changed.
    wanted : sequence of WantedStop
        One at least.
    leave_out_unfit : bool
        A configuration that lies outside the limits, comes near the table, the robot's own column or a
        keep-out volume, or shows no nest to the tracker is left out, as long as one remains.

    Returns
    -------
    Addition
        Its notice is empty: ways are judged by whoever knows where the arm stands.

    Raises
    ------
    WorkSpaceError
        A configuration does not fit the robot, or cannot be measured and is not to be left out; or nobody
        states joint limits.
    """
    space = _space(cell, plan)
    require_consistent(space)
    joints_rad = _joints(space, wanted)
    # Whether it is seen or not: what is refused is refused with its nest.
    nests = _nests(space, joints_rad, wanted)
    reasons = _reasons(space, joints_rad, nests, wanted)
    left_out = tuple(Exclusion(number, reason) for number, reason in enumerate(reasons, 1) if reason)
    if left_out and (not leave_out_unfit or len(left_out) == len(wanted)):
        first = left_out[0]
        raise WorkSpaceError(f"Additional configuration {first.number}: {first.reason}. Leave it out.")
    fit = [k for k, reason in enumerate(reasons) if reason is None]
    return Addition(_numbered(plan, [(wanted[k].joints_rad, nests[k]) for k in fit]), left_out)


def _space(cell: Cell, plan: SessionPlan) -> WorkSpace:
    known = (
        cell.limits.calibration,
        cell.robot.calibration_ranges,
        cell.limits.joints,
        cell.robot.joint_limits,
    )
    # Nothing is drawn here: any ranges will do for a work space, whose motion limits are those of the
    # joints where they are known.
    ranges = next((limits for limits in known if limits is not None), None)
    if ranges is None:
        raise WorkSpaceError(
            f"Joint limits are missing from both the cell file and {cell.robot.name}. Add them to the cell "
            "file; the robot does not move without joint limits."
        )
    return space_of_cell(cell, ranges, plan.approach_offset_rad)


def _joints(space: WorkSpace, wanted: Sequence[WantedStop]) -> FloatArray:
    """Return the joint angles of all configurations, shape (n, J)."""
    for number, entry in enumerate(wanted, start=1):
        if len(entry.joints_rad) != space.robot.n_joints or not np.all(np.isfinite(entry.joints_rad)):
            raise WorkSpaceError(
                f"Additional configuration {number} needs {space.robot.n_joints} finite joint angles."
            )
    return np.array([entry.joints_rad for entry in wanted])


def _nests(space: WorkSpace, joints_rad: FloatArray, wanted: Sequence[WantedStop]) -> list[int]:
    """Return the nest to measure in each configuration, be it seen or not."""
    unknown = next((w.nest for w in wanted if w.nest is not None and w.nest > len(space.nests)), None)
    if unknown is not None:
        raise WorkSpaceError(f"The tool has no nest {unknown}; it has {len(space.nests)} nests.")
    best = np.argmax(cosines_in_sight(space, nominal_chain(space, joints_rad)), axis=0) + 1
    return [int(best[k]) if entry.nest is None else entry.nest for k, entry in enumerate(wanted)]


def _reasons(
    space: WorkSpace, joints_rad: FloatArray, nests: Sequence[int], wanted: Sequence[WantedStop]
) -> list[str | None]:
    """Return why each configuration cannot be measured, None where it can."""
    approach_rad = joints_rad + (space.approach_offset_rad or 0.0)
    # The first reason is told: limits before what lies beyond them.
    judged = [
        _outside(space, joints_rad, "the measurement pose"),
        _outside(space, approach_rad, "the approach"),
        _blocked(space, joints_rad, "the measurement pose"),
        _blocked(space, approach_rad, "the approach"),
        _kept_out(space, joints_rad, "the measurement pose"),
        _kept_out(space, approach_rad, "the approach"),
        _unseen(space, joints_rad, nests, wanted),
    ]
    return [next((reason for reason in reasons if reason), None) for reasons in zip(*judged, strict=True)]


def _outside(space: WorkSpace, joints_rad: FloatArray, what: str) -> list[str | None]:
    low = np.array([limit.lower_rad for limit in space.motion_limits])
    high = np.array([limit.upper_rad for limit in space.motion_limits])
    beyond = np.maximum(low - joints_rad, joints_rad - high)
    worst = np.argmax(beyond, axis=1)
    return [
        f"{what} is outside the joint limits (joint {joint + 1} at "
        f"{np.degrees(joints_rad[row, joint]):.2f} deg, limits {np.degrees(low[joint]):.2f} to "
        f"{np.degrees(high[joint]):.2f} deg)"
        if beyond[row, joint] > _SLACK_RAD
        else None
        for row, joint in enumerate(worst)
    ]


def _blocked(space: WorkSpace, joints_rad: FloatArray, what: str) -> list[str | None]:
    reason = f"{what} is too close to the table or the robot's own column"
    return [None if clear else reason for clear in is_clear(space, nominal_chain(space, joints_rad))]


def _kept_out(space: WorkSpace, joints_rad: FloatArray, what: str) -> list[str | None]:
    reason = f"{what} is too close to a keep-out volume ({', '.join(space.keep_outs.names)})"
    return [None if outside else reason for outside in are_outside_keep_outs(space, joints_rad)]


def _unseen(
    space: WorkSpace, joints_rad: FloatArray, nests: Sequence[int], wanted: Sequence[WantedStop]
) -> list[str | None]:
    cosines = cosines_in_sight(space, nominal_chain(space, joints_rad))
    seen = [is_seen(space, cosines[nest - 1, row]) for row, nest in enumerate(nests)]
    return [
        None if sees else f"the tracker cannot see {'any tool nest' if w.nest is None else f'nest {w.nest}'}"
        for sees, w in zip(seen, wanted, strict=True)
    ]


def _numbered(plan: SessionPlan, places: Sequence[tuple[tuple[float, ...], int]]) -> tuple[PlannedStop, ...]:
    stops = list(plan.stops)
    first = max((stop.config for stop in stops), default=0) + 1
    for config, (joints_rad, nest) in enumerate(places, start=first):
        same = _same_stop(stops, joints_rad, nest)
        if same is None:
            stops.append(PlannedStop(config, joints_rad, nest))
        else:
            stops.append(PlannedStop(config, same.joints_rad, nest, same.config))
    return tuple(stops[len(plan.stops) :])


def _same_stop(stops: Sequence[PlannedStop], joints_rad: tuple[float, ...], nest: int) -> PlannedStop | None:
    """Return the first stop with the same joints and nest: measuring it again shows the arm's own scatter."""
    return next(
        (
            stop
            for stop in stops
            if stop.nest == nest and np.allclose(stop.joints_rad, joints_rad, rtol=0.0, atol=_SAME_RAD)
        ),
        None,
    )
