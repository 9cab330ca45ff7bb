r"""Pose accuracy and pose repeatability, ISO 9283:1998, 7.2.1 and 7.2.2.

With the attained positions p_j of one commanded pose p_c, n visits in cycles, and their barycentre p:

    AP_p = |p - p_c|                AP_x = x - x_c, ...      AP_a = a - a_c, ...
    l_j  = |p_j - p|                RP_l = mean(l) + 3 S_l   RP_a = +-3 S_a, ...

S is the sample standard deviation, over n - 1. Angles are turns from the commanded orientation, so a_c = 0.
"""

from collections.abc import Iterator, Sequence
from typing import Final

import numpy as np

from truepose.domain.errors import ConfigurationError
from truepose.judgement.iso9283.characteristics import Characteristic, Component, Performance, Withheld
from truepose.judgement.iso9283.moments import (
    RADIUS_OF_NOISE,
    barycentre,
    barycentre_covariance,
    common,
    mean_and_three_scatters,
    norm_uncertainty,
    of_mean,
    three_scatters,
)
from truepose.judgement.iso9283.visits import CommandedPose, Visits, too_few

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
    if len({pose.number for pose in commanded}) != POSES:
        raise ConfigurationError(
            f"ISO 9283 asks for the five poses P1 to P5; {_are(len(commanded))} there: measure all of them."
        )
    found = Performance((), ())
    for pose in sorted(commanded, key=lambda one: one.number):
        found = found.joined(one_pose(pose, visits, CYCLES))
    return found


def one_pose(pose: CommandedPose, visits: Visits, least: int) -> Performance:
    """Return AP and RP of one pose; withheld with a reason where it was visited fewer times than `least`."""
    reason = too_few(visits, pose.number, least)
    if reason is not None:
        return Performance((), (Withheld("AP", pose.name, reason), Withheld("RP", pose.name, reason)))
    seen = visits.of_pose(pose.number)
    return Performance((*_accuracies(pose, seen), *_repeatabilities(pose, seen)), ())


def _are(n: int) -> str:
    return "one is" if n == 1 else f"{n} are"


def _accuracies(pose: CommandedPose, seen: Visits) -> Iterator[Characteristic]:
    away = seen.position_mm - np.array(pose.position_mm)
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
    n = len(seen)
    radius = np.linalg.norm(seen.position_mm - barycentre(seen.position_mm), axis=1)
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
