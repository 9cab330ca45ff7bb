"""What a controller knows of a target, and the rule by which it chooses among the joints that reach it.

An arm with a closed form reaches a pose in up to eight branches, and a joint that turns far stands in the
same place in several turns. A rule says which of these the controller takes. A correction must not change
that.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Protocol

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.kinematics.inverse import brought_within

FULL_RAD: Final = 2 * np.pi


@dataclass(frozen=True, slots=True)
class Known:
    """What a controller knows of a target beside its pose."""

    branch: int  # as `kinematics.inverse` numbers them; ANY_BRANCH where nobody said it
    turns: tuple[int, ...] = ()  # the numbers of the file that count turns or quadrants
    near_rad: FloatArray | None = None  # (J,) the configuration that the file names beside the pose
    before_rad: FloatArray | None = None  # (J,) from which joints it moves there


class Rule(Protocol):
    """The rule of a language."""

    def posture(self, words: str) -> str:
        """Return what the words of a target say of its branch; targets of one branch say the same."""
        ...

    def taken(
        self, answers: FloatArray, known: Known, limits: Sequence[JointRange] | None
    ) -> FloatArray | None:
        """Return the joints that the controller takes, of its answers in each branch (8, J), in (-pi, pi].

        None where it has none, NaN where the branch does not exist.
        """
        ...

    def turned(self, known: Known, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return the numbers that count turns, for joints that are sent instead of the controller's own."""
        ...

    def counts_turns(self, words: str) -> bool:
        """Whether the words of a target say that a joint stands beyond half a turn, but not which."""
        ...

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether what a target says of external axes says that there are some."""
        ...


def limit_of(limits: Sequence[JointRange] | None, joint: int) -> JointRange | None:
    """Return the limit of a joint, counted from 0; None where it is not known."""
    return None if limits is None else limits[joint]


def within(joints_rad: FloatArray, limits: Sequence[JointRange] | None) -> FloatArray:
    """Return joints (J,) in the turns that are within their limits, as near to the middles as can be."""
    if limits is None:
        return joints_rad.copy()
    turned, _ = brought_within(joints_rad[None], tuple(limits))
    return np.asarray(turned[0])
