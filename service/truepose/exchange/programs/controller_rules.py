"""What controllers do with a target: by their makers' rules, which joints they take to it.

An arm with a closed form reaches a pose in up to eight branches, and a joint that turns far stands in the
same place in several turns. A rule says which of these the controller takes. A correction must not change
that.

Source: Universal Robots, The URScript Programming Language: `get_inverse_kin(x, qnear)` returns the solution
closest to qnear, and to the present joints without it, as `movej` does for a pose. What "closest" means is
not said: an answer counts that is nearest by its largest and by its mean square difference.

FANUC (`N U T, 0, 0, 0`), Yaskawa (RCONF) and Staubli name the branch, which is stated by whoever has the
program corrected. Their numbers count whole turns from -180 to 180 degrees; of which joints FANUC's three
are differs between its manuals, and RCONF does not say to which side. As long as all of them are 0 and no
joint passes 180 degrees they stay right, whatever they are of: joints are therefore always taken within
half a turn of the middle of their range, what passes that border does not arrive, and other numbers than 0
are not followed.

Source: FANUC Robotics, SYSTEM R-30iA and R-30iB Handling Tool, Setup and Operations Manual, "Configuration";
Yaskawa, DX200 and YRC1000 Operator's Manual, "Job data format", RCONF; Staubli, VAL3 reference manual,
"config".

Source: ABB, Technical reference manual, RAPID Instructions, Functions and Data types, "confdata": quadrant 0
is 0 to 90 degrees, 1 is 90 to 180, -1 is 0 to -90 and so on; "ConfJ": where a configuration cannot be
reached as it is programmed, execution stops. Three zeros that do not hold are taken as written by hand where
nobody looked: they say nothing and stay as they are. At a singular wrist nobody can tell: there, and
with other numbers that do not hold, the target contradicts itself.

Source: KUKA System Software, Operating and Programming Instructions for System Integrators, "Status and
Turn": bit n - 1 of Turn is 1 where axis n is below 0 degrees; of Status bit 0 is the side of axis 1, bit 1
the elbow, bit 2 the wrist. Only a PTP motion looks at them; a LIN motion keeps the branch in which it
begins. Which branch a Status is, is stated by whoever has the program corrected; the sign of axis 5 is also
in Turn.
"""

import re
from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.correction import ANY_BRANCH
from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.kinematics.inverse import brought_within

FULL_RAD: Final = 2 * np.pi


@dataclass(frozen=True, slots=True)
class TargetContext:
    """What a controller knows of a target beside its pose."""

    branch: int  # as `kinematics.inverse` numbers them; ANY_BRANCH where nobody said it
    turns: tuple[int, ...] = ()  # the numbers of the file that count turns or quadrants
    near_rad: FloatArray | None = None  # (J,) the configuration that the file names beside the pose
    before_rad: FloatArray | None = None  # (J,) from which joints it moves there


