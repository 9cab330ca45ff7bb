"""Drift of pose accuracy dAP and of pose repeatability dRP, ISO 9283:1998, 7.6.

A pose is measured in groups of visits while the robot works from cold for eight hours. dAP and dRP are the
largest changes of AP and RP against the first group. The change of AP alone hides a barycentre that walks
around the commanded pose, so the largest way of the barycentre is said beside it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Final

import numpy as np

from truepose.domain.errors import ConfigurationError
from truepose.domain.sentences import Sentence, said
from truepose.judgement.iso9283.characteristics import (
    Characteristic,
    Component,
    Performance,
    Symbol,
    Withheld,
)
from truepose.judgement.iso9283.moments import barycentre
from truepose.judgement.iso9283.pose import one_pose
from truepose.judgement.iso9283.visits import CommandedPose, Visits

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
    """Visits that were measured in one go, and when."""

    time_s: float
    visits: Visits


@dataclass(frozen=True, slots=True)
class Drift:
    """What changed over the hours."""

    performance: Performance
    walk_mm: float | None  # largest way of the barycentre from where it was first; None where withheld
    hours: float


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
        Withheld where the groups do not span eight hours or one of them has fewer than ten visits. What
        the instrument has in common in two groups cancels, and is not in the uncertainty.

    Raises
    ------
    ConfigurationError
        There are fewer than two groups, or they are not in order of time.
    """
    times = [group.time_s for group in groups]
    if len(groups) < 2 or any(later <= earlier for earlier, later in pairwise(times)):
        raise ConfigurationError("Drift is a change: give two groups of visits or more, in order of time.")
    hours = (times[-1] - times[0]) / 3600.0
    found = [one_pose(pose, _without_instrument(group.visits), LEAST_VISITS) for group in groups]
    reason = _reason(found, hours)
    if reason is not None:
        withheld = tuple(Withheld(symbol, pose.name, reason) for symbol, _, _ in _OF_POSITION)
        return Drift(Performance((), withheld), None, hours)
    figures = [change for kind in _CHANGES if (change := _largest_change(found, *kind)) is not None]
    return Drift(Performance(tuple(figures), ()), _walk_mm(pose, groups), hours)


def _without_instrument(visits: Visits) -> Visits:
    nothing = np.zeros(len(visits))
    return replace(visits, standard_uncertainty_mm=nothing, rotation_uncertainty_rad=None)


def _reason(found: Sequence[Performance], hours: float) -> Sentence | None:
    if 3600.0 * hours < LEAST_S:
        return said("poses.hours", hours=hours)
    for number, group in enumerate(found, start=1):
        if group.withheld:
            return said("poses.in_group", group=number, reason=group.withheld[0].reason)
    return None


def _largest_change(
    found: Sequence[Performance], change: Symbol, of: Symbol, component: Component
) -> Characteristic | None:
    figures = [group.largest(of, component) for group in found]
    known = [figure for figure in figures if figure is not None]
    if len(known) < len(found):
        return None
    first, *later = known
    far = max(later, key=lambda figure: abs(figure.value - first.value))
    u = float(np.hypot(first.standard_uncertainty, far.standard_uncertainty))
    value = abs(far.value - first.value)
    return Characteristic(
        change, component, first.subject, value, u, first.unit, sum(c.visits for c in known)
    )


def _walk_mm(pose: CommandedPose, groups: Sequence[Group]) -> float:
    places = np.array([barycentre(group.visits.of_pose(pose.number).position_mm) for group in groups])
    return float(np.linalg.norm(places - places[0], axis=1).max())
