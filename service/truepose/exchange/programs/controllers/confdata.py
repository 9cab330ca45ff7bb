"""ABB: `confdata` names the branch (cfx), and of axes 1, 4 and 6 the quarter of a turn that they stand in.

Source: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, "confdata": quadrant 0
is 0 to 90 degrees, 1 is 90 to 180, -1 is 0 to -90 and so on. Where no turn of an axis is in its quadrant, as
in programs that were written by hand, the one nearest to it is meant here; such numbers are left as they
are.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.programs.controllers.rule import Known, limit_of, turned_near, within

_AXES: Final = (0, 3, 5)
_QUARTER_RAD: Final = np.pi / 2
_ROUNDING_RAD: Final = 1e-4  # an axis that stands at the border of two quadrants is in either
_NOT_THERE: Final = 9e8  # an external axis that is not connected is 9E9
_N_EXTERNAL: Final = 6


class Confdata:
    """The rule of controllers that read RAPID."""

    def posture(self, words: str) -> str:
        """Return cfx."""
        return words.rpartition(", ")[2]

    def taken(
        self, answers: FloatArray, known: Known, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the answer of the branch, with axes 1, 4 and 6 in the turns nearest to their quadrants."""
        joints = within(answers[known.branch], limits)
        for axis, quadrant in zip(_AXES, known.turns, strict=False):
            centre = (quadrant + 0.5) * _QUARTER_RAD
            joints[axis] = turned_near(joints[axis], centre, limit_of(limits, axis), _ROUNDING_RAD)
        return joints

    def turned(self, known: Known, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return the quadrants of what is sent, of axes that stood in the quadrant that was named."""
        pairs = zip(_AXES, known.turns, strict=False)
        return tuple(
            _quadrant(sent_rad[axis]) if _stands_in(own_rad[axis], named) else named for axis, named in pairs
        )

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether an axis is connected; six zeros are what is written by hand where there is none."""
        there = [value for value in external if abs(value) < _NOT_THERE]
        return bool(there) and not (len(there) == _N_EXTERNAL and not any(there))


def _quadrant(angle_rad: float) -> int:
    return int(np.floor(angle_rad / _QUARTER_RAD))


def _stands_in(angle_rad: float, quadrant: int) -> bool:
    beyond = max(quadrant * _QUARTER_RAD - angle_rad, angle_rad - (quadrant + 1) * _QUARTER_RAD)
    return beyond <= _ROUNDING_RAD
