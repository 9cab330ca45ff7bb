"""Joint targets at which the legs have given lengths under a model, coded so that exchanges show.

Coded lengths: the legs of a pose aim at lengths that differ, so that exchanged legs betray themselves. Six
lengths fix six degrees of freedom, so every leg of a pose may have a length of its own. The levels are spread
evenly over +-0.7 mm, which leaves 0.3 mm of the ballbar's range for what the aim misses.

Legs that follow each other share a ball and are the ones that are confused most easily; their levels are at
least two steps apart. From pose to pose all levels move on by one, so no leg has always the same.

The lengths come from a function, so that any model serves: the nominal robot, or an identified one with cups
where it found them. Derivatives are differences; the function is called once per pass with all of them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import PlannedPose
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.planning.ballbar.bodies import BallbarCell, BaseFixture
from truepose.planning.ballbar.clearance import is_clear
from truepose.planning.ballbar.motion_clearance import Stop, Surroundings
from truepose.planning.ballbar.paths import Tour, tour
from truepose.planning.errors import AimError, ArmInTheWayError

SPAN_MM: Final = 0.7


def coded_lengths(n_legs: int, turn: int = 0) -> tuple[float, ...]:
    """Return the offsets of n legs from the nominal length.

    Parameters
    ----------
    n_legs : int
        Six in general: +-0.7 mm in steps of 0.28. Others: as many levels, spread over the same span.
    turn : int
        Number of the pose: which leg has which level.

    Returns
    -------
    tuple of float
        [mm] in the order of the legs, all different, their levels evenly spread. Legs that follow each other
        are two levels apart or more where there are five legs or more; of three and four some are neighbours.

    Raises
    ------
    ConfigurationError
        There is no leg.
    """
    if n_legs < 1:
        raise ConfigurationError(f"A pose needs at least one ballbar length to code (got {n_legs}).")
    if n_legs == 1:
        return (0.0,)
    spacing = 2.0 * SPAN_MM / (n_legs - 1)
    levels = ((level + turn) % n_legs for level in _interleaved(n_legs))
    return tuple(spacing * level - SPAN_MM for level in levels)


def _interleaved(n: int) -> list[int]:
    """Numbers 0..n-1 with those that follow each other far apart: 0 3 1 4 2 5 for six."""
    half = (n + 1) // 2
    return [level for pair in range(half) for level in (pair, pair + half) if level < n]


Lengths: TypeAlias = Callable[[FloatArray], FloatArray]  # joints (n, J) -> lengths (n, L) [mm]

_DIFFERENCE_RAD: Final = 1e-5  # lengths of 300 mm are right to 1e-10 mm, so derivatives to 1e-5 mm/rad
_PASSES: Final = 20
_MET_MM: Final = 1e-4  # a fifth of the ballbar's scatter
_FARTHEST_RAD: Final = float(np.radians(8.0))  # any joint from where it started
_FLATTEST: Final = 1e-3  # smallest over largest singular value: beyond, a leg cannot be set on its own


def aim_joints(
    lengths: Lengths,
    joints_rad: Sequence[float] | FloatArray,
    wanted_mm: Sequence[float] | FloatArray,
    ranges: tuple[JointRange, ...] | None = None,
) -> FloatArray:
    """Return joints near the given ones at which the legs have the wanted lengths.

    Newton's method on the lengths, l(q) + J dq = wanted, with the shortest dq where there are fewer legs than
    joints.

    Parameters
    ----------
    lengths : callable, (n, J) -> (n, L)
        Lengths of the legs [mm] at joints [rad].
    joints_rad : array_like, shape (J,)
        Where to start: the planned pose.
    wanted_mm : array_like, shape (L,)
    ranges : tuple of JointRange, optional
        That the joints must not leave.

    Returns
    -------
    ndarray, shape (J,)
        On the branch of the start: no joint moved by more than 8 deg, no singular arm on the way. Lengths are
        met to 1e-4 mm.

    Raises
    ------
    AimError
        No such joints are there; it says why.
    ConfigurationError
        The lengths are not as many as those wanted.
    """
    start = np.asarray(joints_rad, dtype=float)
    wanted = np.asarray(wanted_mm, dtype=float)
    joints, side = start, 0.0
    for _ in range(_PASSES):
        now, jacobian = _linearised(lengths, joints)
        if now.shape != wanted.shape:
            raise ConfigurationError(
                f"{wanted.size} target lengths were given for {now.size} ballbar lengths."
            )
        side = _same_side(jacobian, side)
        if np.max(np.abs(wanted - now)) < _MET_MM:
            return _within(joints, ranges)
        step = np.linalg.lstsq(jacobian, wanted - now, rcond=None)[0]
        joints = joints + step
        if np.max(np.abs(joints - start)) > _FARTHEST_RAD:
            raise AimError(
                f"Joint {int(np.argmax(np.abs(joints - start))) + 1} would have to move by more than "
                f"{np.degrees(_FARTHEST_RAD):.0f} deg to reach these ballbar lengths. Choose other target "
                "lengths."
            )
    raise AimError(
        "No joint angles near this pose reach the target ballbar lengths: an error of "
        f"{np.max(np.abs(wanted - now)):.3f} mm remains."
    )


def _linearised(lengths: Lengths, joints: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return lengths (L,) [mm] and their derivatives (L, J) [mm/rad], by central differences of 1e-5 rad."""
    steps = _DIFFERENCE_RAD * np.eye(len(joints))
    found = np.asarray(lengths(np.concatenate([joints[None], joints + steps, joints - steps])))
    if not np.all(np.isfinite(found)):
        raise AimError(
            "The model gives no ballbar lengths at this pose. Check the joint angles and the cups."
        )
    plus, minus = np.split(found[1:], 2)
    return found[0], np.asarray((plus - minus).T / (2 * _DIFFERENCE_RAD))


