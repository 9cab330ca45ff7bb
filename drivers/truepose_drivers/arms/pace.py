"""How fast a motion may be, where the controller knows shares of joint speeds or times only.

A joint motion turns all joints in step. Joint 2 alone keeps the forearm's inclination and turns no tool.
Axis 1 is across the axis of the inclination, and that across axis 4; axis 5 is across axes 4 and 6: turns
about axes that are across each other add as the sides of a right angle, others by no more than their sum.
The tool's point moves by no more than all joints together, each with the farthest that it can be from there.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from truepose_drivers.api import MotionLimits
from truepose_drivers.errors import DeviceRefusedError

# FANUC, "LR Mate 200iC" data sheet.
LR_MATE_SPEEDS_DEG_S = (350.0, 350.0, 400.0, 450.0, 450.0, 720.0)
_WRIST = 3  # joints before the wrist's
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
        return math.floor(self.exact_share_percent(steps_deg, limits) + 1e-9)

    def exact_share_percent(self, steps_deg: Sequence[float], limits: MotionLimits) -> float:
        """Return the greatest share of the joint speeds that keeps the limits."""
        least_s = self.least_s(steps_deg, limits)
        if least_s == 0.0:
            return 1.0
        return min(100.0, 100.0 * self.at_full_speed_s(steps_deg) / least_s)

    def share_and_override(
        self, steps_deg: Sequence[float], limits: MotionLimits, override_percent: int
    ) -> tuple[int, int]:
        """Return the whole share of the joint speeds and the speed override that keep the limits best [%].

        The override is never above `override_percent`. Raises DeviceRefusedError where no speed is so low.
        """
        share = self.exact_share_percent(steps_deg, limits) + 1e-9
        if share >= _COARSE_PERCENT:
            return math.floor(share), override_percent
        percent = math.ceil(share)
        override = math.floor(100.0 * share / percent)
        if override < 1:
            raise DeviceRefusedError(
                "the robot knows no speed as low as the limits here ask for: allow more speed"
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
