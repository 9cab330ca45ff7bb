"""What forbids motion, within which limits the arm moves, and what this program cannot do about a motion.

This software is not the safety function: enclosure, enabling device and emergency stop are. The
interlocks only keep a measuring programme from starting motions that nobody expects.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from typing import Final

import numpy as np

from truepose.domain.ballbar import BallbarPlan
from truepose.domain.contacts import ContactPlan
from truepose.domain.robot import JointRange, Robot
from truepose.domain.session import SessionPlan, SessionState
from truepose.messages.message import Message, Text, message, together
from truepose.sessions.engine.states import words
from truepose.sessions.errors import PlanRefusedError
from truepose_drivers.api import GuardsMotion, JointReading, MotionGuard, MotionLimits

MAX_STATE_AGE_S: Final = 2.0  # of the robot's own statement where it is, in cell time

_SLACK_RAD = 1e-9  # a target on the limit is inside it; limits come from degrees


@dataclass(frozen=True, slots=True)
class MotionConditions:
    """Everything that is known when a motion is about to start."""

    state: SessionState
    stop_requested: bool  # a pause or the end was asked for, perhaps not yet on record
    question: Text | None  # what a person is asked at this moment
    robot_connected: bool
    reading: JointReading
    now_s: float
    left_at_rad: tuple[float, ...] | None  # where the last motion ended; None: a person has just confirmed
    tolerance_rad: float
    obstacle: Text | None = None  # anything else that forbids motion, as a sentence
    max_state_age_s: float = MAX_STATE_AGE_S


def motion_obstacle(
    conditions: MotionConditions, target_rad: tuple[float, ...], limits: Sequence[JointRange]
) -> Text | None:
    """Return one sentence that says why nothing may move, None where nothing speaks against it."""
    # Session first, then robot, then target: a person is told what to do about the outermost thing that is
    # wrong.
    return (
        _forbidden_by_the_session(conditions)
        or _forbidden_by_the_robot_state(conditions)
        or _forbidden_by_the_target(target_rad, limits)
    )


def _forbidden_by_the_session(conditions: MotionConditions) -> Text | None:
    if conditions.state is not SessionState.RUNNING:
        return message("session.forbidden.state", state=words(conditions.state))
    if conditions.stop_requested:
        return message("session.forbidden.asked")
    if conditions.question is not None:
        return message("session.forbidden.question")
    return conditions.obstacle


def _forbidden_by_the_robot_state(conditions: MotionConditions) -> Text | None:
    if not conditions.robot_connected:
        return message("session.forbidden.link")
    age_s = conditions.now_s - conditions.reading.time_s
    limit_s = conditions.max_state_age_s
    # A statement from the future by more than that is refused too: the clock began anew, and nobody knows how
    # old it is. So is a NaN.
    if not -limit_s <= age_s <= limit_s:
        return message("session.forbidden.old", age_s=age_s, limit_s=limit_s)
    return _moved_by_others(conditions)


def _moved_by_others(conditions: MotionConditions) -> Text | None:
    left_at = conditions.left_at_rad
    # A person has just confirmed where the arm stands.
    if left_at is None:
        return None
    reported = conditions.reading.joints_rad
    if len(left_at) != len(reported):
        return message("session.joints.where", reported=len(reported), expected=len(left_at))
    off = np.abs(np.subtract(reported, left_at))
    # A controller that rounds its joints states another angle than it was sent; that is no motion by others.
    allowed = conditions.tolerance_rad + conditions.reading.resolution_rad
    if np.all(off <= allowed):  # a NaN is not: it forbids
        return None
    worst = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
    return message("session.joint.moved", joint=worst + 1, off_deg=np.degrees(off[worst]))


def _forbidden_by_the_target(target_rad: tuple[float, ...], limits: Sequence[JointRange]) -> Text | None:
    outside = joint_outside(target_rad, limits)
    return None if outside is None else message("session.forbidden.outside", outside=outside)


def joint_outside(target_rad: tuple[float, ...], limits: Sequence[JointRange]) -> Text | None:
    """Return which joint of a target is outside its limits and by how much, None where all are inside."""
    for number, (angle, limit) in enumerate(zip(target_rad, limits, strict=True), start=1):
        if not limit.lower_rad - _SLACK_RAD <= angle <= limit.upper_rad + _SLACK_RAD:
            low, high = np.degrees((limit.lower_rad, limit.upper_rad))
            return message(
                "session.outside", joint=number, angle_deg=np.degrees(angle), low_deg=low, high_deg=high
            )
    return None


_REDUCED_MM_S: Final = 250.0  # ISO 10218-1: reduced speed control


def common_ranges(
    first: tuple[JointRange, ...] | None, second: tuple[JointRange, ...] | None
) -> tuple[JointRange, ...] | None:
    """Return what lies within both; None, which is unknown, binds nothing. Raises PlanRefusedError."""
    if first is None or second is None:
        return first or second
    if len(first) != len(second):
        raise PlanRefusedError(message("session.limits.other_robot", planned=len(first), present=len(second)))
    return tuple(
        JointRange(max(a.lower_rad, b.lower_rad), min(a.upper_rad, b.upper_rad))
        for a, b in zip(first, second, strict=True)
    )


def motion_limits(robot: Robot, joint_limits: tuple[JointRange, ...] | None) -> tuple[JointRange, ...]:
    """Return what every move must keep to; raises PlanRefusedError where nothing is known."""
    # What the cell says comes before what the robot's description says. Without any of them nothing moves.
    known = joint_limits or robot.joint_limits or robot.calibration_ranges
    if known is None:
        raise PlanRefusedError(message("session.limits.unknown"))
    return known


def binding_speed(
    planned: SessionPlan | BallbarPlan | ContactPlan, limits: MotionLimits | None
) -> MotionLimits:
    """Return the speed of a session's motions: as planned, and never above the limits of its cell."""
    speed = MotionLimits(planned.tool_speed_mm_s, planned.orientation_speed_rad_s)
    # The tighter of plan and cell, at the act: a session once moved at the speed it was planned with, in a
    # cell that had been slowed down since (decision 0019).
    return slowest(speed, limits or speed)