class Rule(ABC):
    """The rule of a language; what its words do not tell is as here."""

    @abstractmethod
    def posture(self, words: str) -> str:
        """Return what the words of a target say of its branch; targets of one branch say the same."""

    @abstractmethod
    def taken(
        self, answers: FloatArray, known: TargetContext, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the joints that the controller takes, of its answers in each branch (8, J), in (-pi, pi].

        None where it has none, NaN where the branch does not exist.
        """

    def turned(self, known: TargetContext, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return the numbers that count turns, for joints that are sent instead of the controller's own.

        As they are, where none counts any or they stay right.
        """
        return known.turns

    def counts_turns(self, words: str) -> bool:
        """Whether the words of a target say that a joint stands beyond half a turn, but not which."""
        return False

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether what a target says of external axes says that there are some.

        Where only those that are there are written, it does.
        """
        return bool(external)


def limit_of(limits: Sequence[JointRange] | None, joint: int) -> JointRange | None:
    """Return the limit of a joint, counted from 0; None where it is not known."""
    return None if limits is None else limits[joint]


def within(joints_rad: FloatArray, limits: Sequence[JointRange] | None) -> FloatArray:
    """Return joints (J,) in the turns that are within their limits, as near to the middles as can be."""
    if limits is None:
        return joints_rad.copy()
    turned, _ = brought_within(joints_rad[None], tuple(limits))
    return np.asarray(turned[0])


class Nearest(Rule):
    """The rule of these controllers."""

    def posture(self, words: str) -> str:
        """Return the words: they say nothing of a branch."""
        return words

    def taken(
        self, answers: FloatArray, known: TargetContext, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the nearest answer; of where nothing is known to be near, that of the branch.

        None also where the nearest to the joints before is of another branch than was stated.
        """
        near = known.near_rad if known.near_rad is not None else known.before_rad
        if near is None:
            return within(answers[known.branch], limits)
        there = np.flatnonzero(np.isfinite(answers).all(axis=1))
        if not len(there):
            return np.full(len(near), np.nan)
        turned = answers[there] - FULL_RAD * np.round((answers[there] - near) / FULL_RAD)
        apart = np.abs(turned - near)
        # The maker does not say by which measure it is the nearest: where two measures differ, nobody knows,
        # and the target is left alone.
        first, second = np.argmin(apart.max(axis=1)), np.argmin((apart**2).sum(axis=1))
        stated = known.branch if known.near_rad is None else ANY_BRANCH
        return turned[first] if first == second and stated in (ANY_BRANCH, there[first]) else None


_WHOLE: Final = re.compile(r"[-+]?[0-9]+")
_OF_RCONF: Final = 3  # wrist, elbow, side; behind them turns


class StatedBranch(Rule):
    """The rule of these controllers."""

    def posture(self, words: str) -> str:
        """Return what of the words is no number; of RCONF, which is numbers, the first three."""
        named, numbers = _parts(words)
        return ", ".join(named or numbers[:_OF_RCONF])

    def taken(
        self, answers: FloatArray, known: TargetContext, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the answer of the branch."""
        return within(answers[known.branch], limits)

    def counts_turns(self, words: str) -> bool:
        """Whether a number that counts turns is not 0."""
        named, numbers = _parts(words)
        return any(number.strip("+-0") for number in (numbers if named else numbers[_OF_RCONF:]))


def _parts(words: str) -> tuple[list[str], list[str]]:
    """Return what of the words is no number, and the numbers."""
    parts = [part.strip() for part in words.split(",")]
    named = [part for part in parts if not _WHOLE.fullmatch(part)]
    return named, [part for part in parts if _WHOLE.fullmatch(part)]


_AXES: Final = (0, 3, 5)
_WRIST: Final = 4
_SINGULAR: Final = 0.02  # sine of axis 5, below which axes 4 and 6 share their turn as rounding has it
_QUARTER_RAD: Final = np.pi / 2
_ROUNDING_OF_QUARTERS_RAD: Final = 1e-4  # an axis that stands at the border of two quadrants is in either
_NOT_THERE: Final = 9e8  # an external axis that is not connected is 9E9
_N_EXTERNAL: Final = 6


class Confdata(Rule):
    """The rule of controllers that read RAPID."""

    def posture(self, words: str) -> str:
        """Return cfx."""
        return words.rpartition(", ")[2]

    def taken(
        self, answers: FloatArray, known: TargetContext, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the answer of the branch, with axes 1, 4 and 6 in their quadrants; None if one is not."""
        joints = within(answers[known.branch], limits)
        found = _in_quadrants(joints, known.turns)
        # Three zeros are what people write by hand; but of a singular wrist they may be right, as its two
        # axes share their turn.
        unsaid = not any(known.turns) and abs(np.sin(joints[_WRIST])) > _SINGULAR
        return joints if found is None and unsaid else found

    def turned(self, known: TargetContext, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return the quadrants of what is sent, unless the numbers said nothing of where the arm was."""
        if _in_quadrants(own_rad, known.turns) is None:
            return known.turns
        return tuple(_quadrant(sent_rad[axis]) for axis, _ in zip(_AXES, known.turns, strict=False))

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
        if abs(found[axis] - middle) > 0.5 * _QUARTER_RAD + _ROUNDING_OF_QUARTERS_RAD:
            return None
    return found


def _quadrant(angle_rad: float) -> int:
    return int(np.floor(angle_rad / _QUARTER_RAD))


_TURNING_FAR: Final = (3, 5)  # axes that stand in two turns where limits are not known: 4 and 6
_ROUNDING_RAD: Final = 2e-4  # an axis at zero has either sign
_ARM_BITS: Final = 0b111111
_STATUS_OF_THE_ARM: Final = 0b011  # the wrist is in Turn


class StatusAndTurn(Rule):
    """The rule of controllers that read KRL."""

    def posture(self, words: str) -> str:
        """Return the side and the elbow that S names."""
        status = whole_number(words.partition(",")[0].removeprefix("S ").strip())
        return words if status is None else f"S {status & _STATUS_OF_THE_ARM}"

    def taken(
        self, answers: FloatArray, known: TargetContext, limits: Sequence[JointRange] | None
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

    def turned(self, known: TargetContext, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return T of what is sent; its bits of external axes stay."""
        bits = sum(1 << axis for axis, angle in enumerate(sent_rad) if angle < 0.0)
        return tuple((turn & ~_ARM_BITS) | bits for turn in known.turns)

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


_WHOLE_NUMBER: Final = re.compile(
    r"'B([01]{1,64})'|'H([0-9A-F]{1,16})'|([-+]?[0-9]{1,18})", re.ASCII | re.IGNORECASE
)
_BASES: Final = (2, 16, 10)


def whole_number(text: str) -> int | None:
    """Return what 19, 'B010011' or 'H13' are; None for anything else."""
    found = _WHOLE_NUMBER.fullmatch(text)
    if found is None or found.lastindex is None:
        return None
    return int(found[found.lastindex], _BASES[found.lastindex - 1])
