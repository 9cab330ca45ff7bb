"""What the controller says of itself; numbers from the maker's RTDE guide."""

from collections.abc import Mapping
from enum import IntEnum
from typing import Final


class RobotMode(IntEnum):
    """How far the arm is switched on."""

    NO_CONTROLLER = -1
    DISCONNECTED = 0
    CONFIRM_SAFETY = 1
    BOOTING = 2
    POWER_OFF = 3
    POWER_ON = 4
    IDLE = 5
    BACKDRIVE = 6
    RUNNING = 7
    UPDATING_FIRMWARE = 8


class SafetyMode(IntEnum):
    """What the safety system allows."""

    NORMAL = 1
    REDUCED = 2
    PROTECTIVE_STOP = 3
    RECOVERY = 4
    SAFEGUARD_STOP = 5
    SYSTEM_EMERGENCY_STOP = 6
    ROBOT_EMERGENCY_STOP = 7
    VIOLATION = 8
    FAULT = 9
    VALIDATE_JOINT_ID = 10
    UNDEFINED = 11


class RuntimeState(IntEnum):
    """What the program does."""

    STOPPING = 0
    STOPPED = 1
    PLAYING = 2
    PAUSING = 3
    PAUSED = 4
    RESUMING = 5


MOVES_IN: Final = frozenset({SafetyMode.NORMAL, SafetyMode.REDUCED})

_OF_MODE: Final[Mapping[int, str]] = {
    RobotMode.POWER_OFF: "the arm is switched off: switch it on and release the brakes",
    RobotMode.POWER_ON: "the arm is being switched on: wait, then release the brakes",
    RobotMode.IDLE: "the brakes are on: release them on the pendant",
    RobotMode.BACKDRIVE: "the arm is moved by hand: end that on the pendant",
    RobotMode.CONFIRM_SAFETY: "the safety settings wait to be confirmed on the pendant",
}
_OF_SAFETY: Final[Mapping[int, str]] = {
    SafetyMode.PROTECTIVE_STOP: "it made a protective stop: see what it touched, then unlock it there",
    SafetyMode.RECOVERY: "it is in recovery mode: move it back within its limits on the pendant",
    SafetyMode.SAFEGUARD_STOP: "a safeguard stops it: close the guard, then reset it",
    SafetyMode.SYSTEM_EMERGENCY_STOP: "the emergency stop of the cell is pressed: release it",
    SafetyMode.ROBOT_EMERGENCY_STOP: "its emergency stop is pressed: release it and switch the arm on",
    SafetyMode.VIOLATION: "a safety limit was violated: restart the safety system on the pendant",
    SafetyMode.FAULT: "its safety system has a fault: look at the pendant and restart it",
}


def obstacle(robot_mode: int, safety_mode: int) -> str | None:
    """Say what keeps the arm from moving, None where nothing does."""
    if safety_mode not in MOVES_IN:
        other = f"its safety system is in mode {safety_mode}: look at the pendant"
        return _OF_SAFETY.get(safety_mode, other)
    if robot_mode != RobotMode.RUNNING:
        return _OF_MODE.get(robot_mode, f"it is in mode {robot_mode}: look at the pendant")
    return None
