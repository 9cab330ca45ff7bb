"""What to measure next: actions and configurations that would tell causes apart, or show an unknown one.

Where no configuration tells two causes apart, an action does. One table, tried from the top: an action serves
a pair of causes by the words of their signatures, their places, variables and shapes. Everything else is left
to the expected chi-square of `diagnosis.t_optimality`.

Proposals are advice: nothing moves by them. A session adds their configurations behind a confirmation
(decision 0012).
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.diagnosis.baseline_fit import Start
from truepose.diagnosis.configurations import (
    Places,
    Ranges,
    draw_configurations,
    filling,
    joint_limits,
    measured_ranges,
    moved_alone,
    one_period,
)
from truepose.diagnosis.evidence.residual_structure import Relation, Remainder
from truepose.diagnosis.screening.selection import Selection, names_of
from truepose.diagnosis.sentences import spoken
from truepose.diagnosis.t_optimality import CONVINCING, separation
from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Cause, Finding, NextMeasurement
from truepose.effects.causes import Candidate
from truepose.effects.names import joint_subject
from truepose.effects.signatures import named_signature, words_of
from truepose.effects.waves import ONE_PERIOD_FROM
from truepose.messages.message import Message, Value, message, together


@dataclass(frozen=True, slots=True)
class Action:
    """Something to do.

    Attributes
    ----------
    one : frozenset of str
        Words of which one of the two causes has some.
    do : Message
        An imperative.
    each : str
        A word that both have; "": none is needed.
    again : bool
        The first configurations are measured once more.
    """

    one: frozenset[str]
    do: Message
    each: str = ""
    again: bool = False

    def serves(self, one: frozenset[str], other: frozenset[str]) -> bool:
        """Return whether it tells two causes of these words apart.

        Parameters
        ----------
        one, other : frozenset of str
            Words of their signatures.

        Returns
        -------
        bool
        """
        return bool(self.one & (one | other)) and (not self.each or self.each in one & other)


BOTH_SIDES: Final = message("do.both_sides")
REMOUNT: Final = message("do.remount")
ALL_NESTS: Final = message("do.all_nests")
AT_THE_END: Final = message("do.at_the_end")
IN_ANOTHER_ORDER: Final = message("do.in_another_order")
WARM_AND_COLD: Final = message("do.warm_and_cold")

_ACTIONS: Final = (
    Action(frozenset({"tool"}), message("do.with_and_without_load"), each="load"),
    Action(
        frozenset({"placement"}),
        message("do.first_poses_again"),
    ),
    Action(
        frozenset({"ballbar constant"}),
        message("do.initialise"),
    ),
    Action(
        frozenset({"tracker time"}),
        message("do.fixed_nests"),
    ),
    Action(frozenset({"mounting"}), REMOUNT, again=True),
    Action(frozenset({"nest constant"}), ALL_NESTS),
    Action(frozenset({"direction", "sign"}), BOTH_SIDES),
    Action(frozenset({"last move"}), IN_ANOTHER_ORDER),
    Action(frozenset({"temperature"}), WARM_AND_COLD, again=True),
    Action(frozenset({"time"}), AT_THE_END, again=True),
)


def action_for(cause: Cause, rival: Cause) -> Action | None:
    """Return what tells two causes apart.

    Parameters
    ----------
    cause, rival : Cause

    Returns
    -------
    Action or None
        None where configurations do.
    """
    pair = [words_of(named_signature(one.effect, one.subject)) for one in (cause, rival)]
    return next((action for action in _ACTIONS if action.serves(*pair)), None)


_PLACES = 300
_SEED = 20140  # the same data are always answered by the same configurations
_RIVALS = 3  # the closest of each finding
_FEW = 5
_TOLD = 2  # dependences of what is left: those that its sentence names
_STILL_DEG = 5.0  # a joint that turned by less did not take part
_REPEATS = (2, 4, 8)
_BEYOND = message("next.beyond_ranges")

# What shows it better where something is left over that, and whether the first configurations come again.
_DO = {
    "direction": (BOTH_SIDES, False),
    "nest": (ALL_NESTS, False),
    "time": (AT_THE_END, True),
    "temperature": (WARM_AND_COLD, True),
    "attachment": (REMOUNT, True),
}

Configurations = tuple[tuple[float, ...], ...]
Pair = tuple[Cause, Cause]  # a finding and its rival


@dataclass(frozen=True, slots=True)
class _Duel:
    """A finding that is to be told from its rivals."""

    start: Start
    selected: Selection
    group: Sequence[Candidate]
    own: Cause


def next_measurements(
    start: Start,
    selected: Selection,
    groups: tuple[tuple[str, tuple[Candidate, ...]], ...],
    findings: tuple[Finding, ...],
    left: Remainder,
) -> tuple[NextMeasurement, ...]:
    """Return what would separate rivals, or show what nothing explains.

    Parameters
    ----------
    start : Start
    selected : Selection
    groups : tuple of (str, tuple of Candidate)
        What each finding is made of.
    findings : tuple of Finding
    left : Remainder

    Returns
    -------
    tuple of NextMeasurement
        Of findings in their order, then of what is left; configurations [deg] within the measured ranges, or
        the limits of the joints where those say so.
    """
    pairs = _pairs(findings)
    # Structure without a dependence is mostly noise beyond what is stated: revisits tell whether the arm
    # scatters as much.
    unseen = left.structure and not left.depends and not _revisited(start)
    if not pairs and not left.depends:
        return (_revisit(start),) if unseen else ()
    rng = np.random.default_rng(_SEED)
    places = draw_configurations(start, selected, measured_ranges(start), _PLACES, rng)
    found = _by_action(start, pairs)
    for finding in findings:
        own = _cause(finding)
        group = next((picks for _, picks in groups if set(names_of(picks)) == set(finding.parameters)), ())
        rivals = [rival for one, rival in pairs if one == own and action_for(one, rival) is None]
        if group and rivals:
            found += _by_configuration(_Duel(start, selected, group, own), rivals, places, rng)
    found += [_of_dependence(start, depends, places, rng) for depends in left.depends[:_TOLD]]
    if unseen:
        found.append(_revisit(start))
    return tuple(_once(found))


def _cause(finding: Finding) -> Cause:
    """Return the cause of a finding."""
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
    """Return what actions tell apart, each action once with all its pairs."""
    served: dict[Action, list[Pair]] = {}
    for pair in pairs:
        action = action_for(*pair)
        if action is not None:
            served.setdefault(action, []).append(pair)
    return [
        NextMeasurement(
            message("next.tells", do=action.do, pairs=tuple(_told_apart(told))),
            _first(start) if action.again else (),
            tuple(dict.fromkeys(cause for pair in told for cause in pair)),
        )
        for action, told in served.items()
    ]


def _told_apart(pairs: Sequence[Pair]) -> Iterator[Message]:
    """Yield each finding with the rivals that an action tells from it."""
    for own in dict.fromkeys(one for one, _ in pairs):
        rivals = tuple(spoken(rival) for one, rival in pairs if one == own)
        yield message("next.own_from_rivals", own=spoken(own), rivals=rivals)


def _by_configuration(
    duel: _Duel, rivals: Sequence[Cause], places: Places, rng: np.random.Generator
) -> list[NextMeasurement]:
    """Few configurations; where these do not tell, farther out; where these do not, repeats."""
    # Poses of a ballbar are planned with its fixture and collision-free paths; joint angles alone cannot be
    # measured.
    if duel.start.scene.legs:
        return [_other_poses(duel.own, rivals)]
    limits = joint_limits(duel.start)
    found, left = _exposed(duel, rivals, places)
    found = [*_unbent(duel, rivals), *found]
    if left and limits is not None:
        beyond = draw_configurations(duel.start, duel.selected, limits, _PLACES, rng)
        more, left = _exposed(duel, left, beyond)
        found += [replace(one, sentence=together(one.sentence, _BEYOND)) for one in more]
    # Repeats last: they cost a reading each, and against what the model lacks they do not help at all.
    for repeats in _REPEATS if left else ():
        more, left = _exposed(duel, left, places, repeats)
        found += more
    return [*found, _wider(duel, left)] if left else found


def _unbent(duel: _Duel, rivals: Sequence[Cause]) -> list[NextMeasurement]:
    """Propose to move joints that stood still: loads and errors of several joints went together."""
    ranges = measured_ranges(duel.start)
    still = np.flatnonzero(ranges.high_deg - ranges.low_deg < _STILL_DEG) + 1
    if not still.size:
        return []
    key = "next.move_joint" if still.size == 1 else "next.move_joints"
    sentence = message(key, joints=tuple(still.tolist()), **_parties(duel.own, rivals))
    return [NextMeasurement(sentence, (), (duel.own, *rivals))]


def _exposed(
    duel: _Duel, rivals: Sequence[Cause], places: Places, repeats: int = 1
) -> tuple[list[NextMeasurement], list[Cause]]:
    """Return configurations that expose rivals, and the rivals that they do not expose."""
    if not rivals:
        return [], []
    chosen = separation(duel.selected, duel.group, rivals, places, repeats)
    exposed = [rival for rival, worth in zip(rivals, chosen.chi_square, strict=True) if worth >= CONVINCING]
    if not exposed:
        return [], list(rivals)
    configurations = _listed(places.joints_deg[list(chosen.rows)])
    sentence = message(
        "next.exposes" if repeats == 1 else "next.exposes_repeated",
        configurations=len(configurations),
        repeats=repeats,
        **_parties(duel.own, exposed),
    )
    told = NextMeasurement(sentence, configurations, (duel.own, *exposed))
    return [told], [rival for rival in rivals if rival not in exposed]


def _wider(duel: _Duel, rivals: Sequence[Cause]) -> NextMeasurement:
    """Return that joints should be turned farther, or another load be mounted."""
    joints = sorted({joint for cause in (duel.own, *rivals) if (joint := _joint(cause))})
    if joints:
        ranges = measured_ranges(duel.start)
        wider = tuple(_beyond(ranges, joint) for joint in joints)
        sentence = message("next.wider", wider=wider, **_parties(duel.own, rivals))
    else:
        sentence = message("next.other_load", **_parties(duel.own, rivals))
    return NextMeasurement(sentence, (), (duel.own, *rivals))


def _beyond(ranges: Ranges, joint: int) -> Message:
    """Return a joint with the range that it was measured over."""
    low_deg, high_deg = float(ranges.low_deg[joint - 1]), float(ranges.high_deg[joint - 1])
    return message("next.joint_beyond", joint=joint, low_deg=low_deg, high_deg=high_deg)


def _joint(cause: Cause) -> int | None:
    """Return the number of the joint that a cause sits in, from 1."""
    place = re.match(r"joint (\d+)", cause.subject)
    return int(place[1]) if place else None


def _other_poses(own: Cause, rivals: Sequence[Cause]) -> NextMeasurement:
    """Return that other poses of the ballbar should be measured."""
    return NextMeasurement(message("next.other_poses", **_parties(own, rivals)), (), (own, *rivals))


def _of_dependence(
    start: Start, depends: Relation, places: Places, rng: np.random.Generator
) -> NextMeasurement:
    """Return what would show a dependence better."""
    if depends.kind in _DO:
        do, again = _DO[depends.kind]
        sentence = message("next.since_left", do=do, variable=depends.variable)
        return NextMeasurement(sentence, _first(start) if again else ())
    if start.scene.legs:
        more = message("do.more_poses")
        return NextMeasurement(message("next.since_left", do=more, variable=depends.variable), ())
    configurations = _listed(_telling(start, depends, places, rng))
    sentence = message(
        "next.shows_left",
        configurations=len(configurations),
        variable=depends.variable,
        why=_why(depends),
    )
    return NextMeasurement(sentence, configurations)


def _why(depends: Relation) -> Message:
    """Return why the configurations of a dependence are those."""
    if depends.kind == "place":
        return message("next.farthest")
    if depends.joint is not None and depends.order > ONE_PERIOD_FROM:
        return message("next.one_period", joint=joint_subject(depends.joint))
    return message("next.in_gaps")


def _telling(start: Start, depends: Relation, places: Places, rng: np.random.Generator) -> FloatArray:
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
    # With the others where they were, what the readings change by is of this joint.
    alone = moved_alone(start, joint, _PLACES, rng)
    measured = np.rad2deg(scene.stops.joints_rad[:, [joint]])
    return alone[filling(alone[:, [joint]], measured, _FEW)]


def _first(start: Start) -> Configurations:
    """Return the first configurations that were measured, as they were."""
    stops = start.scene.stops
    _, rows = np.unique(stops.config, return_index=True)
    return _listed(np.rad2deg(stops.joints_rad[np.sort(rows)[:_FEW]]))


def _revisited(start: Start) -> bool:
    """Whether enough configurations were revisited to tell the scatter."""
    repeats = start.scene.stops.repeat_of
    return repeats is not None and int((repeats >= 0).sum()) >= _FEW


def _revisit(start: Start) -> NextMeasurement:
    """Return that the first configurations should be measured again."""
    return NextMeasurement(message("next.revisit", do=AT_THE_END), _first(start))


def _listed(joints_deg: FloatArray) -> Configurations:
    """Return configurations as they are printed, hundredths of a degree; -0.0 is 0.0."""
    return tuple(tuple(float(angle) for angle in row) for row in np.round(joints_deg, 2) + 0.0)


def _parties(own: Cause, rivals: Sequence[Cause]) -> dict[str, Value]:
    """Return a finding and its rivals, as the sentences about them name them."""
    return {"own": spoken(own), "rivals": tuple(map(spoken, rivals))}


def _once(found: Sequence[NextMeasurement]) -> list[NextMeasurement]:
    """Leave out what says the same of the same configurations again."""
    return list(dict.fromkeys(found))
