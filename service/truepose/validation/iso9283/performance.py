r"""Pose accuracy and repeatability, their variation over directions, and distances: ISO 9283:1998, 7.2, 7.3.

With the attained positions p_j of one commanded pose p_c, n visits in cycles, and their barycentre p:

    AP_p = |p - p_c|                AP_x = x - x_c, ...      AP_a = a - a_c, ...
    l_j  = |p_j - p|                RP_l = mean(l) + 3 S_l   RP_a = +-3 S_a, ...

S is the sample standard deviation, over n - 1. Angles are turns from the commanded orientation, so a_c = 0.

Distance accuracy AD and repeatability RD (7.3), between the poses P2 and P4: with D_j the distance between
the two attained positions of cycle j, and D_c that between the commanded ones:

    AD = mean(D) - D_c        RD = +-3 S_D        and the same of |x_2 - x_4|, |y_2 - y_4|, |z_2 - z_4|

The same pose is visited from three directions, parallel to the axes of the base; vAP is the largest distance
between the barycentres that these give, and the largest difference of their mean angles.
"""

from collections.abc import Iterator, Sequence
from itertools import combinations
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.messages.message import Message, message
from truepose.validation.iso9283.visits import (
    RADIUS_OF_NOISE,
    Characteristic,
    CommandedPose,
    Component,
    Missing,
    Performance,
    Visits,
    barycentre,
    barycentre_covariance,
    common,
    mean_and_three_scatters,
    norm_uncertainty,
    of_mean,
    three_scatters,
    too_few,
)

CYCLES: Final = 30  # 6.9: cycles for AP, RP, vAP, AD and RD
POSES: Final = 5  # 6.8: P1 to P5
_AXES: Final[tuple[Component, ...]] = ("x", "y", "z")
_TURNS: Final[tuple[Component, ...]] = ("a", "b", "c")


def pose_performance(commanded: Sequence[CommandedPose], visits: Visits) -> Performance:
    """Return AP and RP of the five poses, of position and, where measured, of orientation.

    Parameters
    ----------
    commanded : sequence of CommandedPose
        P1 to P5.
    visits : Visits
        Of 30 cycles or more, all from the same direction.

    Returns
    -------
    Performance
        Poses with fewer measured cycles are withheld. The uncertainty of AP holds the scatter of the mean
        and, once, the instrument's stated uncertainty, which is taken not to average out; RP, which a
        constant error of the instrument does not touch, that of scatter alone.

    Raises
    ------
    ConfigurationError
        There are not five poses.
    """
    numbers = {pose.number for pose in commanded}
    if len(numbers) != POSES:
        raise ConfigurationError(
            f"ISO 9283 requires the five poses P1 to P5 (got {len(numbers)}). Measure all of them."
        )
    found = Performance((), ())
    for pose in sorted(commanded, key=lambda one: one.number):
        found = found.joined(one_pose(pose, visits, CYCLES))
    return found


def one_pose(pose: CommandedPose, visits: Visits, least: int) -> Performance:
    """Return AP and RP of one pose.

    Parameters
    ----------
    pose : CommandedPose
    visits : Visits
    least : int
        Visits that are needed, at least two.

    Returns
    -------
    Performance
        Withheld with a reason where it was visited fewer times.
    """
    reason = too_few(visits, pose.number, least)
    if reason is not None:
        return Performance((), (Missing("AP", pose.name, reason), Missing("RP", pose.name, reason)))
    seen = visits.of_pose(pose.number)
    return Performance((*_accuracies(pose, seen), *_repeatabilities(pose, seen)), ())


