"""What becomes of a motion, judged by the controller's state alone."""

import math

from truepose_drivers.arm_motion import farthest_off, stopped_unheard, target_refused
from truepose_drivers.errors import (
    DeviceRefusedError,
    NoReplyError,
    NotInitialisedError,
)
from truepose_drivers.universal_robots.script import SILENCE_S, Order, RobotState, obstacle

# A standing joint is held by its servo, and what it reports wanders.
STANDING_RAD = 1e-4
_BEGINS_WITHIN_S = 5.0  # to be received, compiled and started
_STANDS_AT_MOST_S = 20.0  # under way, at a slow speed slider or paused by somebody
_ENDED_FOR_S = 0.2  # the registers may be a packet ahead of the state of the program


def require_ready(state: RobotState) -> None:
    """Raise NotInitialisedError where the arm may not move, or moves already."""
    what = obstacle(state.robot_mode, state.safety_mode)
    if what is not None:
        raise NotInitialisedError(f"the robot cannot move: {what}; then confirm")
    if state.plays:
        raise NotInitialisedError(
            "another program runs on the robot: stop it on the pendant, so that nobody else moves the arm"
        )


class Progress:
    """One motion, from the moment at which it was ordered [s, any clock]."""

    def __init__(self, order: Order, before: RobotState, now_s: float) -> None:
        self._order = order
        self._before = before
        self._moved_s = self._running_s = now_s
        self._ordered_s = now_s
        self._stood_rad = before.joints_rad
        self._begun = False

    def arrived(self, state: RobotState, now_s: float, said: str = "") -> bool:
        """Whether the arm rests at its target; raises a DriverError where it never will.

        `said` is what the controller told people meanwhile.
        """
        self._require_no_stop(state)
        if state.arrived == self._order.number and not state.plays:
            return True
        self._note(state, now_s)
        self._require_begun(now_s, said)
        self._require_running(state, now_s, said)
        self._require_motion(now_s)
        return False

    def _require_no_stop(self, state: RobotState) -> None:
        what = obstacle(state.robot_mode, state.safety_mode)
        if what is not None:
            raise NotInitialisedError(f"the robot stopped during the motion: {what}; then confirm")
        if state.given_up == self._order.number:
            raise stopped_unheard(SILENCE_S)

    def _note(self, state: RobotState, now_s: float) -> None:
        self._begun = self._begun or state.begun == self._order.number
        if state.plays or not self._begun:
            self._running_s = now_s
        if not self._begun or farthest_off(state.joints_rad, self._stood_rad) > STANDING_RAD:
            self._moved_s = now_s
            self._stood_rad = state.joints_rad

    def _require_begun(self, now_s: float, said: str) -> None:
        if not self._begun and now_s - self._ordered_s > _BEGINS_WITHIN_S:
            raise NotInitialisedError(
                "the robot did not begin the motion: set it to remote control on the pendant and check there"
                f" for messages{_quoted(said)}"
            )

    def _require_running(self, state: RobotState, now_s: float, said: str) -> None:
        if now_s - self._running_s <= _ENDED_FOR_S:
            return
        raise self._broken_off(state, said)

    def _broken_off(self, state: RobotState, said: str) -> DeviceRefusedError:
        # The state does not say why a program ended; but an arm that never moved was refused its target.
        if farthest_off(state.joints_rad, self._before.joints_rad) <= STANDING_RAD:
            target_deg = [math.degrees(angle) for angle in self._order.target_rad]
            return target_refused(target_deg, f": check the pendant for the reason{_quoted(said)}")
        return NotInitialisedError(
            f"the motion was interrupted: check the pendant for the reason{_quoted(said)}, then confirm"
        )

    def _require_motion(self, now_s: float) -> None:
        if now_s - self._moved_s > _STANDS_AT_MOST_S:
            raise NoReplyError(
                f"the robot has not moved for {_STANDS_AT_MOST_S:g} s and has not reached its target: check"
                " the pendant for a paused program, then connect again"
            )


def _quoted(said: str) -> str:
    return f' (the robot says "{said[:120]}")' if said else ""
