"""A motion as a row of short ones, whose speeds keep the limits."""

import math
from dataclasses import dataclass
from typing import Final

from truepose_drivers.api import MotionLimits
from truepose_drivers.arm_options import Angles, JointCounting, Pace
from truepose_drivers.errors import DeviceRefusedError
from truepose_drivers.fanuc_rmi.protocol import JOINTS

LONGEST_PIECE_S: Final = 0.8  # of what is sent at once; ramps take up to 0.2 s more
_MOST_PIECES: Final = 2_000
_WHOLE_PERCENT: Final = 100


@dataclass(frozen=True, slots=True)
class Pieces:
    """What is sent for one motion."""

    ends_deg: tuple[Angles, ...]  # as the controller counts its axes
    speed_percent: int  # of the greatest speeds of the joints
    override_percent: int  # that must hold meanwhile; never above the one that held before


@dataclass(frozen=True, slots=True)
class PieceMaker:
    """What must be known of an arm and of the limits."""

    counting: JointCounting
    pace: Pace
    limits: MotionLimits

    def pieces(self, axes_deg: Angles, target_deg: Angles, override_percent: int) -> Pieces:
        """Return the motions from where the axes are to a target of the joints; other axes stay.

        Raises DeviceRefusedError where no speed of the controller keeps the limits.
        """
        steps_deg = self._steps_deg(axes_deg[:JOINTS], target_deg)
        percent, override, duration_s = self._speed(steps_deg, override_percent)
        whole_deg = (*target_deg, *axes_deg[JOINTS:])
        ends_deg = tuple(_between(axes_deg, whole_deg, share) for share in _shares(duration_s))
        return Pieces(ends_deg, percent, override)

    def duration_s(self, start_deg: Angles, target_deg: Angles) -> float:
        """Return how long a motion takes while the pendant leaves the speed to us [s]; raises as `pieces`."""
        return self._speed(self._steps_deg(start_deg, target_deg), _WHOLE_PERCENT)[2]

    def _speed(self, steps_deg: Angles, override_percent: int) -> tuple[int, int, float]:
        """Return share, override and duration [s] of a motion that keeps the limits."""
        percent, override = self.pace.share_and_override(steps_deg, self.limits, override_percent)
        return percent, override, 100.0 * self.pace.at_share_s(steps_deg, percent) / override

    def _steps_deg(self, joints_deg: Angles, target_deg: Angles) -> Angles:
        before, after = self.counting.inclined(joints_deg), self.counting.inclined(target_deg)
        return tuple(to - origin for origin, to in zip(before, after, strict=True))


def _shares(duration_s: float) -> list[float]:
    """Return how far along a motion its pieces end."""
    pieces = max(1, math.ceil(duration_s / LONGEST_PIECE_S))
    if pieces > _MOST_PIECES:
        raise DeviceRefusedError(
            f"the motion would take {duration_s / 60.0:.0f} min: raise the speed limits, or the speed"
            " override on the pendant"
        )
    return [piece / pieces for piece in range(1, pieces + 1)]


def _between(start: Angles, end: Angles, share: float) -> Angles:
    return tuple(a + share * (b - a) for a, b in zip(start, end, strict=True))
