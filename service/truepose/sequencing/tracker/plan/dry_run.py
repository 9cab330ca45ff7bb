"""Goes through a plan without a cell: whether every move lies within the limits, how long it will take."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.session import PlannedStop, SessionPlan
from truepose.domain.robot import FixedNest, FramePlacement, JointRange, Nest, Robot
from truepose.kinematics.frames import vector_from_rotation
from truepose.planning.work_volume.room_at_stops import THE
from truepose.planning.work_volume.work_space import WorkSpace, widened
from truepose.sequencing.engine.motion.interlocks import joint_outside
from truepose.sequencing.engine.motion.nominal_arm import nest_centre, nominal_chain
from truepose.sequencing.errors import PlanRefusedError
from truepose.sequencing.plan_numbers import check_numbers
from truepose.sequencing.tracker.plan.steps import (
    MeasurePoint,
    MeasurePose,
    Move,
    OpenDevices,
    Operation,
    ReadFixedNest,
    Settle,
)
from truepose.sequencing.tracker.situation import steps

FIND_S: Final = 3.0  # turning the head and locking on; order of magnitude, replaced by the pace once known
INITIALISE_S: Final = 60.0  # an instrument that was switched on; warm-up is not in it
_SECONDS_PER_MINUTE: Final = 60.0
_MIN_TRIANGLE_HEIGHT_MM = 50.0  # below it the fixed nests are as good as on a line
_POSITIVE: Final = (
    "measure_s", "search_radius_mm", "tool_speed_mm_s", "orientation_speed_rad_s", "reference_every",
    "reference_limit_mm", "registration_readings", "failures_in_a_row",
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class DryRun:
    """What a plan amounts to."""

    configurations: int
    moves: int
    readings: int
    duration_s: float  # estimate, persons not included


def dry_run(
    plan: SessionPlan, robot: Robot, base: FramePlacement, nests: tuple[Nest, ...], n_fixed_nests: int
) -> DryRun:
    """Return what a plan amounts to; raises PlanRefusedError where a nest of it is unknown."""
    operations = [operation for step in steps(plan, n_fixed_nests) for operation in step.operations]
    targets = np.array([operation.target_rad for operation in operations if isinstance(operation, Move)])
    motion_s = _motion_times(plan, robot, base, nest_centre(nests, plan.stops[0].nest), targets)
    return DryRun(
        configurations=len(plan.stops),
        moves=len(targets),
        readings=sum(_readings(operation) for operation in operations),
        duration_s=max(
            float(motion_s.sum()) + sum(_duration_s(plan, operation) for operation in operations),
            *(stop.work.until_s for stop in plan.stops if stop.work is not None),
            0.0,
        ),
    )


def minutes_of(plan: SessionPlan, space: WorkSpace, n_fixed_nests: int) -> float:
    """Return how long a plan takes [min]; 0 where it has no stops."""
    if not plan.stops:
        return 0.0
    run = dry_run(plan, space.robot, space.base, space.nests, n_fixed_nests)
    return run.duration_s / _SECONDS_PER_MINUTE


def _readings(operation: Operation) -> int:
    if isinstance(operation, ReadFixedNest):
        return operation.readings
    return int(isinstance(operation, MeasurePoint | MeasurePose))


def _duration_s(plan: SessionPlan, operation: Operation) -> float:
    match operation:
        case OpenDevices():
            return INITIALISE_S
        case Settle(duration_s):
            return duration_s
        case ReadFixedNest() | MeasurePoint():
            return FIND_S + _readings(operation) * plan.measure_s
        case MeasurePose():
            return plan.measure_s
        case _:
            return 0.0


def _motion_times(
    plan: SessionPlan, robot: Robot, base: FramePlacement, tool_mm: FloatArray, targets: FloatArray
) -> FloatArray:
    """Duration of each move but the first [s]: the slower of the tool's path and its turn."""
    chain = nominal_chain(robot, base, targets)
    path = np.linalg.norm(np.diff(chain.points(tool_mm), axis=0), axis=1)
    last = chain.rotation[-1]
    turn = np.swapaxes(last[:-1], -1, -2) @ last[1:]
    angle = np.linalg.norm(vector_from_rotation(turn), axis=1)
    times: FloatArray = np.maximum(path / plan.tool_speed_mm_s, angle / plan.orientation_speed_rad_s)
    return times


