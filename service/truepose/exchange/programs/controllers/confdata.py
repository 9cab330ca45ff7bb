"""ABB: `confdata` names the branch (cfx), and of axes 1, 4 and 6 the quarter of a turn that they stand in.

Source: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, "confdata": quadrant 0
is 0 to 90 degrees, 1 is 90 to 180, -1 is 0 to -90 and so on; "ConfJ": where a configuration cannot be
reached as it is programmed, execution stops. Three zeros that do not hold are taken as written by hand where
nobody looked: they say nothing and stay as they are. At a singular wrist nobody can tell: there, and
with other numbers that do not hold, the target contradicts itself.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.programs.controllers.rule import FULL_RAD, Known, within

_AXES: Final = (0, 3, 5)
_WRIST: Final = 4
_SINGULAR: Final = 0.02  # sine of axis 5, below which axes 4 and 6 share their turn as rounding has it
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
        """Return the answer of the branch, with axes 1, 4 and 6 in their quadrants; None if one is not."""
        joints = within(answers[known.branch], limits)
        found = _in_quadrants(joints, known.turns)
        unsaid = not any(known.turns) and abs(np.sin(joints[_WRIST])) > _SINGULAR
        return joints if found is None and unsaid else found

    def turned(self, known: Known, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return the quadrants of what is sent, unless the numbers said nothing of where the arm was."""
        if _in_quadrants(own_rad, known.turns) is None:
            return known.turns
        return tuple(_quadrant(sent_rad[axis]) for axis, _ in zip(_AXES, known.turns, strict=False))

    def counts_turns(self, words: str) -> bool:
        """Whether turns are counted of a joint that is not known: of no one."""
        return False

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether an axis is connected; six zeros are what is written by hand where there is none."""
        there = [value for value in external if abs(value) < _NOT_THERE]
        return bool(there) and not (len(there) == _N_EXTERNAL and not any(there))


def _in_quadrants(joints_rad: FloatArray, quadrants: Sequence[int]) -> FloatArray | None:
    """Return joints with the whole turns that bring them into their quadrants; None if one is in another."""
    found = joints_rad.copy()
    for axis, quadrant in zip(_AXES, quadrants, strict=False):
        middle = (quadrant + 0.5) * _QUARTER_RAD
        found[axis] -= FULL_RAD * np.round((found[axis] - middle) / FULL_RAD)
        if abs(found[axis] - middle) > 0.5 * _QUARTER_RAD + _ROUNDING_RAD:
            return None
    return found


def _quadrant(angle_rad: float) -> int:
    return int(np.floor(angle_rad / _QUARTER_RAD))
