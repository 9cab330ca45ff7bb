"""What an arm is like, by its options in a cell file: how its joints are counted, how fast they turn.

Counting: a FANUC controller counts joint 3 from the horizontal, upwards, and joint 2 forwards: while joint 2
alone moves the forearm keeps its inclination. Counted from the upper arm, in the controller's own direction,
joint 3 is

    j_3 = J_3 + J_2

The other joints are independent. Which way round each joint is counted is a matter of signs.

Sources: measurements on a CRX (package airo-fanuc) and on an ER-4iA in FANUC's own simulator (package
fanuc-python); signs of the LR Mate 200iC: the axes of ros-industrial/fanuc, fanuc_lrmate200ic_support.

Pace: a joint motion turns all joints in step. Joint 2 alone keeps the forearm's inclination and turns no
tool. Axis 1 is across the axis of the inclination, and that across axis 4; axis 5 is across axes 4 and 6:
turns about axes that are across each other add as the sides of a right angle, others by no more than their
sum. The tool's point moves by no more than all joints together, each with the farthest that it can be from
there.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from truepose_drivers import options as option
from truepose_drivers.api import MotionLimits, Options
from truepose_drivers.errors import ConfigurationError, DeviceRefusedError

Angles = tuple[float, ...]

# The shipped table of the LR Mate turns joints 3 to 6 the other way round than its controller.
LR_MATE_SIGNS: Final = (1, 1, -1, -1, -1, -1)


@dataclass(frozen=True, slots=True)
class JointCounting:
    """What turns angles of the controller into those of the robot file; any unit."""

    signs: tuple[int, ...] = LR_MATE_SIGNS  # -1 where the robot file counts the other way round
    from_horizontal: bool = True  # False: the controller counts joint 3 from the upper arm

    def of_robot(self, shown: Angles) -> Angles:
        """Return the angles of the robot file of what the controller shows."""
        first, second, third, *others = shown
        own = (first, second, third + (second if self.from_horizontal else 0.0), *others)
        return self._signed(own)

    def of_controller(self, joints: Angles) -> Angles:
        """Return what the controller shows of angles of the robot file."""
        first, second, third, *others = self._signed(joints)
        return (first, second, third - (second if self.from_horizontal else 0.0), *others)

    def inclined(self, shown: Angles) -> Angles:
        """Return what the controller shows, with the forearm's inclination for joint 3 in any case."""
        first, second, third, *others = shown
        return (first, second, third - (0.0 if self.from_horizontal else second), *others)

    def _signed(self, angles: Angles) -> Angles:
        return tuple(sign * angle for sign, angle in zip(self.signs, angles, strict=True))


# FANUC, "LR Mate 200iC" data sheet.
LR_MATE_SPEEDS_DEG_S = (350.0, 350.0, 400.0, 450.0, 450.0, 720.0)
_WRIST = 3  # joints before the wrist's
# Rounding 1.9 % down to 1 % would nearly double the time of a motion; from 4 % on a fifth is lost at most.
_COARSE_PERCENT = 4.0  # shares below are met by the override: whole ones lie far apart there


