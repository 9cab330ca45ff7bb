"""Whether a length goes with the pair that was asked for; a doubt is put to a person, never stored silently.

These doubts need no model of the robot. They rest on what was connected when a length was last taken, and on
the zeros: those of the same bars differ by how far the magnets' snaps let them walk, those of others by how
much bars are off their nominal length.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

from truepose.domain.ballbar import (
    BallbarStep,
    Leg,
    LengthTaken,
    PoseForecast,
    StepKind,
    Suspicion,
    SuspicionKind,
)
from truepose.domain.cell import BallbarKit
from truepose.domain.errors import ConfigurationError
from truepose.sessions.ballbar import step_ids
from truepose.sessions.ballbar.early_length_check import EarlyJudge
from truepose.sessions.ballbar.readings import bars_of
from truepose.sessions.ballbar.situation import Situation
from truepose.sessions.ballbar.state import Answer
from truepose.validation.connection_check import judge_leg, judge_pose

NO_PAIR: Final[Leg] = (0, 0)  # of the calibrator
# The zero walks by 0.003 mm at most, twice its standard uncertainty (thesis, section 3.5); as much again for
# two readings, and for bars that grow by a degree.
_ZERO_WALK: Final = 4.0  # times the uncertainty of a zero


def calibrator_doubt(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, held_for: str | None
) -> Suspicion | None:
    """Return why the ballbar seems to be on the calibrator, or off it, against what is asked for.

    `held_for` is the step whose length this connection gave before; None where it was let go since.
    """
    if step.kind is StepKind.INITIALISE:
        return _doubt_about_zero(taken, now, step, kit, held_for)
    if held_for and step_ids.kind_of(held_for) is StepKind.INITIALISE:
        return _suspicion("calibrator", step, taken.length_mm)
    # A bar that was never let go from its calibrator shows the calibrator's length: *Store now* once kept
    # 300.000 mm as a leg (decision 0018).
    if now.zero is None or not _agree(taken.deviation_mm, now.zero.zero_mm, kit):
        return None
    kind: SuspicionKind = "like_calibrator" if _is_made_like_calibrator(step, kit) else "calibrator"
    return _suspicion(kind, step, taken.length_mm)


def _is_made_like_calibrator(step: BallbarStep, kit: BallbarKit) -> bool:
    # Only the tool's sides are as they were made; those of the base, and legs, are as the robot errs.
    is_made = step.artefact == "tool" and step.expected_mm is not None
    return is_made and _agree(step.expected_mm or 0.0, bars_of(step, kit).calibrator_mm, kit)


def contact_doubt(taken: LengthTaken, step: BallbarStep, held_for: str | None) -> Suspicion | None:
    """Return that the connection is one that is not asked for and was not let go; None where it is new."""
    if held_for is None or held_for == step.id or step.kind is StepKind.INITIALISE:
        return None
    is_leg = step_ids.kind_of(held_for) is StepKind.CONNECT_LEG
    suspected = step_ids.points_of(held_for) if is_leg and step.kind is StepKind.CONNECT_LEG else None
    return _suspicion("same_connection", step, taken.length_mm, suspected)


def _doubt_about_zero(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, held_for: str | None
) -> Suspicion | None:
    calibrator_mm, before = bars_of(step, kit).calibrator_mm, now.zero_before
    if before is not None and not _agree(taken.zero_mm, before.zero_mm, kit):
        return _suspicion("not_calibrator", step, calibrator_mm + taken.zero_mm - before.zero_mm)
    if held_for is not None and step_ids.kind_of(held_for) is not StepKind.INITIALISE:
        return _suspicion("not_calibrator", step, calibrator_mm)
    # Two sets of bars whose zeros agree are either one set, or as long as each other by chance: one session
    # in six, once (decision 0018).
    if now.zeroed is not None and before is None and _agree(taken.zero_mm, now.zeroed[1].zero_mm, kit):
        return _suspicion("same_bars", step, calibrator_mm)
    return None


def _agree(one_mm: float, other_mm: float, kit: BallbarKit) -> bool:
    return abs(one_mm - other_mm) <= _ZERO_WALK * kit.zero_u_mm


def _suspicion(
    kind: SuspicionKind, step: BallbarStep, length_mm: float, suspected: Leg | None = None
) -> Suspicion:
    return Suspicion(kind, step.points or NO_PAIR, suspected, length_mm, step.expected_mm)


@dataclass(frozen=True, slots=True)
class Judges:
    """Who judges lengths."""

    leg: Callable[..., Suspicion | None] = judge_leg  # one length
    pose: Callable[..., tuple[Suspicion, ...]] = judge_pose  # all lengths of a pose
    early: EarlyJudge | None = None  # None: before a pre-calibration only a pair read twice is seen


def doubt(
    taken: LengthTaken,
    now: Situation,
    step: BallbarStep,
    kit: BallbarKit,
    judges: Judges,
    held_for: str | None = None,
) -> Suspicion | None:
    """Return why a length should not be stored for this step unasked; None where it may.

    `held_for` is the step whose length the present connection gave before; None where it was let go since.
    """
    first = calibrator_doubt(taken, now, step, kit, held_for)
    if first is not None and held_for is None and _was_answered(first, taken, now, kit):
        first = None
    # Cause before symptom: a bar on its calibrator, or at the wrong pair, is still connected as well, and the
    # more particular question tells a person what to do.
    return first or _doubt(taken, now, step, kit, judges) or contact_doubt(taken, step, held_for)


def _was_answered(suspicion: Suspicion, taken: LengthTaken, now: Situation, kit: BallbarKit) -> bool:
    """Return whether a person has put the ballbar on anew because of this very length."""
    return any(
        before.suspicion.kind == suspicion.kind
        and _agree(before.length.deviation_mm, taken.deviation_mm, kit)
        for before in now.answered
    )


def _doubt(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, judges: Judges
) -> Suspicion | None:
    try:
        return _judge(taken, now, step, kit, judges)
    except ConfigurationError:  # what cannot be judged is not stored silently either
        return Suspicion("unlikely", step.points or NO_PAIR, None, taken.length_mm, step.expected_mm)


def _judge(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, judges: Judges
) -> Suspicion | None:
    match step.kind:
        case StepKind.MEASURE_SIDE if step.artefact == "base":
            # The sides of the tool triangle are equal by make; those of the base are as the robot errs.
            return _judge_unforeseen(taken, now, step, kit, judges)
        case StepKind.CONNECT_LEG if now.forecast is None:
            return _judge_unforeseen(taken, now, step, kit, judges)
        case StepKind.CONNECT_LEG:
            # One length first: only with the last leg can the pose as a whole be judged, and a leg that is
            # wrong by itself makes the others look exchanged.
            first = _judge_leg(taken, now, step, kit, judges, now.forecast)
            return first or _judge_pose(taken, now, step, kit, judges)
        case _:
            return None


def _judge_unforeseen(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, judges: Judges
) -> Suspicion | None:
    if judges.early is None:
        return _judge_leg(taken, now, step, kit, judges, None)
    return judges.early.doubt(taken, now, step)


def legs_to_read_again(now: Situation, suspicion: Suspicion) -> tuple[str, ...]:
    """Return the steps whose stored readings are meant by a suspicion of exchanged legs."""
    if now.step is None:
        return ()
    group = step_ids.group_of(now.step.id)
    pairs = {pair for pair in (suspicion.asked, suspicion.suspected) if pair is not None}
    return tuple(
        step.id
        for step in now.steps
        # Steps without points are in no pair; matched by their absence, a doubt took the initialisation of
        # its pose along (commit 6220f961).
        if step.points in pairs and step_ids.group_of(step.id) == group
        if now.outcomes[step.id].kind == "measured"
    )


def leg_taken_for(now: Situation, suspicion: Suspicion) -> tuple[str, ...]:
    """Return the leg that was read before with the length of one that is maintained to be right.

    If this is the right pair, that one was likely read of it. A leg that a person maintained too is left: two
    pairs may have one length.
    """
    if suspicion.kind != "same_pair":
        return ()
    legs = replace(suspicion, asked=suspicion.suspected or suspicion.asked)
    read = legs_to_read_again(now, legs)
    return tuple(step_id for step_id in read if now.outcomes[step_id].text != Answer.RIGHT_PAIR)


def _judge_leg(
    taken: LengthTaken,
    now: Situation,
    step: BallbarStep,
    kit: BallbarKit,
    judges: Judges,
    forecast: PoseForecast | None,
) -> Suspicion | None:
    if step.points is None:
        return None
    return judges.leg(
        step.points,
        taken.length_mm,
        now.earlier_legs(),
        forecast,
        reading_u_mm=kit.reading_u_mm,
        zero_u_mm=kit.zero_u_mm,
        nominal_mm=kit.base_bars.nominal_mm,
        range_mm=kit.range_mm,
    )


def _judge_pose(
    taken: LengthTaken, now: Situation, step: BallbarStep, kit: BallbarKit, judges: Judges
) -> Suspicion | None:
    """Look at the pose as a whole with its last leg."""
    lengths = now.earlier_legs()
    if now.forecast is None or step.points is None or len(lengths) + 1 < now.legs_of_the_pose():
        return None
    lengths[step.points] = taken.length_mm
    found = judges.pose(
        lengths,
        now.forecast,
        reading_u_mm=kit.reading_u_mm,
        zero_u_mm=kit.zero_u_mm,
        range_mm=kit.range_mm,
    )
    return found[0] if found else None
