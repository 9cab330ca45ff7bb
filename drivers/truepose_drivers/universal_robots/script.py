"""The script that moves the arm, the registers by which it hears and answers, and the controller's modes.

It is sent whole for every motion and ends with it. It moves only while the beat changes: whoever sent it and
is gone has the arm stopped. Registers 24 to 47 are those of RTDE clients (RTDE guide, as are the numbers of
modes), functions those of the maker's script manual.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from enum import IntEnum
from typing import Final

from truepose_drivers.universal_robots.protocol import Values


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
    RobotMode.POWER_ON: "the arm is powering up: wait, then release the brakes",
    RobotMode.IDLE: "the brakes are on: release them on the pendant",
    RobotMode.BACKDRIVE: "the arm is in backdrive mode: end it on the pendant",
    RobotMode.CONFIRM_SAFETY: "confirm the safety settings on the pendant",
}
_OF_SAFETY: Final[Mapping[int, str]] = {
    SafetyMode.PROTECTIVE_STOP: "it made a protective stop: see what it touched, then unlock it there",
    SafetyMode.RECOVERY: "it is in recovery mode: move it back within its limits on the pendant",
    SafetyMode.SAFEGUARD_STOP: "a safeguard stops it: close the guard, then reset it",
    SafetyMode.SYSTEM_EMERGENCY_STOP: "the emergency stop of the cell is pressed: release it",
    SafetyMode.ROBOT_EMERGENCY_STOP: "its emergency stop is pressed: release it and switch the arm on",
    SafetyMode.VIOLATION: "a safety limit was violated: restart the safety system on the pendant",
    SafetyMode.FAULT: "its safety system has a fault: check the pendant and restart it",
}


def obstacle(robot_mode: int, safety_mode: int) -> str | None:
    """Say what keeps the arm from moving, None where nothing does."""
    if safety_mode not in MOVES_IN:
        other = f"its safety system is in mode {safety_mode}: check the pendant"
        return _OF_SAFETY.get(safety_mode, other)
    if robot_mode != RobotMode.RUNNING:
        return _OF_MODE.get(robot_mode, f"it is in mode {robot_mode}: check the pendant")
    return None


SCRIPT_PORT: Final = 30002
JOINTS: Final = 6
SILENCE_S: Final = 0.6  # without a new beat, after which the program stops the arm
BEAT_S: Final = 0.1  # so often the driver gives a new one
STOPS_WITHIN_S: Final = 1.0  # silence, and the fastest joint's deceleration with some margin
FASTEST_RAD_S: Final = 1.0  # of any joint
STOP_RAD_S2: Final = 4.0
_START_RAD_S2: Final = 1.0
_SECTIONS: Final = 32  # of the way, in each of which the speeds are kept

_NUMBER: Final = "input_int_register_24"
_BEAT: Final = "input_int_register_25"
_TARGET: Final = tuple(f"input_double_register_{24 + joint}" for joint in range(JOINTS))
_TOOL_SPEED: Final = "input_double_register_30"  # m/s
_TURNING_SPEED: Final = "input_double_register_31"  # rad/s
ARRIVED: Final = "output_int_register_24"
GIVEN_UP: Final = "output_int_register_25"
BEGUN: Final = "output_int_register_26"

INPUTS: Final[Mapping[str, str]] = {
    _NUMBER: "INT32",
    _BEAT: "INT32",
    **dict.fromkeys((*_TARGET, _TOOL_SPEED, _TURNING_SPEED), "DOUBLE"),
}
OUTPUTS: Final[Mapping[str, str]] = {
    "timestamp": "DOUBLE",
    "actual_q": "VECTOR6D",
    "robot_mode": "INT32",
    "safety_mode": "INT32",
    "runtime_state": "UINT32",
    **dict.fromkeys((ARRIVED, GIVEN_UP, BEGUN), "INT32"),
    **INPUTS,
}
_LARGEST_COUNT: Final = 2**30
_MM_PER_M: Final = 1000.0


@dataclass(frozen=True, slots=True)
class Order:
    """What the registers ask of the program."""

    number: int = 0  # of the motion
    beat: int = 0
    target_rad: tuple[float, ...] = (0.0,) * JOINTS
    tool_speed_mm_s: float = 0.0
    turning_speed_rad_s: float = 0.0

    def values(self) -> Values:
        """Return the order as registers."""
        speeds = (self.tool_speed_mm_s / _MM_PER_M, self.turning_speed_rad_s)
        numbers = (self.number, self.beat, *self.target_rad, *speeds)
        return {name: (number,) for name, number in zip(INPUTS, numbers, strict=True)}

    @property
    def next_beat(self) -> "Order":
        """The same with a new beat."""
        return replace(self, beat=following(self.beat))


def order_in(values: Values) -> Order:
    """Return what registers ask of the program."""
    return Order(
        number=int(values[_NUMBER][0]),
        beat=int(values[_BEAT][0]),
        target_rad=tuple(values[name][0] for name in _TARGET),
        tool_speed_mm_s=values[_TOOL_SPEED][0] * _MM_PER_M,
        turning_speed_rad_s=values[_TURNING_SPEED][0],
    )


@dataclass(frozen=True, slots=True)
class RobotState:
    """What one data packet says."""

    timestamp_s: float  # of the controller's own clock
    joints_rad: tuple[float, ...]
    robot_mode: int  # RobotMode, or a number that came later
    safety_mode: int
    runtime_state: int
    arrived: int  # number of the motion that ended last, at rest at its target
    given_up: int  # and of the one that was stopped because nothing was heard
    begun: int
    registers: Values  # of the inputs, as they stand

    @property
    def plays(self) -> bool:
        """Whether a program runs, or may go on."""
        return self.runtime_state != RuntimeState.STOPPED

    @property
    def unused_number(self) -> int:
        """A number that no motion has had lately, nor the one before."""
        return following(max(self.arrived, self.given_up, self.begun, int(self.registers[_NUMBER][0])))


def robot_state(values: Values) -> RobotState:
    """Return what the fields of a data packet mean."""
    return RobotState(
        timestamp_s=values["timestamp"][0],
        joints_rad=values["actual_q"],
        robot_mode=int(values["robot_mode"][0]),
        safety_mode=int(values["safety_mode"][0]),
        runtime_state=int(values["runtime_state"][0]),
        arrived=int(values[ARRIVED][0]),
        given_up=int(values[GIVEN_UP][0]),
        begun=int(values[BEGUN][0]),
        registers={name: values[name] for name in INPUTS},
    )


def following(count: int) -> int:
    """Return the count after `count`, from 1 on and well within 32 bits."""
    return max(count, 0) % _LARGEST_COUNT + 1


PROGRAM_NAME: Final = "truepose_motion_1"
PROGRAM: Final = f"""\
def {PROGRAM_NAME}():
  global number = read_input_integer_register(24)
  global beat = read_input_integer_register(25)
  global target = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
  global tool_speed = read_input_float_register(30)
  global turning_speed = read_input_float_register(31)
  global unheard = 0.0
  global arrived = False

  def between(start, share):
    local joints = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    local joint = 0
    while joint < 6:
      joints[joint] = start[joint] + share * (target[joint] - start[joint])
      joint = joint + 1
    end
    return joints
  end

  def longest_turn(start):
    local longest = 0.0
    local joint = 0
    while joint < 6:
      if norm(target[joint] - start[joint]) > longest:
        longest = norm(target[joint] - start[joint])
      end
      joint = joint + 1
    end
    return longest
  end

  # Shares of the way per second at which neither joints nor tool are too fast in any section of it.
  def pace_of(start, longest):
    local pace = {FASTEST_RAD_S} / longest
    local before = get_forward_kin(start)
    local here = before
    local change = before
    local moved = 0.0
    local turned = 0.0
    local section = 1
    while section <= {_SECTIONS}:
      here = get_forward_kin(between(start, section / {_SECTIONS}.0))
      change = pose_trans(pose_inv(before), here)
      moved = norm([change[0], change[1], change[2]]) * {_SECTIONS}.0
      turned = norm([change[3], change[4], change[5]]) * {_SECTIONS}.0
      if moved * pace > tool_speed:
        pace = tool_speed / moved
      end
      if turned * pace > turning_speed:
        pace = turning_speed / turned
      end
      before = here
      section = section + 1
    end
    return pace
  end

  thread move():
    start = get_target_joint_positions()
    longest = longest_turn(start)
    if longest > 0.0:
      movej(target, a={_START_RAD_S2}, v=longest * pace_of(start, longest), r=0)
    end
    while not is_steady():
      sync()
    end
    arrived = True
  end

  def listen():
    if read_input_integer_register(25) == beat:
      unheard = unheard + get_steptime()
    else:
      beat = read_input_integer_register(25)
      unheard = 0.0
    end
    sync()
  end

  joint = 0
  while joint < 6:
    target[joint] = read_input_float_register(24 + joint)
    joint = joint + 1
  end
  write_output_integer_register(26, number)
  # Nothing moves before somebody was heard.
  first = beat
  while beat == first and unheard < {SILENCE_S}:
    listen()
  end
  if unheard < {SILENCE_S}:
    mover = run move()
    while not arrived and unheard < {SILENCE_S}:
      listen()
    end
    if arrived:
      write_output_integer_register(24, number)
    else:
      kill mover
      stopj({STOP_RAD_S2})
    end
  end
  if not arrived:
    write_output_integer_register(25, number)
  end
end
"""
