"""What forbids motion. Pure: the runner states the conditions, this says no, or nothing.

This software is not the safety function: enclosure, enabling device and emergency stop are. The
interlocks only keep a measuring programme from starting motions that nobody expects.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.measurement.session import SessionState
from truepose.domain.robot import JointRange
from truepose.sequencing.engine.states import words
from truepose_drivers.api import JointReading

MAX_STATE_AGE_S: Final = 2.0  # of the robot's own statement where it is, in cell time

_SLACK_RAD = 1e-9  # a target on the limit is inside it; limits come from degrees


@dataclass(frozen=True, slots=True)
class MotionConditions:
    """Everything that is known when a motion is about to start."""

    state: SessionState
    stop_requested: bool  # a pause or the end was asked for, perhaps not yet on record
    question: str | None  # what a person is asked at this moment
    robot_connected: bool
    reading: JointReading
    now_s: float
    left_at_rad: tuple[float, ...] | None  # where the last motion ended; None: a person has just confirmed
    tolerance_rad: float
    obstacle: str | None = None  # anything else that forbids motion, as a sentence
    max_state_age_s: float = MAX_STATE_AGE_S


def what_forbids_motion(
    conditions: MotionConditions, target_rad: tuple[float, ...], limits: Sequence[JointRange]
) -> str | None:
    """Return one sentence that says why nothing may move, None where nothing speaks against it."""
    return (
        _forbidden_by_the_session(conditions)
        or _forbidden_by_the_robot_state(conditions)
        or _forbidden_by_the_target(target_rad, limits)
    )


def _forbidden_by_the_session(conditions: MotionConditions) -> str | None:
    if conditions.state is not SessionState.RUNNING:
        return f"The session is {words(conditions.state)}; nothing moves before a person has it continue."
    if conditions.stop_requested:
        return "A pause or the end of the session was asked for; nothing more moves."
    if conditions.question is not None:
        return "A question to a person is open; nothing moves before it is answered."
    return conditions.obstacle


def _forbidden_by_the_robot_state(conditions: MotionConditions) -> str | None:
    if not conditions.robot_connected:
        return "The link to the robot is down; nothing moves before it is up and a person has confirmed."
    age_s = conditions.now_s - conditions.reading.time_s
    limit_s = conditions.max_state_age_s
    if not -limit_s <= age_s <= limit_s:
        return f"The robot's statement of its joints is {age_s:.1f} s old; the limit is {limit_s:g} s."
    return _moved_by_others(conditions)


def _moved_by_others(conditions: MotionConditions) -> str | None:
    left_at = conditions.left_at_rad
    if left_at is None:
        return None
    reported = conditions.reading.joints_rad
    if len(left_at) != len(reported):
        return f"The robot reports {len(reported)} joints where {len(left_at)} were commanded."
    off = np.abs(np.subtract(reported, left_at))
    allowed = conditions.tolerance_rad + conditions.reading.resolution_rad
    if np.all(off <= allowed):  # a NaN is not: it forbids
        return None
    worst = int(np.argmax(np.nan_to_num(off, nan=np.inf)))
    return f"Joint {worst + 1} is {np.degrees(off[worst]):.2f} deg away from where the last motion left it."


def _forbidden_by_the_target(target_rad: tuple[float, ...], limits: Sequence[JointRange]) -> str | None:
    outside = joint_outside(target_rad, limits)
    return None if outside is None else f"The target lies outside what is allowed: {outside}."


def joint_outside(target_rad: tuple[float, ...], limits: Sequence[JointRange]) -> str | None:
    """Return which joint of a target is outside its limits and by how much, None where all are inside."""
    for number, (angle, limit) in enumerate(zip(target_rad, limits, strict=True), start=1):
        if not limit.lower_rad - _SLACK_RAD <= angle <= limit.upper_rad + _SLACK_RAD:
            low, high = np.degrees((limit.lower_rad, limit.upper_rad))
            return f"joint {number} at {np.degrees(angle):.2f} deg, limits {low:.2f} to {high:.2f} deg"
    return None