def _same_side(jacobian: FloatArray, before: float) -> float:
    """Sign of the determinant, 0 where there is none; refuses a singular arm and one that went through it."""
    values = np.linalg.svd(jacobian, compute_uv=False)
    if values[-1] < _FLATTEST * values[0]:
        raise AimError(
            "The arm or the ballbar arrangement is singular at this pose, so its lengths cannot be set "
            "independently."
        )
    rows, columns = jacobian.shape
    # Between two passes the arm may step over a singularity without standing in it; the determinant then
    # changes sign.
    side = float(np.sign(np.linalg.det(jacobian))) if rows == columns else 0.0
    if side * before < 0.0:
        raise AimError(
            "The arm would have to pass through a singularity to reach these ballbar lengths. Choose other "
            "target lengths."
        )
    return side


def _within(joints: FloatArray, ranges: tuple[JointRange, ...] | None) -> FloatArray:
    for number, (angle, limit) in enumerate(zip(joints, ranges or (), strict=False), start=1):
        if not limit.lower_rad <= angle <= limit.upper_rad:
            raise AimError(
                f"Joint {number} would have to move to {np.degrees(angle):.2f} deg, outside its range "
                f"({np.degrees(limit.lower_rad):g} to {np.degrees(limit.upper_rad):g} deg)."
            )
    return joints


def aimed_pose(
    pose: PlannedPose,
    lengths: Lengths,
    nominal_mm: float,
    ranges: tuple[JointRange, ...] | None = None,
) -> PlannedPose:
    """Return a pose with coded lengths under a model.

    Parameters
    ----------
    pose : PlannedPose
    lengths : callable
        As in `aim_joints`, in the order of the pose's legs.
    nominal_mm : float
        About which lengths are coded.
    ranges : tuple of JointRange, optional
        That the joints must not leave.

    Returns
    -------
    PlannedPose
        With its new joints, and the lengths that it is aimed at.

    Raises
    ------
    AimError
        The code cannot be reached near the pose, whichever leg has which level.
    """
    refusals: list[AimError] = []
    for turn in range(len(pose.legs)):
        # Another turn gives the levels to other legs: one of six codes may be reached where the
        # others are not.
        offsets_mm = coded_lengths(len(pose.legs), pose.config + turn)
        wanted = tuple(nominal_mm + offset for offset in offsets_mm)
        try:
            joints = aim_joints(lengths, pose.joints_rad, wanted, ranges)
        except AimError as refusal:
            refusals.append(refusal)
        else:
            return replace(pose, joints_rad=tuple(float(q) for q in joints), aimed_mm=wanted)
    # Of the code that was wanted first; the others were makeshifts.
    raise AimError(f"Configuration {pose.config} cannot be given coded ballbar lengths. {refusals[0]}")


# An aim moves the tool by a millimetre or two, and so far the cups may be from where they were planned.
_ROOM_USED_MM: Final = 3.0


@dataclass(frozen=True, slots=True)
class AimedAgain:
    """Poses in the order in which they are to be measured."""

    poses: tuple[PlannedPose, ...]
    refusals: tuple[str, ...]  # a sentence for each that could not be coded, or to which no way leads


