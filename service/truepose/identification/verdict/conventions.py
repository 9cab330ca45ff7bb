"""Is the nominal table that of this robot? Which single change of convention would make it fit.

Every hypothesis changes what was read (units, handedness) or the table (sign, zero or coupling of a
joint); base and unknown nests are then found anew (`placement`), and the typical residual of the
nominal robot is compared:

    typical = median over the readings of |p - predicted|
    reach = sum over the joints of |a| + |d|        plausible = 0.006 reach

A hypothesis holds where it leaves less than a fifth of the typical residual, and less than is plausible. A
robot's own errors leave some millimetres, a wrong convention tens.

Most hypotheses need no search. Where a placement leaves less than a limit e at half of the readings, every
two of these satisfy | |p_i - p_j| - |q_i - q_j| | < 2 e with q the predictions, wherever the base stands.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import combinations
from types import MappingProxyType
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.robot import Robot
from truepose.effects.names import joint_subject
from truepose.identification.problem.initial_frames import PriorPlacement, quick_typical_mm
from truepose.kinematics.chain import nominal_chain
from truepose.messages.message import Message, message

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
    """Readings as the hypotheses see them.

    Attributes
    ----------
    joints_rad : ndarray, shape (n, J)
    nest : ndarray of int, shape (n,)
        1-based.
    position_mm : ndarray, shape (n, 3)
        World frame.
    """

    joints_rad: FloatArray
    nest: IntArray
    position_mm: FloatArray


@dataclass(frozen=True, slots=True)
class Interpretation:
    """A robot and readings as they are meant."""

    robot: Robot
    evidence: Evidence


@dataclass(frozen=True, slots=True)
class Change:
    """One change of convention; joints count from 0, nests from 1.

    Attributes
    ----------
    kind : str
        One of `KINDS`.
    first, second : int
        Joints or nests that it concerns.
    amount : float
        Factor of a coupling; shift of a zero [rad].
    """

    kind: str
    first: int = 0
    second: int = 0
    amount: float = 0.0

    @property
    def sentence(self) -> Message:
        """What it would change, in words."""
        match self.kind:
            case "nests":
                return message("convention.nests", first=self.first, second=self.second)
            case "columns":
                return message("convention.columns", first=self.first + 1, second=self.second + 1)
            case "other_way":
                return message("convention.other_way", joint=joint_subject(self.first))
            case "coupled":
                key = "convention.coupled.subtract" if self.amount < 0 else "convention.coupled.add"
                return message(key, joint=joint_subject(self.first), other=joint_subject(self.second))
            case "zero":
                return message("convention.zero", joint=joint_subject(self.first), shift=_angle(self.amount))
        return message(_OF_ALL_READINGS[self.kind])

    def applied(self, meant: Interpretation) -> Interpretation:
        """Return robot and readings with this change."""
        # A change is a value, so that one that was found can be applied to further readings too.
        return _APPLIED[self.kind](self, meant)


def _angle(shift_rad: float) -> Message:
    """Return the angle in words; conventions differ by quarter turns, crashes and cables by any angle."""
    found = float(np.rad2deg(shift_rad))
    quarter = 90.0 * round(found / 90.0)
    if abs(found - quarter) < 1.0:
        return message("convention.quarter", quarter_deg=quarter, found_deg=found)
    return message("convention.angle", found_deg=found)


def _scaled(meant: Interpretation, size: float) -> Interpretation:
    evidence = meant.evidence
    return replace(meant, evidence=replace(evidence, position_mm=evidence.position_mm * size))


def _radians(meant: Interpretation) -> Interpretation:
    evidence = meant.evidence
    # The file held radians and was read as degrees.
    return replace(meant, evidence=replace(evidence, joints_rad=np.rad2deg(evidence.joints_rad)))


def _mirrored(meant: Interpretation) -> Interpretation:
    evidence = meant.evidence
    # Which axis does not matter: the base is free, and two mirrors differ by a rotation.
    flipped = evidence.position_mm * np.array([1.0, -1.0, 1.0])
    return replace(meant, evidence=replace(evidence, position_mm=flipped))


def _nests(change: Change, meant: Interpretation) -> Interpretation:
    nest = meant.evidence.nest.copy()
    was = meant.evidence.nest
    nest[was == change.first], nest[was == change.second] = change.second, change.first
    return replace(meant, evidence=replace(meant.evidence, nest=nest))


def _columns(change: Change, meant: Interpretation) -> Interpretation:
    order = list(range(meant.evidence.joints_rad.shape[1]))
    order[change.first], order[change.second] = order[change.second], order[change.first]
    exchanged = meant.evidence.joints_rad[:, order]
    return replace(meant, evidence=replace(meant.evidence, joints_rad=exchanged))


def _coupled(change: Change, meant: Interpretation) -> Interpretation:
    coupled = meant.evidence.joints_rad.copy()
    coupled[:, change.first] += change.amount * coupled[:, change.second]
    return replace(meant, evidence=replace(meant.evidence, joints_rad=coupled))


def _other_way(change: Change, meant: Interpretation) -> Interpretation:
    rows = list(meant.robot.joints)
    rows[change.first] = replace(rows[change.first], sign=-rows[change.first].sign)
    return replace(meant, robot=replace(meant.robot, joints=tuple(rows)))


def with_zero(robot: Robot, joint: int, shift_rad: float) -> Robot:
    """Return the robot with the zero of one joint moved.

    Parameters
    ----------
    robot : Robot
    joint : int
        0-based.
    shift_rad : float
        Added to the theta offset of its row.
    """
    rows = list(robot.joints)
    rows[joint] = replace(rows[joint], theta_offset_rad=rows[joint].theta_offset_rad + shift_rad)
    return replace(robot, joints=tuple(rows))


_APPLIED: Final[Mapping[str, Callable[[Change, Interpretation], Interpretation]]] = MappingProxyType({
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


# A nominal robot is off by less than this share of its reach; beyond it something else is wrong.
_PLAUSIBLE_SHARE = 0.006
_CLEARLY_BETTER = 0.2  # a hypothesis must leave less than this share of the residual
_ZERO_STEP_RAD = np.deg2rad(15.0)
# A wrong convention shows in tens of millimetres at most readings: few are enough for some thirty
# hypotheses.
_SUBSET = 60
_COLLAPSED = 0.02  # readings that spread so much less than the flange are in another unit


def reach_mm(robot: Robot) -> float:
    """Return the sum of the link lengths [mm]: what a residual is compared with."""
    return float(sum(abs(row.a_mm) + abs(row.d_mm) for row in robot.joints))


def plausible_mm(robot: Robot) -> float:
    """Return the typical residual that a nominal robot of this size may leave [mm]."""
    return _PLAUSIBLE_SHARE * reach_mm(robot)


def change_that_fits(
    robot: Robot, evidence: Evidence, known: PriorPlacement, *, search_zeros: bool = True
) -> Change | None:
    """Return the change that makes the nominal robot fit, None where none does.

    Parameters
    ----------
    robot : Robot
        Nominal.
    evidence : Evidence
    known : PriorPlacement
        Of base and nests; the base is searched for anew.
    search_zeros : bool
        Whether a joint may count from another angle: ten times the work of all other changes.

    Returns
    -------
    Change or None
        That of the smallest typical residual; metres at once, where readings hardly spread beside the arm.
    """
    # A base that was stated is stated in a convention, too.
    free = replace(known, base=None)
    if spread_mm(evidence.position_mm) < _COLLAPSED * spread_mm(
        nominal_chain(robot, evidence.joints_rad).origin[-1]
    ):
        return Change("metres")
    meant = Interpretation(robot, thin_readings(evidence))
    # Clearly better than the table as it is: every hypothesis explains some of a robot's own errors by
    # chance.
    best, best_mm = None, min(_CLEARLY_BETTER * typical_mm(meant, free), plausible_mm(robot))
    for change in changes(meant, known):
        changed = change.applied(meant)
        typical = typical_mm(changed, free) if may_leave(changed, free, best_mm) else np.inf
        if typical < best_mm:
            best, best_mm = change, typical
    # Last, as zeros cost ten times the work of all other changes.
    if best or not search_zeros:
        return best
    return _zero_that_fits(meant, free, best_mm)


def spread_mm(points_mm: FloatArray) -> float:
    """Return the mean distance of points from their centre.

    Parameters
    ----------
    points_mm : ndarray, shape (n, 3)

    Returns
    -------
    float
        [mm]
    """
    return float(np.linalg.norm(points_mm - points_mm.mean(axis=0), axis=1).mean())


def thin_readings(evidence: Evidence) -> Evidence:
    """Return as many readings, evenly spread over the rows, as hypotheses are compared on."""
    rows = distinct_values(
        np.linspace(0, len(evidence.nest) - 1, min(len(evidence.nest), _SUBSET)).astype(np.int64)
    )
    return Evidence(evidence.joints_rad[rows], evidence.nest[rows], evidence.position_mm[rows])


def typical_mm(meant: Interpretation, known: PriorPlacement) -> float:
    """Return the median residual of the nominal robot where it is placed best.

    Parameters
    ----------
    meant : Interpretation
    known : PriorPlacement

    Returns
    -------
    float
        [mm]
    """
    evidence = meant.evidence
    chain = nominal_chain(meant.robot, evidence.joints_rad)
    return quick_typical_mm(chain, evidence.nest, evidence.position_mm, known)


def may_leave(meant: Interpretation, known: PriorPlacement, limit_mm: float) -> bool:
    """Return whether the typical residual may be below a limit, wherever the robot is placed: no search.

    Then half of the readings are nearer to where they are predicted than the limit, and every two of these
    are as far apart as predicted to twice the limit. Unknown nests may be anywhere: of them nothing is told.

    Parameters
    ----------
    meant : Interpretation
    known : PriorPlacement
    limit_mm : float

    Returns
    -------
    bool
        False only where a search is sure to leave more.
    """
    if known.nest_unknown.any():
        return True
    evidence = meant.evidence
    half = (len(evidence.nest) + 1) // 2
    predicted = nominal_chain(meant.robot, evidence.joints_rad).points(known.nests_mm[evidence.nest - 1])
    off_mm = np.abs(_distances(predicted) - _distances(evidence.position_mm))
    return int((off_mm < 2.0 * limit_mm).sum()) >= half**2  # each pair from both ends, each point with itself


def _distances(points_mm: FloatArray) -> FloatArray:
    """Return the distances between every two points (n, 3), shape (n, n)."""
    x, y, z = points_mm.T[:, :, None] - points_mm.T[:, None, :]
    return np.asarray(np.sqrt(x * x + y * y + z * z))


def changes(meant: Interpretation, known: PriorPlacement) -> Iterator[Change]:
    """Yield the changes that are tried: of units, of joints, of labels."""
    for kind in ("radians", "metres", "inches", "radians_and_metres", "left_handed"):
        yield Change(kind)
    yield from _of_joints(meant.robot.n_joints)
    yield from _exchanged_nests(known)


def _exchanged_nests(known: PriorPlacement) -> Iterator[Change]:
    """Two labels exchanged throughout; unknown nests have no place that could contradict a label."""
    # Labels are exchanged throughout: two exchanged in some rows are outliers with another nest as their
    # reason.
    certified = [int(number) + 1 for number in np.flatnonzero(~known.nest_unknown)]
    for first, second in combinations(certified, 2):
        yield Change("nests", first, second)


def _of_joints(n_joints: int) -> Iterator[Change]:
    for joint in range(n_joints):
        yield Change("other_way", joint)
    for joint in range(1, n_joints):
        for factor in (1.0, -1.0):
            yield Change("coupled", joint, joint - 1, factor)
    for joint in range(1, n_joints):
        yield Change("columns", joint - 1, joint)


def _zero_that_fits(meant: Interpretation, known: PriorPlacement, limit_mm: float) -> Change | None:
    """Try other zeros of one joint: coarse steps, then golden sections around each joint's best."""
    best: tuple[float, int, float] = (limit_mm, 0, 0.0)
    # A zero of joint 1 is a turn of the base, which is free.
    for joint in range(1, meant.robot.n_joints):
        # The whole turn: cables and couplings are put back at any angle.
        steps = np.arange(-np.pi + _ZERO_STEP_RAD, np.pi + 1e-9, _ZERO_STEP_RAD)
        coarse = [_with_zero_mm(meant, known, joint, float(shift)) for shift in steps]
        shift = _refined(meant, known, joint, float(steps[int(np.argmin(coarse))]))
        best = min(best, (_with_zero_mm(meant, known, joint, shift), joint, shift))
    _, joint, shift = best
    return None if joint == 0 else Change("zero", joint, amount=shift)


def _with_zero_mm(meant: Interpretation, known: PriorPlacement, joint: int, shift_rad: float) -> float:
    return typical_mm(replace(meant, robot=with_zero(meant.robot, joint, shift_rad)), known)


def _refined(meant: Interpretation, known: PriorPlacement, joint: int, shift: float) -> float:
    golden = (np.sqrt(5.0) - 1.0) / 2.0
    low, high = shift - _ZERO_STEP_RAD, shift + _ZERO_STEP_RAD
    inner = [high - golden * (high - low), low + golden * (high - low)]
    typical = [_with_zero_mm(meant, known, joint, one) for one in inner]
    while high - low > 1e-4:
        if typical[0] < typical[1]:
            high = inner[1]
            inner = [high - golden * (high - low), inner[0]]
            typical = [_with_zero_mm(meant, known, joint, inner[0]), typical[0]]
        else:
            low = inner[0]
            inner = [inner[1], low + golden * (high - low)]
            typical = [typical[1], _with_zero_mm(meant, known, joint, inner[1])]
    return float(0.5 * (low + high))
