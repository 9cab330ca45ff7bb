"""Whether a plan of closed loops can be done, before anything moves; and how long it takes."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.contacts import FREE_PLACES, ContactPlan, ContactStop, Joints
from truepose.domain.robot import FramePlacement, JointRange, Robot
from truepose.messages.message import message
from truepose.planning.workspace.path_clearance import Ways
from truepose.sessions.contact.state import Visit, steps
from truepose.sessions.engine.interlocks import check_numbers, joint_outside
from truepose.sessions.engine.nominal_arm import nominal_chain
from truepose.sessions.errors import PlanRefusedError

_POSITIVE: Final = (
    "stroke_mm", "reading_u_mm", "samples", "tool_speed_mm_s", "orientation_speed_rad_s", "touch_speed_mm_s",
    "failures_in_a_row",
)  # fmt: skip


def check_plan(plan: ContactPlan, robot: Robot, base: FramePlacement, limits: tuple[JointRange, ...]) -> None:
    """Raise PlanRefusedError, with one sentence, for the first thing that cannot be done as planned."""
    check_numbers(plan, *_POSITIVE)
    if not 0.0 <= plan.margin_mm < plan.stroke_mm / 2:
        raise PlanRefusedError(message("plan.refused.margin", margin_mm=plan.margin_mm))
    if not plan.stops:
        raise PlanRefusedError(message("plan.refused.no_stop"))
    if len({stop.config for stop in plan.stops}) < len(plan.stops):
        raise PlanRefusedError(message("plan.refused.some_configuration_twice"))
    for stop in plan.stops:
        _check_stop(plan, stop, robot, limits)
        if plan.touches:
            _check_last_steps(plan, stop, robot, base)


def _check_stop(plan: ContactPlan, stop: ContactStop, robot: Robot, limits: tuple[JointRange, ...]) -> None:
    unknown = set(stop.targets) - {target.number for target in plan.targets}
    if unknown or not stop.targets:
        raise PlanRefusedError(message("plan.refused.target", config=stop.config))
    for joints_rad in stop.way_rad:
        if len(joints_rad) != robot.n_joints or not np.all(np.isfinite(joints_rad)):
            raise PlanRefusedError(
                message("plan.refused.joints_of_configuration", config=stop.config, joints=robot.n_joints)
            )
        outside = joint_outside(joints_rad, limits)
        if outside is not None:
            raise PlanRefusedError(message("plan.refused.way_outside", config=stop.config, outside=outside))


def _check_last_steps(plan: ContactPlan, stop: ContactStop, robot: Robot, base: FramePlacement) -> None:
    """See that the steps on which something may be touched are no longer than half a stroke."""
    if len(stop.way_rad) <= FREE_PLACES:
        raise PlanRefusedError(message("plan.refused.reached_at_once", config=stop.config))
    flange = nominal_chain(robot, base, np.array(stop.way_rad[FREE_PLACES - 1 :])).origin[-1]
    steps_mm = np.linalg.norm(np.diff(flange, axis=0), axis=1)
    # Gauges are looked at between two steps only, so that a step has to be short against their stroke.
    if steps_mm.size and steps_mm.max() > 0.5 * plan.stroke_mm + 1e-6:
        raise PlanRefusedError(
            message(
                "plan.refused.long_step",
                config=stop.config,
                step_mm=steps_mm.max(),
                half_mm=0.5 * plan.stroke_mm,
            )
        )


def ways_to(stops: Sequence[ContactStop]) -> Ways:
    """Return the motions of a session to its stops, from the first on; the ways back are the same ones."""
    names, starts, ends = [], [], []
    for before, stop in zip((None, *stops), stops, strict=False):
        # From the place at which the way before began, and not from its stop: the arm goes back there first.
        passed = (*(() if before is None else before.way_rad[:1]), *stop.way_rad)
        for start, end in pairwise(passed):
            names.append(message("room.way.to_configuration", config=stop.config))
            starts.append(start)
            ends.append(end)
    joints = len(stops[0].joints_rad)
    return Ways(tuple(names), np.array(starts).reshape(-1, joints), np.array(ends).reshape(-1, joints))


def minutes_of(plan: ContactPlan, robot: Robot, base: FramePlacement) -> float:
    """Return about how long a plan takes [min], persons not included."""
    seconds = 0.0
    for joints_rad in _passed(plan):
        tool_mm = nominal_chain(robot, base, np.array(joints_rad)).origin[-1]
        path_mm = np.linalg.norm(np.diff(tool_mm, axis=0), axis=1)
        # Twice: the arm leaves by the way it came.
        creeps = 2 * path_mm[FREE_PLACES - 1 :].sum() / plan.touch_speed_mm_s if plan.touches else 0.0
        seconds += 2 * path_mm[: FREE_PLACES - 1].sum() / plan.tool_speed_mm_s + creeps + 2 * plan.settle_s
    return float(seconds / 60.0)


def _passed(plan: ContactPlan) -> Iterator[tuple[Joints, ...]]:
    return (step.stop.way_rad for step in steps(plan) if isinstance(step, Visit))
