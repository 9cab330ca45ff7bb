"""Whether a length goes with what was asked for; a doubt is put to a person, never stored silently."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Protocol

from truepose.domain.cell.artefacts import BallbarKit
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.ballbar import (
    BallbarStep,
    Leg,
    LengthTaken,
    PoseForecast,
    StepKind,
    Suspicion,
)
from truepose.judgement.ball_pairs.judge import judge_leg, judge_pose
from truepose.sequencing.ballbar.acts import Answer
from truepose.sequencing.ballbar.doubts.misplaced import NO_PAIR, calibrator_doubt, contact_doubt
from truepose.sequencing.ballbar.plan import step_ids
from truepose.sequencing.ballbar.situation import Situation


class JudgeLeg(Protocol):
    """Looks at one length; see truepose.judgement.ball_pairs.judge."""

    def __call__(
        self,
        asked: Leg,
        length_mm: float,
        earlier: Mapping[Leg, float],
        forecast: PoseForecast | None,
        *,
        reading_u_mm: float,
        zero_u_mm: float,
        nominal_mm: float,
        range_mm: float,
    ) -> Suspicion | None:
        """Return why the length does not go with the pair; None where nothing speaks against it."""
        ...


class JudgePose(Protocol):
    """Looks at all lengths of a pose; see truepose.judgement.ball_pairs.judge."""

    def __call__(
        self, lengths: Mapping[Leg, float], forecast: PoseForecast, *, reading_u_mm: float, zero_u_mm: float
    ) -> tuple[Suspicion, ...]:
        """Return which legs seem to be exchanged."""
        ...


class JudgeEarly(Protocol):
    """Looks at one length where none is foreseen yet; see truepose.sequencing.ballbar.doubts.early."""

    def doubt(self, taken: LengthTaken, now: Situation, step: BallbarStep) -> Suspicion | None:
        """Return why the length does not go with what the step asks for; None where it does."""
        ...

    def alike(self, now: Situation) -> tuple[tuple[Leg, Leg], ...]:
        """Return the pairs of legs of the present pose whose exchange would not show."""
        ...


@dataclass(frozen=True, slots=True)
class Judges:
    """Who judges lengths."""

    leg: JudgeLeg = judge_leg
    pose: JudgePose = judge_pose
    early: JudgeEarly | None = None  # None: before a pre-calibration only a pair read twice is seen


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
    return first or _doubt(taken, now, step, kit, judges) or contact_doubt(taken, step, held_for)


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
    found = judges.pose(lengths, now.forecast, reading_u_mm=kit.reading_u_mm, zero_u_mm=kit.zero_u_mm)
    return found[0] if found else None
