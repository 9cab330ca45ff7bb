"""Changes of convention: between what a table of a robot or of readings says and what was meant."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.robot import Robot
from truepose.domain.sentences import Sentence, said
from truepose.effects.names import joint_subject

MM_PER_M: Final = 1e3
MM_PER_INCH: Final = 25.4


_OF_ALL_READINGS: Final = {
    "radians": "convention.radians",
    "metres": "convention.metres",
    "inches": "convention.inches",
    "radians_and_metres": "convention.radians_and_metres",
    "left_handed": "convention.left_handed",
}


@dataclass(frozen=True, slots=True)
class Evidence:
    """Readings as the hypotheses see them."""

    joints_rad: FloatArray  # (n, J)
    nest: IntArray  # (n,)
    position_mm: FloatArray  # (n, 3)


@dataclass(frozen=True, slots=True)
class Meant:
    """A robot and readings as they are meant."""

    robot: Robot
    evidence: Evidence


@dataclass(frozen=True, slots=True)
class Change:
    """One change of convention; joints count from 0, nests from 1."""

    kind: str
    first: int = 0
    second: int = 0
    amount: float = 0.0  # factor of a coupling; shift of a zero [rad]

    @property
    def sentence(self) -> Sentence:
        """What it would change, in words."""
        match self.kind:
            case "nests":
                return said("convention.nests", first=self.first, second=self.second)
            case "columns":
                return said("convention.columns", first=self.first + 1, second=self.second + 1)
            case "other_way":
                return said("convention.other_way", joint=joint_subject(self.first))
            case "coupled":
                key = "convention.coupled.subtract" if self.amount < 0 else "convention.coupled.add"
                return said(key, joint=joint_subject(self.first), other=joint_subject(self.second))
            case "zero":
                return said("convention.zero", joint=joint_subject(self.first), shift=_angle(self.amount))
        return said(_OF_ALL_READINGS[self.kind])

    def applied(self, meant: Meant) -> Meant:
        """Return robot and readings with this change."""
        return _APPLIED[self.kind](self, meant)


def _angle(shift_rad: float) -> Sentence:
    """Return the angle in words; conventions differ by quarter turns, crashes and cables by any angle."""
    found = float(np.rad2deg(shift_rad))
    quarter = 90.0 * round(found / 90.0)
    if abs(found - quarter) < 1.0:
        return said("convention.quarter", quarter_deg=quarter, found_deg=found)
    return said("convention.angle", found_deg=found)


def _scaled(meant: Meant, size: float) -> Meant:
    evidence = meant.evidence
    return replace(meant, evidence=replace(evidence, position_mm=evidence.position_mm * size))


def _radians(meant: Meant) -> Meant:
    evidence = meant.evidence
    return replace(meant, evidence=replace(evidence, joints_rad=np.rad2deg(evidence.joints_rad)))


def _mirrored(meant: Meant) -> Meant:
    evidence = meant.evidence
    flipped = evidence.position_mm * np.array([1.0, -1.0, 1.0])
    return replace(meant, evidence=replace(evidence, position_mm=flipped))


def _nests(change: Change, meant: Meant) -> Meant:
    nest = meant.evidence.nest.copy()
    was = meant.evidence.nest
    nest[was == change.first], nest[was == change.second] = change.second, change.first
    return replace(meant, evidence=replace(meant.evidence, nest=nest))


def _columns(change: Change, meant: Meant) -> Meant:
    order = list(range(meant.evidence.joints_rad.shape[1]))
    order[change.first], order[change.second] = order[change.second], order[change.first]
    exchanged = meant.evidence.joints_rad[:, order]
    return replace(meant, evidence=replace(meant.evidence, joints_rad=exchanged))


def _coupled(change: Change, meant: Meant) -> Meant:
    coupled = meant.evidence.joints_rad.copy()
    coupled[:, change.first] += change.amount * coupled[:, change.second]
    return replace(meant, evidence=replace(meant.evidence, joints_rad=coupled))


def _other_way(change: Change, meant: Meant) -> Meant:
    rows = list(meant.robot.joints)
    rows[change.first] = replace(rows[change.first], sign=-rows[change.first].sign)
    return replace(meant, robot=replace(meant.robot, joints=tuple(rows)))


def with_zero(robot: Robot, joint: int, shift_rad: float) -> Robot:
    """Return the robot with the zero of one joint (0-based) moved."""
    rows = list(robot.joints)
    rows[joint] = replace(rows[joint], theta_offset_rad=rows[joint].theta_offset_rad + shift_rad)
    return replace(robot, joints=tuple(rows))


_APPLIED: Final[Mapping[str, Callable[[Change, Meant], Meant]]] = MappingProxyType({
    "radians": lambda _, meant: _radians(meant),
    "metres": lambda _, meant: _scaled(meant, MM_PER_M),
    "inches": lambda _, meant: _scaled(meant, MM_PER_INCH),
    "radians_and_metres": lambda _, meant: _scaled(_radians(meant), MM_PER_M),
    "left_handed": lambda _, meant: _mirrored(meant),
    "nests": _nests,
    "other_way": _other_way,
    "coupled": _coupled,
    "columns": _columns,
    "zero": lambda change, meant: replace(meant, robot=with_zero(meant.robot, change.first, change.amount)),
})
KINDS: Final = tuple(_APPLIED)
