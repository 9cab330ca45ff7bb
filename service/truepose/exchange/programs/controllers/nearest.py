"""Controllers that take the joints nearest to where the arm is, or to a configuration that the target names.

Source: Universal Robots, The URScript Programming Language: `get_inverse_kin(x, qnear)` returns the solution
closest to qnear, and to the present joints without it, as `movej` does for a pose. What "closest" means is
not said: an answer counts that is nearest by its largest and by its mean square difference.
"""

from collections.abc import Sequence

import numpy as np

from truepose.correction import ANY_BRANCH
from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.programs.controllers.rule import FULL_RAD, Known, within


class Nearest:
    """The rule of these controllers."""

    def posture(self, words: str) -> str:
        """Return the words: they say nothing of a branch."""
        return words

    def taken(
        self, answers: FloatArray, known: Known, limits: Sequence[JointRange] | None
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
        first, second = np.argmin(apart.max(axis=1)), np.argmin((apart**2).sum(axis=1))
        stated = known.branch if known.near_rad is None else ANY_BRANCH
        return turned[first] if first == second and stated in (ANY_BRANCH, there[first]) else None

    def turned(self, known: Known, own_rad: FloatArray, sent_rad: FloatArray) -> tuple[int, ...]:
        """Return nothing: no number counts turns."""
        return known.turns

    def counts_turns(self, words: str) -> bool:
        """Whether turns are counted of a joint that is not known: of no one."""
        return False

    def moves_external(self, external: Sequence[float]) -> bool:
        """Whether the target names external axes."""
        return bool(external)
