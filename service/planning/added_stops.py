"""Configurations that somebody wants to add to a plan: judged one by one, numbered, made stops of it.

The rules are those by which a plan chooses its own (`work_space`), but nothing is left out silently: the
first configuration that cannot be measured is named with the reason.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from service.domain.arrays import FloatArray
from service.domain.cell import Cell
from service.domain.session import PlannedStop, SessionPlan
from service.planning.cell_space import space_of_cell
from service.planning.errors import WorkSpaceError
from service.planning.work_space import (
    SEEN_WITHIN_RAD,
    WorkSpace,
    cosines_to_tracker,
    is_clear,
    nominal_chain,
    require_consistent,
)

_SLACK_RAD = 1e-9  # a configuration on the limit is inside it; both come from degrees


@dataclass(frozen=True, slots=True)
class WantedStop:
    """A configuration to add; without a nest the one that faces the tracker best is measured."""

    joints_rad: tuple[float, ...]
    nest: int | None = None  # 1-based


def stops_to_add(cell: Cell, plan: SessionPlan, wanted: Sequence[WantedStop]) -> tuple[PlannedStop, ...]:
    """Return stops that follow those of `plan`; one with the joints and nest of an earlier stop repeats it.

    Raises
    ------
    WorkSpaceError
        A configuration does not fit the robot, lies outside its limits, comes near the table or the
        robot's own column, or shows no nest to the tracker.
    """
    space = _space(cell, plan)
    require_consistent(space)
    joints_rad = _joints(space, wanted)
    _check_limits(space, joints_rad)
    _check_clear(space, joints_rad)
    nests = _nests(space, joints_rad, wanted)
    first = max((stop.config for stop in plan.stops), default=0) + 1
    stops: list[PlannedStop] = []
    for config, (entry, nest) in enumerate(zip(wanted, nests, strict=True), start=first):
        same = _same_stop((*plan.stops, *stops), entry.joints_rad, nest)
        stops.append(PlannedStop(config, entry.joints_rad, nest, same))
    return tuple(stops)


def _space(cell: Cell, plan: SessionPlan) -> WorkSpace:
    known = (
        cell.limits.calibration,
        cell.robot.calibration_ranges,
        cell.limits.joints,
        cell.robot.joint_limits,
    )
    ranges = next((limits for limits in known if limits is not None), None)
    if ranges is None:
        raise WorkSpaceError(
            f"Neither the cell nor {cell.robot.name} states joint limits; nothing moves without them."
        )
    return space_of_cell(cell, ranges, plan.approach_offset_rad)


def _joints(space: WorkSpace, wanted: Sequence[WantedStop]) -> FloatArray:
    """Return the joint angles of all configurations, shape (n, J)."""
    for number, entry in enumerate(wanted, start=1):
        if len(entry.joints_rad) != space.robot.n_joints or not np.all(np.isfinite(entry.joints_rad)):
            raise WorkSpaceError(
                f"Configuration {number} of those to add needs {space.robot.n_joints} finite joint angles."
            )
    return np.array([entry.joints_rad for entry in wanted])


def _stops_and_approaches(space: WorkSpace, joints_rad: FloatArray) -> tuple[tuple[str, FloatArray], ...]:
    return ("stop", joints_rad), ("approach", joints_rad + (space.approach_offset_rad or 0.0))


def _check_limits(space: WorkSpace, joints_rad: FloatArray) -> None:
    low = np.array([limit.lower_rad for limit in space.motion_limits])
    high = np.array([limit.upper_rad for limit in space.motion_limits])
    for what, places in _stops_and_approaches(space, joints_rad):
        outside = np.argwhere((places < low - _SLACK_RAD) | (places > high + _SLACK_RAD))
        if len(outside):
            row, joint = outside[0]
            raise WorkSpaceError(
                f"The {what} of configuration {row + 1} of those to add lies outside the limits: joint "
                f"{joint + 1} at {np.degrees(places[row, joint]):.2f} deg, limits "
                f"{np.degrees(low[joint]):.2f} to {np.degrees(high[joint]):.2f} deg."
            )


def _check_clear(space: WorkSpace, joints_rad: FloatArray) -> None:
    for what, places in _stops_and_approaches(space, joints_rad):
        blocked = np.flatnonzero(~is_clear(space, nominal_chain(space, places)))
        if len(blocked):
            raise WorkSpaceError(
                f"The {what} of configuration {blocked[0] + 1} of those to add comes too near to the table "
                "or to the robot's own column; leave it out."
            )


def _nests(space: WorkSpace, joints_rad: FloatArray, wanted: Sequence[WantedStop]) -> list[int]:
    """Return the nest to measure in each configuration."""
    cosines = cosines_to_tracker(space, nominal_chain(space, joints_rad))
    nests = []
    for number, (entry, cosine) in enumerate(zip(wanted, cosines.T, strict=True), start=1):
        if entry.nest is not None and entry.nest > len(space.nests):
            raise WorkSpaceError(f"The tool has {len(space.nests)} nests; {entry.nest} is none of them.")
        nest = int(np.argmax(cosine)) + 1 if entry.nest is None else entry.nest
        if cosine[nest - 1] < np.cos(SEEN_WITHIN_RAD):
            what = "no tool nest" if entry.nest is None else f"tool nest {nest} not"
            raise WorkSpaceError(
                f"In configuration {number} of those to add the tracker sees {what}; leave it out."
            )
        nests.append(nest)
    return nests


def _same_stop(stops: Sequence[PlannedStop], joints_rad: tuple[float, ...], nest: int) -> int | None:
    """Return the first stop with the same joints and nest: measuring it again shows the arm's own scatter."""
    return next((s.config for s in stops if s.joints_rad == joints_rad and s.nest == nest), None)
