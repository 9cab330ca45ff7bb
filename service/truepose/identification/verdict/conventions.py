"""Is the nominal table that of this robot? Which single change of convention would make it fit.

Every hypothesis changes what was read (units, handedness) or the table (sign, zero or coupling of a
joint); base and unknown nests are then found anew (`placement`), and the typical residual of the
nominal robot is compared. A robot's own errors leave some millimetres, a wrong convention tens.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import combinations

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.robot import Robot
from truepose.domain.sentences import Sentence, said
from truepose.effects.names import joint_subject
from truepose.identification.problem.placement import Known, quick_typical_mm
from truepose.kinematics.chain import nominal_chain

# A nominal robot is off by less than this share of its reach; beyond it something else is wrong.
_PLAUSIBLE_SHARE = 0.006
_CLEARLY_BETTER = 0.2  # a hypothesis must leave less than this share of the residual
_MM_PER_M, _MM_PER_INCH = 1e3, 25.4
_ZERO_STEP_RAD = np.deg2rad(15.0)
_SUBSET = 60
_COLLAPSED = 0.02  # readings that spread so much less than the flange are in another unit


@dataclass(frozen=True, slots=True)
class Evidence:
    """Readings as the hypotheses see them."""

    joints_rad: FloatArray  # (n, J)
    nest: IntArray  # (n,)
    position_mm: FloatArray  # (n, 3)


_AS_IT_IS = Sentence("")  # no change to tell of


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """A change of convention, in words, and what it makes of table and readings."""

    sentence: Sentence
    robot: Robot
    evidence: Evidence


def reach_mm(robot: Robot) -> float:
    """Sum of the link lengths: what a residual is compared with."""
    return float(sum(abs(row.a_mm) + abs(row.d_mm) for row in robot.joints))


def plausible_mm(robot: Robot) -> float:
    """Typical residual that a nominal robot of this size may leave [mm]."""
    return _PLAUSIBLE_SHARE * reach_mm(robot)


def change_that_fits(
    robot: Robot, evidence: Evidence, known: Known, *, search_zeros: bool = True
) -> Sentence | None:
    """Return the sentence of the change that makes the nominal robot fit, None where none does."""
    free = replace(known, base=None)
    if _spread_mm(evidence.position_mm) < _COLLAPSED * _spread_mm(
        nominal_chain(robot, evidence.joints_rad).origin[-1]
    ):
        return said("convention.metres")
    evidence = _thinned(evidence)
    present = _typical(Hypothesis(_AS_IT_IS, robot, evidence), free)
    best, best_mm = None, min(_CLEARLY_BETTER * present, plausible_mm(robot))
    for hypothesis in _hypotheses(robot, evidence, known):
        typical = _typical(hypothesis, free)
        if typical < best_mm:
            best, best_mm = hypothesis.sentence, typical
    if best or not search_zeros:
        return best
    return _zero_that_fits(robot, evidence, free, best_mm)


def _spread_mm(points_mm: FloatArray) -> float:
    return float(np.linalg.norm(points_mm - points_mm.mean(axis=0), axis=1).mean())


def _thinned(evidence: Evidence) -> Evidence:
    rows = np.unique(
        np.linspace(0, len(evidence.nest) - 1, min(len(evidence.nest), _SUBSET)).astype(np.int64)
    )
    return Evidence(evidence.joints_rad[rows], evidence.nest[rows], evidence.position_mm[rows])


def _typical(hypothesis: Hypothesis, known: Known) -> float:
    evidence = hypothesis.evidence
    chain = nominal_chain(hypothesis.robot, evidence.joints_rad)
    return quick_typical_mm(chain, evidence.nest, evidence.position_mm, known)


def _hypotheses(robot: Robot, evidence: Evidence, known: Known) -> Iterator[Hypothesis]:
    yield from _units(robot, evidence)
    yield from _joint_conventions(robot, evidence)
    yield from _exchanged_nests(robot, evidence, known)


def _exchanged_nests(robot: Robot, evidence: Evidence, known: Known) -> Iterator[Hypothesis]:
    """Two labels exchanged throughout; unknown nests have no place that could contradict a label."""
    certified = [int(number) + 1 for number in np.flatnonzero(~known.nest_unknown)]
    for first, second in combinations(certified, 2):
        nest = evidence.nest.copy()
        nest[evidence.nest == first], nest[evidence.nest == second] = second, first
        yield Hypothesis(
            said("convention.nests", first=first, second=second), robot, replace(evidence, nest=nest)
        )


def _units(robot: Robot, evidence: Evidence) -> Iterator[Hypothesis]:
    degrees = replace(evidence, joints_rad=np.rad2deg(evidence.joints_rad))
    metres = replace(evidence, position_mm=evidence.position_mm * _MM_PER_M)
    inches = replace(evidence, position_mm=evidence.position_mm * _MM_PER_INCH)
    mirrored = replace(evidence, position_mm=evidence.position_mm * np.array([1.0, -1.0, 1.0]))
    both = replace(degrees, position_mm=metres.position_mm)
    yield Hypothesis(said("convention.radians"), robot, degrees)
    yield Hypothesis(said("convention.metres"), robot, metres)
    yield Hypothesis(said("convention.inches"), robot, inches)
    yield Hypothesis(said("convention.radians_and_metres"), robot, both)
    yield Hypothesis(said("convention.left_handed"), robot, mirrored)


def _joint_conventions(robot: Robot, evidence: Evidence) -> Iterator[Hypothesis]:
    for joint in range(robot.n_joints):
        sentence = said("convention.other_way", joint=joint_subject(joint))
        yield Hypothesis(sentence, _with_sign(robot, joint), evidence)
    for joint in range(1, robot.n_joints):
        for factor in (1.0, -1.0):
            coupled = evidence.joints_rad.copy()
            coupled[:, joint] += factor * coupled[:, joint - 1]
            key = "convention.coupled.subtract" if factor < 0 else "convention.coupled.add"
            sentence = said(key, joint=joint_subject(joint), other=joint_subject(joint - 1))
            yield Hypothesis(sentence, robot, replace(evidence, joints_rad=coupled))
    for joint in range(1, robot.n_joints):
        order = list(range(robot.n_joints))
        order[joint - 1], order[joint] = order[joint], order[joint - 1]
        sentence = said("convention.columns", first=joint, second=joint + 1)
        yield Hypothesis(sentence, robot, replace(evidence, joints_rad=evidence.joints_rad[:, order]))


def _with_sign(robot: Robot, joint: int) -> Robot:
    rows = list(robot.joints)
    rows[joint] = replace(rows[joint], sign=-rows[joint].sign)
    return replace(robot, joints=tuple(rows))


def with_zero(robot: Robot, joint: int, shift_rad: float) -> Robot:
    """Return the robot with the zero of one joint (0-based) moved."""
    rows = list(robot.joints)
    rows[joint] = replace(rows[joint], theta_offset_rad=rows[joint].theta_offset_rad + shift_rad)
    return replace(robot, joints=tuple(rows))


def _zero_that_fits(robot: Robot, evidence: Evidence, known: Known, limit_mm: float) -> Sentence | None:
    """Try other zeros of one joint: coarse steps, then golden sections around each joint's best."""
    best: tuple[float, int, float] = (limit_mm, 0, 0.0)
    for joint in range(1, robot.n_joints):
        steps = np.arange(-np.pi + _ZERO_STEP_RAD, np.pi + 1e-9, _ZERO_STEP_RAD)
        coarse = [
            _typical(Hypothesis(_AS_IT_IS, with_zero(robot, joint, float(shift)), evidence), known)
            for shift in steps
        ]
        shift = _refined(robot, evidence, known, joint, float(steps[int(np.argmin(coarse))]))
        typical = _typical(Hypothesis(_AS_IT_IS, with_zero(robot, joint, shift), evidence), known)
        best = min(best, (typical, joint, shift))
    _, joint, shift = best
    if joint == 0:
        return None
    return said("convention.zero", joint=joint_subject(joint), shift=_angle(shift))


def _angle(shift_rad: float) -> Sentence:
    """Return the angle in words; conventions differ by quarter turns, crashes and cables by any angle."""
    found = float(np.rad2deg(shift_rad))
    quarter = 90.0 * round(found / 90.0)
    if abs(found - quarter) < 1.0:
        return said("convention.quarter", quarter_deg=quarter, found_deg=found)
    return said("convention.angle", found_deg=found)


def _refined(robot: Robot, evidence: Evidence, known: Known, joint: int, shift: float) -> float:
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    low, high = shift - _ZERO_STEP_RAD, shift + _ZERO_STEP_RAD

    def typical(angle: float) -> float:
        return _typical(Hypothesis(_AS_IT_IS, with_zero(robot, joint, angle), evidence), known)

    while high - low > 1e-4:
        first, second = high - golden * (high - low), low + golden * (high - low)
        if typical(first) < typical(second):
            high = second
        else:
            low = first
    return float(0.5 * (low + high))