def aimed_again(
    cell: BallbarCell,
    fixture: BaseFixture,
    poses: Sequence[PlannedPose],
    lengths: Callable[[PlannedPose], Lengths],
    here_rad: Sequence[float],
    *,
    last: int | None = None,
    after: BaseFixture | None = None,
    seed: int = 0,
) -> AimedAgain:
    """Aim the poses of one placement at coded lengths under a model, and plan the ways between them.

    Parameters
    ----------
    cell : BallbarCell
    fixture : BaseFixture
        Of the placement of all these poses.
    poses : sequence of PlannedPose
        Those not measured yet, those skipped, those whose legs were exchanged.
    lengths : callable
        From a pose to the function that predicts the lengths of its legs, in their order.
    here_rad : sequence of float
        Where the arm is.
    last : int, optional
        Configuration that stays the last one, if it can: where the arm waits while the base fixture is put
        elsewhere.
    after : BaseFixture, optional
        At its next place, of which the arm is clear at its last pose.
    seed : int
        For the search for ways.

    Returns
    -------
    AimedAgain
        A pose that cannot be coded is aimed at nominal lengths, or stays as it was. One to which no clear way
        leads is left out.

    Raises
    ------
    ArmInTheWayError
        At none of the poses is the arm clear of the next place.
    """
    aims = [coded_or_kept(cell, pose, lengths(pose)) for pose in poses]
    new = [pose for pose, _ in aims]
    around = Surroundings(replace(cell, arm_room_mm=cell.arm_room_mm - _ROOM_USED_MM), fixture)
    joints = np.array([pose.joints_rad for pose in new]).reshape(-1, cell.robot.n_joints)
    begin = Stop(np.array(here_rad, dtype=float))
    ends = [row for row, pose in enumerate(new) if pose.config == last]
    if after is None or not new:
        found = _tour_to(around, joints, ends, begin, seed)
    else:
        found = _tour_clear_of(after, around, joints, ends, begin, seed)
    ordered = tuple(replace(new[row], via_rad=via) for row, via in zip(found.order, found.vias, strict=True))
    missed = (
        f"No collision-free path to configuration {new[row].config} was found; it is left out."
        for row in found.missed
    )
    return AimedAgain(ordered, (*(said for _, said in aims if said is not None), *missed))


_ENDS_TRIED: Final = 5


def _tour_clear_of(
    after: BaseFixture,
    around: Surroundings,
    joints_rad: FloatArray,
    ends: Sequence[int],
    here: Stop,
    seed: int,
) -> Tour:
    """Return a tour of stops (n, J) whose last one is clear of the next fixture, one of `ends` if it can be.

    No way may lead to those, or they are measured already. Raises ArmInTheWayError where none is clear.
    """
    free = is_clear(around.cell, after, joints_rad)
    usable = [row for row in (*ends, *range(len(joints_rad))) if free[row]]
    tours = (_tour_to(around, joints_rad, [end], here, seed) for end in dict.fromkeys(usable[:_ENDS_TRIED]))
    found = next((one for one in tours if one.order and free[one.order[-1]]), None)
    if found is None:
        raise ArmInTheWayError(after.number)
    return found


def _tour_to(
    around: Surroundings, joints_rad: FloatArray, ends: Sequence[int], here: Stop, seed: int
) -> Tour:
    others = [row for row in range(len(joints_rad)) if row not in ends]
    return tour(around, joints_rad, [others, list(ends)], here, np.random.default_rng(seed))


def coded_or_kept(cell: BallbarCell, pose: PlannedPose, lengths: Lengths) -> tuple[PlannedPose, str | None]:
    """Return a pose at coded lengths, else at nominal ones, else as it was.

    Parameters
    ----------
    cell : BallbarCell
    pose : PlannedPose
    lengths : callable
        As in `aimed_pose`.

    Returns
    -------
    pose : PlannedPose
    sentence : str or None
        Why it is not coded; None: it is.
    """
    try:
        return aimed_pose(pose, lengths, cell.leg_mm, cell.ranges), None
    except AimError as refusal:
        # Nominal lengths are at least within the bar's range; as it was, a pose of an arm that errs
        # may not be.
        sentence = str(refusal)
    try:
        joints = aim_joints(lengths, pose.joints_rad, np.full(len(pose.legs), cell.leg_mm), cell.ranges)
    except AimError:
        return replace(pose, aimed_mm=None), f"{sentence} The configuration stays as planned."
    plain = replace(pose, joints_rad=tuple(float(q) for q in joints), aimed_mm=None)
    return plain, f"{sentence} Its ballbar lengths are all set to nominal."