def _accuracies(pose: CommandedPose, seen: Visits) -> Iterator[Characteristic]:
    """Yield AP of the position, of its components, and of the angles where they were measured."""
    away = seen.position_mm - np.array(pose.position_mm)
    # Once, and not over sqrt(n): an error of the tracker's frame is the same at every visit.
    u_mm, n = common(seen.standard_uncertainty_mm), len(seen)
    error = away.mean(axis=0)
    u = norm_uncertainty(error, barycentre_covariance(seen.position_mm) + u_mm**2 * np.eye(3))
    yield Characteristic("AP", "p", pose.name, float(np.linalg.norm(error)), u, "mm", n)
    for name, along in zip(_AXES, away.T, strict=True):
        u = float(np.hypot(of_mean(along), u_mm))
        yield Characteristic("AP", name, pose.name, float(along.mean()), u, "mm", n)
    if seen.turn_rad is not None:
        for name, turns in zip(_TURNS, seen.turn_rad.T, strict=True):
            u = float(np.hypot(of_mean(turns), _rotation(seen)))
            yield Characteristic("AP", name, pose.name, float(turns.mean()), u, "rad", n)


def _repeatabilities(pose: CommandedPose, seen: Visits) -> Iterator[Characteristic]:
    """Yield RP of the radius, and of the angles where they were measured."""
    n = len(seen)
    radius = np.linalg.norm(seen.position_mm - barycentre(seen.position_mm), axis=1)
    # Stated beside RP and not subtracted: the figure that the standard defines contains it.
    noise = RADIUS_OF_NOISE * common(seen.standard_uncertainty_mm)
    yield Characteristic("RP", "l", pose.name, *mean_and_three_scatters(radius), "mm", n, noise)
    if seen.turn_rad is not None:
        for name, turns in zip(_TURNS, seen.turn_rad.T, strict=True):
            noise = 3.0 * _rotation(seen)
            yield Characteristic("RP", name, pose.name, *three_scatters(turns), "rad", n, noise)


def _rotation(seen: Visits) -> float:
    """Return the instrument's uncertainty of a turn; 0 where nobody stated one."""
    stated = seen.rotation_uncertainty_rad
    return 0.0 if stated is None or not np.isfinite(stated).all() else common(stated)


ENDS: Final = (2, 4)
_PARTS: Final[tuple[Component, ...]] = ("p", "x", "y", "z")


def distance_performance(commanded: Sequence[CommandedPose], visits: Visits) -> Performance:
    """Return AD and RD between P2 and P4.

    Parameters
    ----------
    commanded : sequence of CommandedPose
        The two among them.
    visits : Visits

    Returns
    -------
    Performance
        Withheld where fewer than 30 cycles hold both ends. The instrument's stated uncertainty counts once
        for each end in AD; it does not touch RD. First order fails for a part that is commanded to be 0,
        whose size cannot fall: what is stated there is too large.

    Raises
    ------
    ConfigurationError
        One of the two poses is not commanded.
    """
    places = {pose.number: np.array(pose.position_mm) for pose in commanded}
    for number in ENDS:
        if number not in places:
            raise ConfigurationError(
                f"P{number} is missing from the commanded poses, so the distance cannot be evaluated."
            )
    subject = f"P{ENDS[0]}-P{ENDS[1]}"
    # Of one cycle: between two cycles the arm may have drifted, which is no scatter of a distance.
    one, other = _of_both(visits)
    if len(one) < CYCLES:
        reason = _reason(visits, len(one))
        return Performance((), (Missing("AD", subject, reason), Missing("RD", subject, reason)))
    asked = places[ENDS[0]] - places[ENDS[1]]
    return Performance(tuple(_figures(one, other, asked, subject)), ())


def _of_both(visits: Visits) -> tuple[Visits, Visits]:
    """Return the visits of both ends, of the cycles that hold both."""
    one, other = (visits.of_pose(number) for number in ENDS)
    _, first, second = np.intersect1d(one.cycle, other.cycle, return_indices=True)
    return one.taken(first), other.taken(second)


def _reason(visits: Visits, both: int) -> Message:
    """Return why the distance between the two poses is withheld."""
    # An end with too few visits is the plainer reason; else each has enough, but not in the same cycles.
    reasons = [why for number in ENDS if (why := too_few(visits, number, CYCLES)) is not None]
    return reasons[0] if reasons else message("poses.both_ends", both=both, least=CYCLES)


