"""A program as its controller runs it: from where and at which joints each target is reached.

Controllers of FANUC count joint 3 from the horizontal: the forearm keeps its inclination while joint 2 alone
moves. With axes 2 and 3 parallel, the inclination is s_2 q_2 + w s_3 q_3, s the signs of the joints and w = 1
where both axes point the same way, hence

    J3 = q_3 + k q_2,   k = w s_2 s_3

Only this is known of it: that the controller's J3 has the sign of the table's joint 3 is for the user to say.

Sources: ros-industrial/fanuc, issue 186 and fanuc_experimental, issue 17 (J2-J3 coupling); checked by the
joints and poses of an R-2000iB/165F in onerobotics.com, The perils of six-axis robots, 2013.

A corrected file is read again before anybody gets it, and solved by this: what does not arrive at the joints
that were found is not corrected.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from truepose.correction import ANY_BRANCH
from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.robot import Robot
from truepose.exchange.programs.controller_rules import Rule, TargetContext
from truepose.exchange.programs.program import Configuration, Pose, Program, ProgramTarget, Written
from truepose.kinematics.inverse import BRANCHES, all_branches, has_closed_form

_PARALLEL: Final = 1e-9  # sine of the angle between axes 2 and 3


def can_be_coupled(robot: Robot) -> bool:
    """Whether joint 3 of an arm can be counted from the horizontal: axes 2 and 3 are parallel."""
    return robot.n_joints > 2 and abs(np.sin(robot.joints[2].alpha_rad)) < _PARALLEL


def from_upper_arm(robot: Robot, shown: Configuration) -> Configuration:
    """Return the joints of the model of a configuration that the controller shows."""
    return _turned(robot, shown, -1.0)


def from_horizontal(robot: Robot, joints: Configuration) -> Configuration:
    """Return what the controller shows of joints of the model."""
    return _turned(robot, joints, 1.0)


def uncouple(robot: Robot, program: Program) -> Program:
    """Return a program whose configurations are those of the model."""
    targets = (
        replace(target, value=from_upper_arm(robot, target.value))
        if isinstance(target.value, Configuration)
        else target
        for target in program.targets
    )
    return replace(program, targets=tuple(targets))


def _turned(robot: Robot, joints: Configuration, way: float) -> Configuration:
    upper, elbow = robot.joints[1:3]
    share = way * float(np.sign(np.cos(elbow.alpha_rad))) * upper.sign * elbow.sign
    first, second, third, *others = joints.joints_rad
    return Configuration((first, second, third + share * second, *others))


_STILL_RAD: Final = 1e-6  # a joint that moves less comes from neither side


def befores(program: Program) -> dict[int, set[int]]:
    """Return the targets from which each one is reached."""
    found: dict[int, set[int]] = {}
    for motion in program.motions:
        if motion.before is not None:
            found.setdefault(motion.target, set()).add(motion.before)
    return found


def approach_directions(program: Program, rows: Sequence[int], joints_rad: FloatArray) -> IntArray:
    """Return from which side joints come to targets, shape (n, J); 0 where straight-line code does not tell.

    A target that is reached from several places has no one direction.
    """
    row_of = {index: row for row, index in enumerate(rows)}
    directions = np.zeros(joints_rad.shape, dtype=np.int64)
    starts: dict[int, set[int | None]] = {}
    for motion in program.motions:
        starts.setdefault(motion.target, set()).add(motion.before)
    for target, before in starts.items():
        # From two places a joint may come from two sides, and its gear stands on either flank.
        start = next(iter(before)) if len(before) == 1 else None
        if target in row_of and start in row_of:
            way = joints_rad[row_of[target]] - joints_rad[row_of[start]]
            directions[row_of[target]] = np.sign(np.where(np.abs(way) > _STILL_RAD, way, 0.0))
    return directions


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
        # An arm of seven joints reaches a pose in a whole line of configurations, and no rule says in which.
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
        known = TargetContext(branch, _turns(target), _near(target), before_rad)
        return self._rule.taken(answers, known, self._robot.joint_limits)

    def turned(
        self, target: ProgramTarget, branch: int, own_rad: FloatArray, sent_rad: FloatArray
    ) -> tuple[int, ...]:
        """Return the numbers of a target that count turns, for the joints that are sent."""
        return self._rule.turned(TargetContext(branch, _turns(target)), own_rad, sent_rad)

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
