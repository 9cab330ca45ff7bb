"""KUKA: S names the branch, T has a bit of each axis that is 1 where its angle is negative.

Source: KUKA System Software, Operating and Programming Instructions for System Integrators, "Status and
Turn": bit n - 1 of Turn is 1 where axis n is below 0 degrees; of Status bit 0 is the side of axis 1, bit 1
the elbow, bit 2 the wrist. Only a PTP motion looks at them; a LIN motion keeps the branch in which it
begins. Which branch a Status is, is stated by whoever has the program corrected; the sign of axis 5 is also
in Turn.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.programs.controllers.rule import FULL_RAD, Known, limit_of, within

_TURNING_FAR: Final = (3, 5)  # axes that stand in two turns where limits are not known: 4 and 6
_ROUNDING_RAD: Final = 2e-4  # an axis at zero has either sign
_ARM_BITS: Final = 0b111111
_STATUS_OF_THE_ARM: Final = 0b011  # the wrist is in Turn


class StatusAndTurn:
    """The rule of controllers that read KRL."""

    def posture(self, words: str) -> str:
        """Return the side and the elbow that S names."""
        status = whole_number(words.partition(",")[0].removeprefix("S ").strip())
        return words if status is None else f"S {status & _STATUS_OF_THE_ARM}"

    def taken(
        self, answers: FloatArray, known: Known, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the answer of the branch with the signs that T names; without T nothing is said of turns."""
        joints = within(answers[known.branch], limits)
        if not known.turns or not np.isfinite(joints).all():
            return joints
        for axis in range(len(joints)):
            signed = _signed(joints[axis], bool(known.turns[0] >> axis & 1), axis, limit_of(limits, axis))
            if signed is None:
                return None
            joints[axis] = signed
        return joints

    def turned(self, known: Known, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return T of what is sent; its bits of external axes stay."""
        bits = sum(1 << axis for axis, angle in enumerate(sent_rad) if angle < 0.0)
        return tuple((turn & ~_ARM_BITS) | bits for turn in known.turns)

    def counts_turns(self, words: str) -> bool:
        """Whether turns are counted of a joint that is not known: of no one."""
        return False

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether an external axis stands elsewhere than at zero, as those that are not there do."""
        return any(external)


def _signed(angle_rad: float, negative: bool, axis: int, limit: JointRange | None) -> float | None:
    """Return the turn of an axis that has a sign; None where it has none within its limit."""
    if (angle_rad < 0.0) == negative or abs(angle_rad) < _ROUNDING_RAD:
        return angle_rad
    other = angle_rad - FULL_RAD if negative else angle_rad + FULL_RAD
    if limit is None:
        return other if axis in _TURNING_FAR else None
    inside = limit.lower_rad - _ROUNDING_RAD <= other <= limit.upper_rad + _ROUNDING_RAD
    return other if inside else None


def whole_number(text: str) -> int | None:
    """Return what 19, 'B010011' or 'H13' are; None for anything else."""
    base, digits = 10, text
    if text[:2].upper() in ("'B", "'H") and text.endswith("'"):
        base, digits = (2 if text[1].upper() == "B" else 16), text[2:-1]
    try:
        return int(digits, base)
    except ValueError:
        return None
