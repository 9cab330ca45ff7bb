"""Goes through a plan without a cell: limits, time, and what is said before the arm moves."""

import asyncio
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FixedNest, FramePlacement, JointRange, Nest, Robot, span_triangle
from truepose.domain.session import PlaceOf, PlannedStop, SessionPlan
from truepose.kinematics.frames import vector_from_rotation
from truepose.messages.message import Text, message
from truepose.planning.workspace.path_clearance import ways_between
from truepose.planning.workspace.space import WorkSpace, widen_ranges
from truepose.sessions.engine.interlocks import binding_speed, check_numbers, joint_outside
from truepose.sessions.engine.nominal_arm import nest_centre, nominal_chain
from truepose.sessions.engine.ways import KnownWays
from truepose.sessions.errors import PlanRefusedError
from truepose.sessions.tracker.cell import SessionCell
from truepose.sessions.tracker.state import steps
from truepose.sessions.tracker.steps import (
    MeasurePoint,
    MeasurePose,
    Move,
    OpenDevices,
    Operation,
    ReadFixedNest,
    Settle,
)
from truepose_drivers.api import RobotController
from truepose_drivers.errors import DriverError

FIND_S: Final = 3.0  # turning the head and locking on; order of magnitude, replaced by the pace once known
INITIALISE_S: Final = 60.0  # an instrument that was switched on; warm-up is not in it
_SECONDS_PER_MINUTE: Final = 60.0
_POSITIVE: Final = (
    "measure_s", "search_radius_mm", "tool_speed_mm_s", "orientation_speed_rad_s", "reference_every",
    "reference_limit_mm", "registration_readings", "failures_in_a_row",
)  # fmt: skip

_OUTSIDE: Final[dict[PlaceOf, str]] = {
    "work": "plan.refused.outside.work",
    "approach": "plan.refused.outside.approach",
    "stop": "plan.refused.outside.stop",
}


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
            # A test of drift waits until its last group is due, however fast the arm is.
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
    """Return the duration of each move but the first [s], shape (n - 1,).

    t = max(path / tool speed, angle / orientation speed), both limits being the controller's; ramps are left
    out.

    Parameters
    ----------
    plan : SessionPlan
    robot : Robot
    base : FramePlacement
    tool_mm : ndarray, shape (3,)
        Point whose path counts, in the flange frame.
    targets : ndarray, shape (n, J)
        Joint angles [rad].
    """
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
            raise PlanRefusedError(message(_OUTSIDE[what], config=stop.config, outside=outside))


def _check_stops(plan: SessionPlan, robot: Robot, nests: tuple[Nest, ...]) -> None:
    if not plan.stops:
        raise PlanRefusedError(message("plan.refused.no_configuration"))
    seen: dict[int, PlannedStop] = {}
    for stop in plan.stops:
        _check_stop(stop, robot, nests, seen)
        seen[stop.config] = stop


def _check_stop(
    stop: PlannedStop, robot: Robot, nests: tuple[Nest, ...], seen: dict[int, PlannedStop]
) -> None:
    if stop.config in seen:
        raise PlanRefusedError(message("plan.refused.configuration_twice", config=stop.config))
    if len(stop.joints_rad) != robot.n_joints or not np.all(np.isfinite(stop.joints_rad)):
        raise PlanRefusedError(
            message("plan.refused.joints_of_configuration", config=stop.config, joints=robot.n_joints)
        )
    # For its refusal alone: a nest without a centre cannot be looked for.
    nest_centre(nests, stop.nest)
    if stop.repeat_of is None:
        return
    first = seen.get(stop.repeat_of)
    # A revisit shows the scatter of the arm only where it is the same place to the last digit.
    if first is None or first.joints_rad != stop.joints_rad or first.nest != stop.nest:
        raise PlanRefusedError(message("plan.refused.repeats", config=stop.config, repeat_of=stop.repeat_of))


def _check_read_at_the_centre(plan: SessionPlan, centre: int) -> None:
    """Refuse other nests than the last one, which is the centre of the artefact that a camera follows."""
    for stop in plan.stops:
        if stop.nest != centre:
            raise PlanRefusedError(
                message("plan.refused.nest_of_camera", config=stop.config, nest=stop.nest, centre=centre)
            )


def _check_fixed_nests(fixed_nests: tuple[FixedNest, ...]) -> None:
    if len(fixed_nests) < 3:
        raise PlanRefusedError(message("plan.refused.fixed_nests", nests=len(fixed_nests)))
    # On a line they leave the turn about that line open.
    if not span_triangle(fixed_nests):
        raise PlanRefusedError(message("plan.refused.nests_on_a_line"))


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
        raise PlanRefusedError(message("session.limits.unknown"))
    return widen_ranges(robot.calibration_ranges, plan.approach_offset_rad)


_S_PER_MIN = 60.0


def first_pass(plan: SessionPlan, cell: SessionCell) -> Text:
    """Return the sentence for a robot that has finished no session yet, else nothing."""
    if not cell.first_pass:
        return ""
    run = dry_run(plan, cell.robot, cell.base, cell.nests, len(cell.fixed_nests))
    speed = binding_speed(plan, cell.speed_limits)
    return message(
        "session.first_session",
        configurations=run.configurations,
        moves=run.moves,
        minutes=run.duration_s / _S_PER_MIN,
        speed_mm_s=speed.tool_speed_mm_s,
    )


_STATED_WITHIN_S: Final = 1.0  # of wall time; a question is not kept waiting for it


async def obstructions_ahead(
    ways: KnownWays, robot: RobotController, stops: Sequence[PlannedStop], approach_offset_rad: float | None
) -> Text:
    """Return on which ways to `stops` something would touch, from where the arm stands where that is known.

    Empty where all look clear.
    """
    if not stops:
        return ""
    # The way from here is nobody's choice, and the arm may be moved by hand before somebody confirms: so it
    # is said and never refuses (decision 0019).
    here_rad = await _stands_at(robot, len(stops[0].joints_rad))
    return await ways.what_to_watch(ways_between(stops, approach_offset_rad, here_rad))


async def _stands_at(robot: RobotController, joints: int) -> tuple[float, ...] | None:
    """Return where the arm is; None where its controller is not connected or does not say so."""
    if not robot.connected:
        return None
    try:
        async with asyncio.timeout(_STATED_WITHIN_S):
            stated_rad = (await robot.read_joints()).joints_rad
    except (TimeoutError, DriverError):  # whoever moves the arm asks again, and says what is wrong
        return None
    return stated_rad if len(stated_rad) == joints else None
