"""A joint motion cut into pieces of its own straight way, each of which ends at rest.

Where a protocol cannot stop a motion, whatever was sent last is gone through to its end: when this program
is killed, and when somebody asks for a pause. Pieces make that short. They lie on one line of the joints,
so the arm takes the same way and comes to every stop from the same side.
"""

import math
from collections.abc import Callable
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import FramePlacement, Robot
from truepose.kinematics.frames import vector_from_rotation
from truepose.sequencing.engine.motion.nominal_arm import nominal_chain
from truepose_drivers.api import MotionLimits

_LOOKS: Final = 24  # along a way; between two of them the speeds hardly change
_LONG_S: Final = 0.5  # of cell time, after which one can tell whether it costs wall time
_SHARE_THAT_WAITS: Final = 0.5
_MOST_PIECES: Final = 200  # of a way that takes minutes: finer makes no sense

Joints = tuple[float, ...]


class MotionSegments:
    """Cuts motions of one robot at one speed; the flange is what its controller counts as the tool."""

    def __init__(self, robot: Robot, speed: MotionLimits) -> None:
        self._robot = robot
        self._speed = speed

    def of(self, start_rad: Joints, target_rad: Joints, longest_s: float) -> tuple[Joints, ...]:
        """Return where the pieces of a straight joint motion end, the target last; none takes longer."""
        slowest_s = self._slowest_look_s(np.array(start_rad), np.array(target_rad))
        count = min(_MOST_PIECES, max(1, math.ceil(_LOOKS * slowest_s / longest_s)))
        between = tuple(
            tuple(a + (b - a) * piece / count for a, b in zip(start_rad, target_rad, strict=True))
            for piece in range(1, count)
        )
        return (*between, target_rad)

    def _slowest_look_s(self, start: FloatArray, target: FloatArray) -> float:
        """Return the longest time between two of the equal steps of the joints [s]."""
        share = np.linspace(0.0, 1.0, _LOOKS + 1)[:, None]
        chain = nominal_chain(self._robot, FramePlacement(), start + share * (target - start))
        last = chain.rotation[-1]
        path_mm = np.linalg.norm(np.diff(chain.origin[-1], axis=0), axis=1)
        turn_rad = np.linalg.norm(vector_from_rotation(np.swapaxes(last[:-1], -1, -2) @ last[1:]), axis=1)
        speed = self._speed
        times = np.maximum(path_mm / speed.tool_speed_mm_s, turn_rad / speed.orientation_speed_rad_s)
        return float(times.max())


class WallPace:
    """Whether motions take wall time: in a simulated cell they may not, and then nothing interrupts them."""

    def __init__(self, wall_s: Callable[[], float]) -> None:
        self._wall_s = wall_s
        self._began: tuple[float, float] | None = None  # cell time, wall time
        self.waits = True  # until the contrary was seen; in a real cell the two times are one

    def look(self, cell_s: float) -> None:
        """Compare how far the cell's time and that of the wall have gone since the first look."""
        wall_s = self._wall_s()
        if self._began is None:
            self._began = cell_s, wall_s
        gone_s = cell_s - self._began[0]
        if gone_s > _LONG_S:
            self.waits = wall_s - self._began[1] > _SHARE_THAT_WAITS * gone_s

    def begin_anew(self) -> None:
        """Forget when the first look was: a person may have had hours since."""
        self._began = None