def _figures(one: Visits, other: Visits, asked: FloatArray, subject: str) -> Iterator[Characteristic]:
    """Yield AD and RD of the distance and of the sizes of its components."""
    n, apart = len(one), one.position_mm - other.position_mm
    ends = float(np.hypot(common(one.standard_uncertainty_mm), common(other.standard_uncertainty_mm)))
    lengths = (np.linalg.norm(apart, axis=1), *np.abs(apart).T)
    wanted = (float(np.linalg.norm(asked)), *np.abs(asked))
    for name, length, whole in zip(_PARTS, lengths, wanted, strict=True):
        u = float(np.hypot(of_mean(length), ends))
        yield Characteristic("AD", name, subject, float((length - whole).mean()), u, "mm", n)
        yield Characteristic("RD", name, subject, *three_scatters(length), "mm", n, 3.0 * ends)


DIRECTIONS: Final = 3
DIRECTION_POSES: Final = (1, 2, 4)  # those that the test visits


def direction_performance(
    approaches: Sequence[Visits], poses: Sequence[int] = DIRECTION_POSES
) -> Performance:
    """Return vAP of each pose.

    Parameters
    ----------
    approaches : sequence of Visits
        Three, one per direction.
    poses : sequence of int
        Numbers of the poses that were visited.

    Returns
    -------
    Performance
        A pose that one of the directions visited in fewer than 30 cycles is withheld. A constant error
        of the instrument cancels and is not in the uncertainty.

    Raises
    ------
    ConfigurationError
        There are not three directions.
    """
    if len(approaches) != DIRECTIONS:
        raise ConfigurationError(
            f"vAP requires measurements from three directions of approach (got {len(approaches)})."
        )
    found = Performance((), ())
    for number in poses:
        found = found.joined(_one_pose(approaches, number))
    return found


def _one_pose(approaches: Sequence[Visits], number: int) -> Performance:
    """Return vAP of one pose; withheld where one direction visited it too seldom."""
    for place, visits in enumerate(approaches, start=1):
        reason = too_few(visits, number, CYCLES)
        if reason is not None:
            why = message("poses.from_direction", direction=place, reason=reason)
            return Performance((), (Missing("vAP", f"P{number}", why),))
    seen = [visits.of_pose(number) for visits in approaches]
    return Performance((_of_position(seen, number), *_of_angles(seen, number)), ())


def _of_position(seen: Sequence[Visits], number: int) -> Characteristic:
    """Return vAP of the position: the largest of the three distances between barycentres."""
    one, other = max(combinations(seen, 2), key=lambda pair: float(np.linalg.norm(_shift_mm(*pair))))
    shift = _shift_mm(one, other)
    covariance = barycentre_covariance(one.position_mm) + barycentre_covariance(other.position_mm)
    u = norm_uncertainty(shift, covariance)
    value = float(np.linalg.norm(shift))
    return Characteristic("vAP", "p", f"P{number}", value, u, "mm", sum(map(len, seen)))


def _shift_mm(one: Visits, other: Visits) -> FloatArray:
    """Return the vector from one barycentre to another, shape (3,)."""
    return barycentre(one.position_mm) - barycentre(other.position_mm)


def _of_angles(seen: Sequence[Visits], number: int) -> Iterator[Characteristic]:
    """Yield vAP of each angle: the largest less the smallest mean; nothing where no angles were measured."""
    turns = [visits.turn_rad for visits in seen if visits.turn_rad is not None]
    if len(turns) != len(seen):
        return
    for axis, name in enumerate(_TURNS):
        means = [float(turn[:, axis].mean()) for turn in turns]
        low, high = int(np.argmin(means)), int(np.argmax(means))
        u = float(np.hypot(of_mean(turns[low][:, axis]), of_mean(turns[high][:, axis])))
        value = means[high] - means[low]
        yield Characteristic("vAP", name, f"P{number}", value, u, "rad", sum(map(len, seen)))
