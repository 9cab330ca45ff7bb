"""Drift of pose accuracy dAP and of pose repeatability dRP, ISO 9283:1998, 7.6, and when a robot is warm.

A robot that has warmed up may end the test before its eight hours. Compared are two rates, each the slope of
the barycentres over an hour: that of the first hour and that of the last. A slope, since the change between
two groups ten minutes apart is mostly the scatter of the instrument.

A pose is measured in groups of visits while the robot works from cold for eight hours. dAP and dRP are the
largest changes of AP and RP against the first group. The change of AP alone hides a barycentre that walks
around the commanded pose, so the largest way of the barycentre is said beside it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.errors import ConfigurationError
from truepose.identification.distributions import chi2_limit
from truepose.messages.message import Message, message
from truepose.validation.iso9283.performance import one_pose
from truepose.validation.iso9283.visits import (
    Characteristic,
    CommandedPose,
    Component,
    Missing,
    Performance,
    Symbol,
    Visits,
    barycentre,
    barycentre_covariance,
    mean_and_three_scatters,
    norm_uncertainty,
)

SETTLED: Final = 0.1  # of the rate of the first hour
_HOUR_S: Final = 3600.0
_EARLY: Final = 0.05  # of an hour; groups are a little late, and never all by the same
_BY_SCATTER: Final = float(np.sqrt(chi2_limit(0.05, 3)))  # uncertainties; of a slope along three axes


def has_settled(time_s: FloatArray, visits_mm: Sequence[FloatArray]) -> bool:
    """Return whether the rate of change over the last hour is below a tenth of that over the first.

    A rate is the slope of the barycentres p over time by least squares, |sum (t - mean t) p| / sum (t - mean
    t)^2. A robot that hardly drifts has no rate to fall from: it has settled where neither hour, nor both
    with all between, shows a slope that the scatter of the visits does not explain.

    Parameters
    ----------
    time_s : ndarray, shape (k,)
        Of groups, ascending; k >= 1.
    visits_mm : sequence of ndarray, shape (n, 3)
        Positions of each group, n >= 1.

    Returns
    -------
    bool
        False also where the two hours overlap, or one of them holds a single group.
    """
    first = time_s <= time_s[0] + (1.0 + _EARLY) * _HOUR_S
    last = time_s >= time_s[-1] - (1.0 + _EARLY) * _HOUR_S
    # Hours that overlap share groups: their rates do not tell early from late.
    overlap = time_s[-1] - time_s[0] < (2.0 - _EARLY) * _HOUR_S
    if overlap or first.sum() < 2 or last.sum() < 2:
        return False
    places = np.array([barycentre(seen) for seen in visits_mm])
    # The scatter of a single visit is not known: taken for none, it lets more slopes stand out.
    variance = np.array([
        np.trace(barycentre_covariance(seen)) / 3 if len(seen) > 1 else 0.0 for seen in visits_mm
    ])
    early, late, whole = (
        _rate(time_s, places, variance, rows) for rows in (first, last, time_s >= time_s[0])
    )
    slowed = late.size < SETTLED * early.size
    return slowed or not (early.is_seen or late.is_seen or whole.is_seen)


@dataclass(frozen=True, slots=True)
class _Rate:
    """Size of a slope of places over time, and its standard uncertainty along each axis [mm/s]."""

    size: float
    uncertainty: float

    @property
    def is_seen(self) -> bool:
        """Whether scatter alone shows a slope as large in less than one of twenty cases."""
        return self.size >= _BY_SCATTER * self.uncertainty


def _rate(time_s: FloatArray, places_mm: FloatArray, variance_mm2: FloatArray, rows: BoolArray) -> _Rate:
    """Return how fast places move, of which each has a variance along each axis."""
    away_s = time_s[rows] - time_s[rows].mean()
    square = float(away_s @ away_s)
    slope = np.linalg.norm(away_s @ places_mm[rows]) / square
    return _Rate(float(slope), float(np.sqrt(away_s**2 @ variance_mm2[rows])) / square)


LEAST_VISITS: Final = 10  # of a group
LEAST_S: Final = 8 * 3600.0
_OF_POSITION: Final[tuple[tuple[Symbol, Symbol, Component], ...]] = (("dAP", "AP", "p"), ("dRP", "RP", "l"))
_OF_ANGLES: Final[tuple[tuple[Symbol, Symbol, Component], ...]] = (
    ("dAP", "AP", "a"),
    ("dAP", "AP", "b"),
    ("dAP", "AP", "c"),
    ("dRP", "RP", "a"),
    ("dRP", "RP", "b"),
    ("dRP", "RP", "c"),
)
_CHANGES: Final = (*_OF_POSITION, *_OF_ANGLES)


@dataclass(frozen=True, slots=True)
class Group:
    """Visits that were measured in one go.

    Attributes
    ----------
    time_s : float
        Mean of their times.
    visits : Visits
    """

    time_s: float
    visits: Visits


@dataclass(frozen=True, slots=True)
class DriftPoint:
    """One group beside the first; uncertainties are of scatter, since what the instrument adds cancels.

    Attributes
    ----------
    hours : float
        Since the first group.
    visits : int
    accuracy_mm, accuracy_uncertainty_mm : float
        AP.
    repeatability_mm, repeatability_uncertainty_mm : float
        RP.
    moved_mm, moved_uncertainty_mm : float
        Of the barycentre, from that of the first group.
    """

    hours: float
    visits: int
    accuracy_mm: float
    accuracy_uncertainty_mm: float
    repeatability_mm: float
    repeatability_uncertainty_mm: float
    moved_mm: float
    moved_uncertainty_mm: float


@dataclass(frozen=True, slots=True)
class Drift:
    """What changed over the hours.

    Attributes
    ----------
    performance : Performance
    walk_mm : float or None
        Largest distance of the barycentre from its first place; None where withheld.
    hours : float
        From the first group to the last.
    settled : bool
        The rate of change has fallen to less than a tenth.
    curve : tuple of DriftPoint
    """

    performance: Performance
    walk_mm: float | None
    hours: float
    settled: bool
    curve: tuple["DriftPoint", ...]


def drift(pose: CommandedPose, groups: Sequence[Group]) -> Drift:
    """Return dAP and dRP of one pose.

    Parameters
    ----------
    pose : CommandedPose
    groups : sequence of Group
        In order of time, the first from cold.

    Returns
    -------
    Drift
        Withheld where the groups span less than eight hours and the drift has not become slow either, or
        where one of them has fewer than ten visits. What the instrument has in common in two groups
        cancels, and is not in the uncertainty. The curve leaves out groups with fewer than two visits.

    Raises
    ------
    ConfigurationError
        There are fewer than two groups, or they are not in order of time.
    """
    times = [group.time_s for group in groups]
    if len(groups) < 2 or any(later <= earlier for earlier, later in pairwise(times)):
        raise ConfigurationError(
            "A drift test needs at least two groups of repeat measurements, in chronological order."
        )
    hours = (times[-1] - times[0]) / 3600.0
    curve = tuple(_points(pose, groups))
    settled = _settled(pose, groups)
    found = [one_pose(pose, _without_instrument(group.visits), LEAST_VISITS) for group in groups]
    reason = _reason(found, hours, settled=settled)
    if reason is not None:
        withheld = tuple(Missing(symbol, pose.name, reason) for symbol, _, _ in _OF_POSITION)
        return Drift(Performance((), withheld), None, hours, settled, curve)
    figures = [change for kind in _CHANGES if (change := _largest_change(found, *kind)) is not None]
    walk_mm = max(point.moved_mm for point in curve)
    return Drift(Performance(tuple(figures), ()), walk_mm, hours, settled, curve)


def _without_instrument(visits: Visits) -> Visits:
    """Return the visits as if the instrument were perfect: what it adds is the same in every group."""
    nothing = np.zeros(len(visits))
    return replace(visits, standard_uncertainty_mm=nothing, rotation_uncertainty_rad=None)


def _settled(pose: CommandedPose, groups: Sequence[Group]) -> bool:
    """Return whether the drift has become slow, by the groups in which the pose was measured at all."""
    seen = [(group.time_s, group.visits.of_pose(pose.number).position_mm) for group in groups]
    times, places = np.array([time_s for time_s, _ in seen]), [places for _, places in seen]
    measured = np.array([len(visits) > 0 for visits in places])
    return bool(measured.any()) and has_settled(times[measured], [visits for visits in places if len(visits)])


def _points(pose: CommandedPose, groups: Sequence[Group]) -> Iterator[DriftPoint]:
    """Yield a point for each group with two visits or more."""
    seen = [(group.time_s, _without_instrument(group.visits).of_pose(pose.number)) for group in groups]
    measured = [(time_s, visits) for time_s, visits in seen if len(visits) > 1]
    for time_s, visits in measured:
        yield _point(pose, time_s - groups[0].time_s, visits, measured[0][1])


def _point(pose: CommandedPose, since_s: float, visits: Visits, first: Visits) -> DriftPoint:
    """Return one group against the commanded pose and the first group."""
    place, away = barycentre(visits.position_mm), barycentre_covariance(visits.position_mm)
    error, moved = place - np.array(pose.position_mm), place - barycentre(first.position_mm)
    radius = np.linalg.norm(visits.position_mm - place, axis=1)
    apart = away + barycentre_covariance(first.position_mm)
    return DriftPoint(
        since_s / 3600.0,
        len(visits),
        float(np.linalg.norm(error)),
        norm_uncertainty(error, away),
        *mean_and_three_scatters(radius),
        float(np.linalg.norm(moved)),
        # The first group has moved by 0 by definition, which is not uncertain.
        0.0 if visits is first else norm_uncertainty(moved, apart),
    )


def _reason(found: Sequence[Performance], hours: float, *, settled: bool) -> Message | None:
    """Return why the drift is withheld; None where it is not."""
    if 3600.0 * hours < LEAST_S and not settled:
        return message("poses.hours", hours=hours)
    for number, group in enumerate(found, start=1):
        if group.withheld:
            return message("poses.in_group", group=number, reason=group.withheld[0].reason)
    return None


def _largest_change(
    found: Sequence[Performance], change: Symbol, of: Symbol, component: Component
) -> Characteristic | None:
    """Return the largest change of a figure against the first group; None where a group lacks the figure."""
    figures = [group.largest(of, component) for group in found]
    known = [figure for figure in figures if figure is not None]
    # The largest change may have been in the group that lacks the figure.
    if len(known) < len(found):
        return None
    first, *later = known
    far = max(later, key=lambda figure: abs(figure.value - first.value))
    u = float(np.hypot(first.standard_uncertainty, far.standard_uncertainty))
    value = abs(far.value - first.value)
    return Characteristic(
        change, component, first.subject, value, u, first.unit, sum(c.visits for c in known)
    )