@dataclass(frozen=True, slots=True)
class Pace:
    """What must be known of an arm."""

    joint_speeds_deg_s: tuple[float, ...] = LR_MATE_SPEEDS_DEG_S
    reach_mm: float = 1000.0  # farthest of the tool from any axis
    tool_reach_mm: float = 400.0  # farthest of the tool from the wrist's axes

    def least_s(self, steps_deg: Sequence[float], limits: MotionLimits) -> float:
        """Return how long a motion takes at least that keeps the limits.

        `steps_deg` is by how much each joint turns, joint 3 being the forearm's inclination, shape (6,).
        """
        steps_rad = [math.radians(abs(step)) for step in steps_deg]
        arm_rad, wrist_rad = sum(steps_rad[:_WRIST]), sum(steps_rad[_WRIST:])
        path_mm = self.reach_mm * arm_rad + self.tool_reach_mm * wrist_rad
        return max(_turned(steps_rad) / limits.orientation_speed_rad_s, path_mm / limits.tool_speed_mm_s)

    def at_full_speed_s(self, steps_deg: Sequence[float]) -> float:
        """Return how long the joint takes at least that is slowest at its greatest speed.

        No public source says whether the greatest speed of joint 3 is that of the inclination or that
        between upper arm and forearm: the shorter time is taken, so that no share comes out too great.
        """
        return min(self._either_way_s(steps_deg))

    def at_share_s(self, steps_deg: Sequence[float], percent: float) -> float:
        """Return how long a motion takes at most at a share of the joint speeds."""
        return 100.0 * max(self._either_way_s(steps_deg)) / percent

    def share_percent(self, steps_deg: Sequence[float], limits: MotionLimits) -> int:
        """Return the greatest whole share of the joint speeds that keeps the limits, 0 where none does."""
        # 1e-9: a share of 5 % that came out as 4.999... by rounding is not a 4.
        return math.floor(self.exact_share_percent(steps_deg, limits) + 1e-9)

    def exact_share_percent(self, steps_deg: Sequence[float], limits: MotionLimits) -> float:
        """Return the greatest share of the joint speeds that keeps the limits."""
        least_s = self.least_s(steps_deg, limits)
        # No joint turns: any speed keeps the limits, but a controller refuses a share of zero.
        if least_s == 0.0:
            return 1.0
        return min(100.0, 100.0 * self.at_full_speed_s(steps_deg) / least_s)

    def share_and_override(
        self, steps_deg: Sequence[float], limits: MotionLimits, override_percent: int
    ) -> tuple[int, int]:
        """Return the whole share of the joint speeds and the speed override that keep the limits best [%].

        The override is never above `override_percent`. Raises DeviceRefusedError where no speed is so low.
        """
        # As above: a share of 5 % that came out as 4.999... is not to be rounded down to 4.
        share = self.exact_share_percent(steps_deg, limits) + 1e-9
        if share >= _COARSE_PERCENT:
            return math.floor(share), override_percent
        percent = math.ceil(share)
        override = math.floor(100.0 * share / percent)
        if override < 1:
            raise DeviceRefusedError(
                "the robot cannot move as slowly as the speed limits require: raise them"
            )
        return percent, min(override_percent, override)

    def _either_way_s(self, steps_deg: Sequence[float]) -> tuple[float, float]:
        first, second, inclined, *wrist = steps_deg
        return (
            self._slowest_s((first, second, inclined, *wrist)),
            self._slowest_s((first, second, inclined + second, *wrist)),
        )

    def _slowest_s(self, steps_deg: Sequence[float]) -> float:
        return max(abs(step) / speed for step, speed in zip(steps_deg, self.joint_speeds_deg_s, strict=True))


def _turned(steps: Sequence[float]) -> float:
    """Return by how much the tool turns at most, in any posture."""
    first, _, inclined, fourth, fifth, sixth = steps
    return min(
        math.hypot(first, inclined) + math.hypot(fourth, fifth) + sixth,
        math.hypot(first, inclined) + fourth + math.hypot(fifth, sixth),
        first + math.hypot(inclined, fourth) + math.hypot(fifth, sixth),
    )


_JOINTS = 6

COUNTING_OPTIONS: Final = {
    "joint_3_from": 'reference of joint 3 in the controller: "horizontal" (FANUC\'s own) or "upper arm"',
    "signs": "-1 for each joint with the opposite sign in the robot file, default 1 1 -1 -1 -1 -1",
}
PACE_OPTIONS: Final = {
    "joint_speeds_deg_s": "maximum speeds of the six joints; default: those of the LR Mate 200iC",
    "reach_mm": "largest distance of the tool from any joint axis, default 1000",
    "tool_reach_mm": "largest distance of the tool from the wrist axes, default 400",
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