def reduced_limits(limits: MotionLimits) -> MotionLimits:
    """Return the limits of a robot whose plans nobody has seen run: the standard's reduced speed."""
    return slowest(limits, MotionLimits(_REDUCED_MM_S, limits.orientation_speed_rad_s))


def slowest(*limits: MotionLimits) -> MotionLimits:
    """Return the lowest speed of each kind."""
    return MotionLimits(
        min(limit.tool_speed_mm_s for limit in limits),
        min(limit.orientation_speed_rad_s for limit in limits),
    )


def speed_sentence(speed: MotionLimits, guard: MotionGuard) -> Message:
    """Return what keeps the arm to its speed, for the record."""
    kept = "session.speed.stated" if guard.speed_read_back else "session.speed.unasked"
    speed_deg_s = math.degrees(speed.orientation_speed_rad_s)
    return message(kept, speed_mm_s=speed.tool_speed_mm_s, speed_deg_s=speed_deg_s)


def end_of_motion(controller: GuardsMotion) -> Message:
    """Return when the arm comes to rest after a pause or the end was asked for, as the end of a sentence."""
    guard = controller.motion_guard
    if guard.longest_piece_s is None:
        return message("session.end_of_motion.whole")
    if guard.speed_share is None:
        return message("session.end_of_motion.piece_at_full_speed", longest_s=guard.longest_piece_s)
    return message("session.end_of_motion.piece", longest_s=guard.longest_piece_s)


def motion_notice(guard: MotionGuard) -> Text:
    """Return what whoever lets the arm move has to know of this controller, in two sentences."""
    return together(message("session.notice.only"), _left_alone(guard))


def _left_alone(guard: MotionGuard) -> Message:
    """Return what the arm does where program or connection fails while it moves."""
    # The best first: a controller that watches its program makes pieces unnecessary.
    if guard.stops_unheard_s is not None:
        return message("session.notice.stops", seconds=guard.stops_unheard_s)
    if guard.longest_piece_s is None:
        return message("session.notice.target")
    # Pieces are cut for the speed override that holds, where the controller tells it.
    if guard.speed_share is None:
        return message("session.notice.piece_at_full_speed", seconds=guard.longest_piece_s)
    return message("session.notice.piece", seconds=guard.longest_piece_s)


def check_numbers(plan: SessionPlan | BallbarPlan | ContactPlan, *positive: str) -> None:
    """Raise PlanRefusedError for the first of the `positive` that is not, or for a negative rest."""
    for name in positive:
        value = getattr(plan, name)
        if not 0 < value < inf:
            raise PlanRefusedError(message("plan.refused.not_above_zero", name=name, value=value))
    if not 0 <= plan.settle_s < inf:
        raise PlanRefusedError(message("plan.refused.settle", settle_s=plan.settle_s))
