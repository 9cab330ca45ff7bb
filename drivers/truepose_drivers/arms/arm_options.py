"""The options of a cell file that say what an arm is like; every complaint names the option."""

import math
from typing import Final

from truepose_drivers import options as option
from truepose_drivers.api import Options
from truepose_drivers.arms.joint_counting import LR_MATE_SIGNS, JointCounting
from truepose_drivers.arms.pace import Pace
from truepose_drivers.errors import ConfigurationError

_JOINTS = 6

COUNTING_OPTIONS: Final = {
    "joint_3_from": 'what the controller counts joint 3 from: "horizontal" (FANUC\'s own) or "upper arm"',
    "signs": "-1 for each joint that the robot file counts the other way round, 1 1 -1 -1 -1 -1 if left out",
}
PACE_OPTIONS: Final = {
    "joint_speeds_deg_s": "greatest speeds of the six joints, those of the LR Mate 200iC if left out",
    "reach_mm": "farthest that the tool can be from any joint axis, 1000 if left out",
    "tool_reach_mm": "farthest that the tool can be from the axes of the wrist, 400 if left out",
}


def counting(options: Options) -> JointCounting:
    """Return how joints are counted; raises ConfigurationError."""
    origin = option.text(options, "joint_3_from") or "horizontal"
    if origin not in {"horizontal", "upper arm"}:
        raise ConfigurationError(f'option joint_3_from is {origin!r}: give "horizontal" or "upper arm"')
    return JointCounting(signs(options, LR_MATE_SIGNS), origin == "horizontal")


def signs(options: Options, default: tuple[int, ...]) -> tuple[int, ...]:
    """Return which joints are counted the other way round; raises ConfigurationError."""
    stated = _six(options, "signs", default)
    if not all(abs(sign) == 1.0 for sign in stated):
        raise ConfigurationError("option signs must be six times 1 or -1, such as 1 1 -1 -1 -1 -1")
    return tuple(map(int, stated))


def pace(options: Options, default: Pace | None = None) -> Pace:
    """Return how fast the arm can be; raises ConfigurationError."""
    default = default or Pace()
    speeds = _six(options, "joint_speeds_deg_s", default.joint_speeds_deg_s)
    if not all(0.0 < speed < math.inf for speed in speeds):
        raise ConfigurationError("option joint_speeds_deg_s must be six positive numbers")
    return Pace(
        speeds,
        option.positive(options, "reach_mm", default.reach_mm),
        option.positive(options, "tool_reach_mm", default.tool_reach_mm),
    )


def _six(options: Options, name: str, default: tuple[float, ...]) -> tuple[float, ...]:
    words = option.text(options, name)
    if words is None:
        return default
    try:
        numbers = tuple(map(float, words.split()))
    except ValueError as error:
        raise ConfigurationError(f"option {name} is {words!r}: give six numbers") from error
    if len(numbers) != _JOINTS:
        raise ConfigurationError(f"option {name} is {words!r}: give six numbers")
    return numbers
