"""A program as its controller runs it: at which joints each target is reached.

A corrected file is read again before anybody gets it, and solved by this: what does not arrive at the joints
that were found is not corrected.
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.correction import ANY_BRANCH
from truepose.domain.arrays import FloatArray
from truepose.domain.robot import Robot
from truepose.exchange.programs.controllers.rule import Known, Rule
from truepose.exchange.programs.program import Configuration, Pose, ProgramTarget, Written
from truepose.kinematics.inverse import all_branches, has_closed_form
from truepose.kinematics.inverse_search import BRANCHES

_MOST_JOINTS: Final = 6  # more reach a pose in infinitely many ways
_LEVER_MM: Final = 100.0  # shorter than any arm that a place turns
_AMPLIFIED: Final = 20.0  # rounding of a pose, by joints near a singularity
_LEAST_RAD: Final = 2e-6  # 1e-4 deg


class Controller:
    """A controller with its nominal model."""

    def __init__(self, robot: Robot, rule: Rule) -> None:
        self._robot, self._rule = robot, rule

    def can_tell(self, target: ProgramTarget, branch: int) -> bool:
        """Whether it is known how the controller chooses among its answers to a pose."""
        if self._robot.n_joints > _MOST_JOINTS:
            return False
        return target.near_rad is not None or (branch != ANY_BRANCH and has_closed_form(self._robot))

    def answers(self, flange: FloatArray) -> FloatArray:
        """Return the joints of every branch for n flanges, (n, 8, J)."""
        if not len(flange):
            return np.empty((0, BRANCHES, self._robot.n_joints))
        return all_branches(self._robot, flange)

    def taken(
        self, target: ProgramTarget, answers: FloatArray, branch: int, before_rad: FloatArray | None
    ) -> FloatArray | None:
        """Return which answer is taken, from the joints before; None where the words contradict."""
        known = Known(branch, _turns(target), _near(target), before_rad)
        return self._rule.taken(answers, known, self._robot.joint_limits)

    def turned(
        self, target: ProgramTarget, branch: int, own_rad: FloatArray, sent_rad: FloatArray
    ) -> tuple[int, ...]:
        """Return the numbers of a target that count turns, for the joints that are sent."""
        return self._rule.turned(Known(branch, _turns(target)), own_rad, sent_rad)

    def arriving(
        self,
        targets: Sequence[ProgramTarget],
        flange: FloatArray,
        branch: Sequence[int],
        sent_rad: FloatArray,
        befores_rad: Sequence[Sequence[FloatArray]],
    ) -> list[bool]:
        """Return at which of n targets the controller comes to the joints that it shall, (n, J).

        `befores_rad` has the joints from which it moves to each of them, none where that is not known.
        """
        poses = np.array([isinstance(target.value, Pose) for target in targets], dtype=bool)
        answers = np.full((len(targets), BRANCHES, self._robot.n_joints), np.nan)
        if poses.any():
            answers[poses] = self.answers(flange[poses])
        return [
            all(
                self._is_at(target, answers[row], branch[row], before, sent_rad[row])
                for before in befores_rad[row] or (None,)
            )
            for row, target in enumerate(targets)
        ]

    def _is_at(
        self,
        target: ProgramTarget,
        answers: FloatArray,
        branch: int,
        before_rad: FloatArray | None,
        sent_rad: FloatArray,
    ) -> bool:
        if isinstance(target.value, Configuration):
            found: FloatArray | None = np.array(target.value.joints_rad)
        else:
            found = self.taken(target, answers, branch, before_rad)
        return found is not None and bool(np.abs(found - sent_rad).max() <= _tolerance_rad(target))


def _turns(target: ProgramTarget) -> tuple[int, ...]:
    return tuple(int(number.value) for number in target.turns)


def _near(target: ProgramTarget) -> FloatArray | None:
    return None if target.near_rad is None else np.array(target.near_rad)


def _tolerance_rad(target: ProgramTarget) -> float:
    """Return how far joints may be off because the file has so many decimals."""
    off = [_rounding(written) for written in target.written]
    if isinstance(target.value, Configuration):
        return _LEAST_RAD + 2.0 * off[0]  # joint 3 of FANUC is rounded with joint 2
    return _LEAST_RAD + _AMPLIFIED * (off[0] / _LEVER_MM + off[1])


def _rounding(written: Written) -> float:
    """Return what half of the last decimal changes, in mm, rad or parts of a quaternion."""
    decimals = max(written.form.decimals, min(number.decimals for number in written.numbers))
    step = 0.5 * 10.0**-decimals
    stood, moved = written.read(), written.form.inward([value + step for value in written.values])
    return float(np.abs(np.subtract(stood, moved)).max())