def check_plan(
    plan: SessionPlan,
    robot: Robot,
    nests: tuple[Nest, ...],
    fixed_nests: tuple[FixedNest, ...],
    limits: tuple[JointRange, ...],
    done: Collection[int] = (),
) -> None:
    """Raise PlanRefusedError, with one sentence, for the first thing that cannot be done as planned.

    The arm does not go again to the configurations that are `done`: limits that were tightened since do
    not end a session that keeps to them from now on.
    """
    check_numbers(plan, *_POSITIVE)
    _check_stops(plan, robot, nests)
    if plan.measures == "points":
        _check_fixed_nests(fixed_nests)
    else:
        _check_read_at_the_centre(plan, len(nests))
    for stop in plan.stops:
        if stop.config not in done:
            _check_motions(plan, stop, limits)


def _check_motions(plan: SessionPlan, stop: PlannedStop, limits: tuple[JointRange, ...]) -> None:
    for what, target_rad in stop.places(plan.approach_offset_rad):
        outside = joint_outside(target_rad, limits)
        if outside is not None:
            raise PlanRefusedError(
                f"{THE[what]} configuration {stop.config} lies outside the limits: {outside}."
            )


def _check_stops(plan: SessionPlan, robot: Robot, nests: tuple[Nest, ...]) -> None:
    if not plan.stops:
        raise PlanRefusedError("The plan has no configuration; choose at least one.")
    seen: dict[int, PlannedStop] = {}
    for stop in plan.stops:
        _check_stop(stop, robot, nests, seen)
        seen[stop.config] = stop


def _check_stop(
    stop: PlannedStop, robot: Robot, nests: tuple[Nest, ...], seen: dict[int, PlannedStop]
) -> None:
    if stop.config in seen:
        raise PlanRefusedError(f"Configuration {stop.config} is in the plan twice; number a revisit anew.")
    if len(stop.joints_rad) != robot.n_joints or not np.all(np.isfinite(stop.joints_rad)):
        raise PlanRefusedError(f"Configuration {stop.config} needs {robot.n_joints} finite joint angles.")
    nest_centre(nests, stop.nest)
    if stop.repeat_of is None:
        return
    first = seen.get(stop.repeat_of)
    if first is None or first.joints_rad != stop.joints_rad or first.nest != stop.nest:
        raise PlanRefusedError(
            f"Configuration {stop.config} repeats {stop.repeat_of}, "
            "which is not an earlier one with the same joints and nest."
        )


def _check_read_at_the_centre(plan: SessionPlan, centre: int) -> None:
    """Refuse other nests than the last one, which is the centre of the artefact that a camera follows."""
    for stop in plan.stops:
        if stop.nest != centre:
            raise PlanRefusedError(
                f"Configuration {stop.config} asks for tool nest {stop.nest}; a camera tells poses at nest "
                f"{centre}, the centre of the artefact."
            )


def _check_fixed_nests(fixed_nests: tuple[FixedNest, ...]) -> None:
    if len(fixed_nests) < 3:
        raise PlanRefusedError(
            f"The cell has {len(fixed_nests)} fixed nests; placing the tracker in the world takes three."
        )
    points = np.array([nest.centre_mm for nest in fixed_nests])
    spread = np.linalg.svd(points - points.mean(axis=0), compute_uv=False)
    if spread[1] < _MIN_TRIANGLE_HEIGHT_MM:
        raise PlanRefusedError("The fixed nests lie on a line; move one aside so that they span a triangle.")


def motion_limits(
    robot: Robot, joint_limits: tuple[JointRange, ...] | None, plan: SessionPlan
) -> tuple[JointRange, ...]:
    """Return what every move must keep to.

    That is what the controller accepts, where cell or robot say it; else the calibration ranges, widened by
    the approach. Raises PlanRefusedError where nothing is known.
    """
    known = joint_limits or robot.joint_limits
    if known is not None:
        return known
    if robot.calibration_ranges is None:
        raise PlanRefusedError(
            "Neither the cell nor the robot states joint limits; nothing moves without them."
        )
    return widened(robot.calibration_ranges, plan.approach_offset_rad)
