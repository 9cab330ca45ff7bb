"""What to measure next: actions and configurations that would tell causes apart, or show an unknown one."""

from collections.abc import Sequence

import numpy as np

from service.diagnosis.actions import (
    ALL_NESTS,
    AT_THE_END,
    BOTH_SIDES,
    REMOUNT,
    WARM_AND_COLD,
    Action,
    action_for,
)
from service.diagnosis.left import Depends, Left
from service.diagnosis.places import Places, drawn, filling, moved_alone
from service.diagnosis.selection import Selected
from service.diagnosis.separation import CONVINCING, separation
from service.diagnosis.start import Start
from service.diagnosis.wording import spoken
from service.domain.arrays import FloatArray
from service.domain.diagnosis import Cause, Finding, NextMeasurement
from service.effects.causes import Candidate

_PLACES = 300
_SEED = 20140  # the same data are always answered by the same configurations
_RIVALS = 3  # the closest of each finding
_FEW = 5
_REPEATS = (1, 2, 4, 8)
_SLOW_ORDER = 6.0  # faster waves are stepped through, one period
_SEEN = "where the instrument sees them"

Configurations = tuple[tuple[float, ...], ...]


def next_measurements(
    start: Start,
    selected: Selected,
    groups: tuple[tuple[str, tuple[Candidate, ...]], ...],
    findings: tuple[Finding, ...],
    left: Left,
) -> tuple[NextMeasurement, ...]:
    """Return what would separate rivals, or show what nothing explains.

    Parameters
    ----------
    start : Start
    selected : Selected
    groups : tuple of (subject, candidates)
        What each finding is made of.
    findings : tuple of Finding
    left : Left

    Returns
    -------
    tuple of NextMeasurement
        Of findings in their order, then of what is left; configurations [deg] within the measured ranges.
    """
    asked = [finding for finding in findings if finding.confusable_with]
    dependent = left.depends or (left.structure and not _revisited(start))
    if not asked and not dependent:
        return ()
    rng = np.random.default_rng(_SEED)
    places = drawn(start, selected, _PLACES, rng)
    found: list[NextMeasurement] = []
    for finding in asked:
        found += _by_action(start, finding)
        group = next((picks for _, picks in groups if _parameters(picks) == set(finding.parameters)), None)
        if group is not None:
            found += _by_configuration(start, selected, group, finding, places)
    found += [_of_dependence(start, depends, places, rng) for depends in left.depends]
    if left.structure and not left.depends and not _revisited(start):
        found.append(_revisit(start))
    return _merged(found)


def _parameters(picks: Sequence[Candidate]) -> set[str]:
    return {name for pick in picks for name in pick.names}


def _cause(finding: Finding) -> Cause:
    return Cause(finding.effect, finding.subject)


def _by_action(start: Start, finding: Finding) -> list[NextMeasurement]:
    own, found = _cause(finding), list[NextMeasurement]()
    for rival in finding.confusable_with[:_RIVALS]:
        action = action_for(own, rival)
        if action is not None:
            found.append(_told(start, action, own, rival))
    return found


def _told(start: Start, action: Action, own: Cause, rival: Cause) -> NextMeasurement:
    return NextMeasurement(
        f"{action.do}: it tells {spoken(own)} from {spoken(rival)}.",
        _first(start) if action.again else (),
        (own, rival),
    )


def _by_configuration(
    start: Start, selected: Selected, group: Sequence[Candidate], finding: Finding, places: Places
) -> list[NextMeasurement]:
    own = _cause(finding)
    rivals = [rival for rival in finding.confusable_with[:_RIVALS] if action_for(own, rival) is None]
    found: list[NextMeasurement] = []
    if start.scene.legs:
        return [_other_poses(own, rivals)] if rivals else []
    for repeats in _REPEATS:
        if not rivals:
            return found
        chosen = separation(selected, group, rivals, places, repeats)
        exposed = [rival for rival, worth in zip(rivals, chosen.chi_square, strict=True) if worth >= CONVINCING]
        if exposed:
            found.append(_configured(own, exposed, _listed(places.joints_deg[list(chosen.rows)]), repeats))
        rivals = [rival for rival in rivals if rival not in exposed]
    return [*found, _wider(own, rivals)] if rivals else found


def _configured(
    own: Cause, rivals: Sequence[Cause], configurations: Configurations, repeats: int
) -> NextMeasurement:
    times = "" if repeats == 1 else f", {repeats} times each"
    return NextMeasurement(
        f"Measure {_counted(configurations)}{times}, {_SEEN}: "
        f"there {spoken(own)} acts otherwise than {_either(rivals)}.",
        configurations,
        (own, *rivals),
    )


def _wider(own: Cause, rivals: Sequence[Cause]) -> NextMeasurement:
    return NextMeasurement(
        f"Measure over wider ranges of the joints, or with another load: within the ranges measured so far no "
        f"few configurations tell {spoken(own)} from {_either(rivals)}.",
        (),
        (own, *rivals),
    )


def _other_poses(own: Cause, rivals: Sequence[Cause]) -> NextMeasurement:
    return NextMeasurement(
        f"Measure more poses, with the base fixture at another place: the arm is then bent and loaded "
        f"differently, which tells {spoken(own)} from {_either(rivals)}.",
        (),
        (own, *rivals),
    )


def _of_dependence(
    start: Start, depends: Depends, places: Places, rng: np.random.Generator
) -> NextMeasurement:
    about = f"what is left depends on the {depends.variable}"
    match depends.kind:
        case "direction":
            return NextMeasurement(f"{BOTH_SIDES}: {about}.", ())
        case "nest":
            return NextMeasurement(f"{ALL_NESTS}: {about}.", ())
        case "time":
            return NextMeasurement(f"{AT_THE_END}: {about}.", _first(start))
        case "temperature":
            return NextMeasurement(f"{WARM_AND_COLD}: {about}.", _first(start))
        case "attachment":
            return NextMeasurement(f"{REMOUNT}: {about}.", _first(start))
    if start.scene.legs:
        return NextMeasurement(f"Measure more poses, with the base fixture at another place: {about}.", ())
    configurations = _listed(_telling(start, depends, places, rng))
    return NextMeasurement(
        f"Measure {_counted(configurations)}, {_SEEN}: {about}, and {_why(depends)}.", configurations
    )


def _why(depends: Depends) -> str:
    if depends.kind == "place":
        return "these lie farthest from what was measured"
    if depends.joint is not None and depends.order > _SLOW_ORDER:
        return f"these step joint {depends.joint + 1} through one period of the wave"
    return "these lie in its largest gaps"


def _telling(start: Start, depends: Depends, places: Places, rng: np.random.Generator) -> FloatArray:
    """Configurations [deg] that show a dependence best, shape (<= 5, J)."""
    scene, joint = start.scene, depends.joint
    if joint is None:
        chain = places.state.chain
        return places.joints_deg[filling(chain.end_origin, scene.chain.end_origin, _FEW)]
    if depends.kind == "torque" and places.torque_n_mm is not None and scene.torque_n_mm is not None:
        there, here = places.torque_n_mm[:, [joint]], scene.torque_n_mm[:, [joint]]
        return places.joints_deg[filling(there, here, _FEW)]
    if depends.order > _SLOW_ORDER:
        return one_period(start, joint, depends.order)
    alone = moved_alone(start, joint, _PLACES, rng)
    measured = np.rad2deg(scene.stops.joints_rad[:, [joint]])
    return alone[filling(alone[:, [joint]], measured, _FEW)]
