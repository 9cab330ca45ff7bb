"""What to measure next: actions and configurations that would tell causes apart, or show an unknown one."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from truepose.diagnosis.advice.actions import (
    ALL_NESTS,
    AT_THE_END,
    BOTH_SIDES,
    REMOUNT,
    WARM_AND_COLD,
    Action,
    action_for,
)
from truepose.diagnosis.advice.configurations import (
    Places,
    drawn,
    filling,
    joint_limits,
    measured_ranges,
    moved_alone,
    one_period,
)
from truepose.diagnosis.advice.separation import CONVINCING, separation
from truepose.diagnosis.evidence.structure_left import Depends, Left
from truepose.diagnosis.screening.groups import names_of
from truepose.diagnosis.screening.selection import Selected
from truepose.diagnosis.sentences import spoken
from truepose.diagnosis.start import Start
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Cause, Finding, NextMeasurement
from truepose.effects.causes import Candidate
from truepose.effects.joints.joint_harmonics import ONE_PERIOD_FROM

_PLACES = 300
_SEED = 20140  # the same data are always answered by the same configurations
_RIVALS = 3  # the closest of each finding
_FEW = 5
_TOLD = 2  # dependences of what is left: those that its sentence names
_STILL_DEG = 5.0  # a joint that turned by less did not take part
_REPEATS = (2, 4, 8)
_SEEN = "where the instrument sees them"
_BEYOND = " They lie beyond the ranges measured so far: make sure that nothing is in the way."

Configurations = tuple[tuple[float, ...], ...]
Pair = tuple[Cause, Cause]  # a finding and its rival


@dataclass(frozen=True, slots=True)
class _Duel:
    """A finding that is to be told from its rivals."""

    start: Start
    selected: Selected
    group: Sequence[Candidate]
    own: Cause


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
    pairs = _pairs(findings)
    unseen = left.structure and not left.depends and not _revisited(start)
    if not pairs and not left.depends:
        return (_revisit(start),) if unseen else ()
    rng = np.random.default_rng(_SEED)
    places = drawn(start, selected, measured_ranges(start), _PLACES, rng)
    found = _by_action(start, pairs)
    for finding in findings:
        own = _cause(finding)
        group = next((picks for _, picks in groups if set(names_of(picks)) == set(finding.parameters)), ())
        rivals = [rival for one, rival in pairs if one == own and action_for(one, rival) is None]
        if group and rivals:
            found += _by_configuration(_Duel(start, selected, group, own), rivals, places, rng)
    found += [_of_dependence(start, depends, places, rng) for depends in left.depends[:_TOLD]]
    return (*found, _revisit(start)) if unseen else tuple(_once(found))


def _cause(finding: Finding) -> Cause:
    return Cause(finding.effect, finding.subject)


def _pairs(findings: tuple[Finding, ...]) -> list[Pair]:
    """Return findings with their closest rivals, each two causes once."""
    pairs: dict[frozenset[Cause], Pair] = {}
    for finding in findings:
        own = _cause(finding)
        for rival in finding.confusable_with[:_RIVALS]:
            pairs.setdefault(frozenset({own, rival}), (own, rival))
    return list(pairs.values())


def _by_action(start: Start, pairs: Sequence[Pair]) -> list[NextMeasurement]:
    served: dict[Action, list[Pair]] = {}
    for pair in pairs:
        action = action_for(*pair)
        if action is not None:
            served.setdefault(action, []).append(pair)
    return [
        NextMeasurement(
            f"{action.do}: it tells {', and '.join(_told_apart(told))}.",
            _first(start) if action.again else (),
            tuple(dict.fromkeys(cause for pair in told for cause in pair)),
        )
        for action, told in served.items()
    ]


def _told_apart(pairs: Sequence[Pair]) -> Iterator[str]:
    for own in dict.fromkeys(one for one, _ in pairs):
        yield f"{spoken(own)} from {_either([rival for one, rival in pairs if one == own])}"


def _by_configuration(
    duel: _Duel, rivals: Sequence[Cause], places: Places, rng: np.random.Generator
) -> list[NextMeasurement]:
    """Few configurations; where these do not tell, farther out; where these do not, repeats."""
    if duel.start.scene.legs:
        return [_other_poses(duel.own, rivals)]
    limits = joint_limits(duel.start)
    found, left = _exposed(duel, rivals, places, "")
    found = [*_unbent(duel, rivals), *found]
    if left and limits is not None:
        beyond = drawn(duel.start, duel.selected, limits, _PLACES, rng)
        more, left = _exposed(duel, left, beyond, _BEYOND)
        found += more
    for repeats in _REPEATS if left else ():
        more, left = _exposed(duel, left, places, "", repeats)
        found += more
    return [*found, _wider(duel, left)] if left else found


def _unbent(duel: _Duel, rivals: Sequence[Cause]) -> list[NextMeasurement]:
    """Propose to move joints that stood still: loads and errors of several joints went together."""
    ranges = measured_ranges(duel.start)
    still = np.flatnonzero(ranges.high_deg - ranges.low_deg < _STILL_DEG) + 1
    if not still.size:
        return []
    sentence = (
        f"Move {_numbered(still.tolist())} too, over as wide a range as is safe: in these readings the arm "
        f"kept its shape there, so that {spoken(duel.own)} and {_either(rivals)} go together."
    )
    return [NextMeasurement(sentence, (), (duel.own, *rivals))]


def _numbered(joints: Sequence[int]) -> str:
    *most, last = [str(joint) for joint in joints]
    return f"joints {', '.join(most)} and {last}" if most else f"joint {last}"


def _exposed(
    duel: _Duel, rivals: Sequence[Cause], places: Places, where: str, repeats: int = 1
) -> tuple[list[NextMeasurement], list[Cause]]:
    """Return configurations that expose rivals, and the rivals that they do not expose."""
    if not rivals:
        return [], []
    chosen = separation(duel.selected, duel.group, rivals, places, repeats)
    exposed = [rival for rival, worth in zip(rivals, chosen.chi_square, strict=True) if worth >= CONVINCING]
    if not exposed:
        return [], list(rivals)
    configurations = _listed(places.joints_deg[list(chosen.rows)])
    times = "" if repeats == 1 else f", {repeats} times each"
    sentence = (
        f"Measure these {len(configurations)} configurations{times}, {_SEEN}: there {spoken(duel.own)} acts "
        f"otherwise than {_either(exposed)}.{where}"
    )
    told = NextMeasurement(sentence, configurations, (duel.own, *exposed))
    return [told], [rival for rival in rivals if rival not in exposed]


def _wider(duel: _Duel, rivals: Sequence[Cause]) -> NextMeasurement:
    told = f"no few configurations tell {spoken(duel.own)} from {_either(rivals)}"
    joints = sorted({joint for cause in (duel.own, *rivals) if (joint := _joint(cause))})
    if joints:
        ranges = measured_ranges(duel.start)
        wider = " and ".join(
            f"joint {joint} beyond {ranges.low_deg[joint - 1]:.0f} to {ranges.high_deg[joint - 1]:.0f} deg"
            for joint in joints
        )
        sentence = f"Measure {wider}, or with another load: within what was measured so far {told}."
    else:
        sentence = f"Measure with another load and with the arm bent in other ways: so far {told}."
    return NextMeasurement(sentence, (), (duel.own, *rivals))


def _joint(cause: Cause) -> int | None:
    """Return the number of the joint that a cause sits in, from 1."""
    place = re.match(r"joint (\d+)", cause.subject)
    return int(place[1]) if place else None


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
        f"Measure these {len(configurations)} configurations, {_SEEN}: {about}, and {_why(depends)}.",
        configurations,
    )


def _why(depends: Depends) -> str:
    if depends.kind == "place":
        return "these lie farthest from what was measured"
    if depends.joint is not None and depends.order > ONE_PERIOD_FROM:
        return f"these step joint {depends.joint + 1} through one period of the wave"
    return "these lie in its largest gaps"


def _telling(start: Start, depends: Depends, places: Places, rng: np.random.Generator) -> FloatArray:
    """Return configurations [deg] that show a dependence best, shape (<= 5, J)."""
    scene, joint = start.scene, depends.joint
    if joint is None:
        chain = places.state.chain
        return places.joints_deg[filling(chain.end_origin, scene.chain.end_origin, _FEW)]
    if depends.kind == "torque" and places.torque_n_mm is not None and scene.torque_n_mm is not None:
        there, here = places.torque_n_mm[:, [joint]], scene.torque_n_mm[:, [joint]]
        return places.joints_deg[filling(there, here, _FEW)]
    if depends.order > ONE_PERIOD_FROM:
        return one_period(start, joint, depends.order, _FEW)
    alone = moved_alone(start, joint, _PLACES, rng)
    measured = np.rad2deg(scene.stops.joints_rad[:, [joint]])
    return alone[filling(alone[:, [joint]], measured, _FEW)]


def _first(start: Start) -> Configurations:
    """Return the first configurations that were measured, as they were."""
    stops = start.scene.stops
    _, rows = np.unique(stops.config, return_index=True)
    return _listed(np.rad2deg(stops.joints_rad[np.sort(rows)[:_FEW]]))


def _revisited(start: Start) -> bool:
    repeats = start.scene.stops.repeat_of
    return repeats is not None and int((repeats >= 0).sum()) >= _FEW


def _revisit(start: Start) -> NextMeasurement:
    return NextMeasurement(
        f"{AT_THE_END}, each twice: how far the readings of one configuration scatter tells noise that is "
        "larger than stated from an unknown cause.",
        _first(start),
    )


def _listed(joints_deg: FloatArray) -> Configurations:
    return tuple(tuple(float(angle) for angle in row) for row in np.round(joints_deg, 2) + 0.0)


def _either(causes: Sequence[Cause]) -> str:
    return " or ".join(spoken(cause) for cause in causes)


def _once(found: Sequence[NextMeasurement]) -> list[NextMeasurement]:
    """Leave out what says the same of the same configurations again."""
    return list(dict.fromkeys(found))
