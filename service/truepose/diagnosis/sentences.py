"""Sentences: what an operator reads first, and what is left; their words are in the catalogue.

Numerics say a key and its values, never a text (decision 0038), so that one diagnosis is read in every
language, also when it is read again from the archive.
"""

from dataclasses import replace

from truepose.diagnosis.evidence.residual_structure import Remainder
from truepose.domain.diagnosis import Cause, Diagnosis, Finding, Noise, Remaining, Scatter, Verdict
from truepose.domain.identification import Statistics
from truepose.effects import motions
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.messages.message import Message, Text, leading_key, message, together

_AS_STATED = "remaining.as_stated"
_CONTRADICTED = "remaining.contradicted"


def first_line(
    verdict: Verdict,
    findings: tuple[Finding, ...],
    before: Statistics,
    after: Statistics,
    remaining: Remaining,
    named_share: float | None,
) -> Text:
    """Return the one sentence that stands above everything.

    Parameters
    ----------
    verdict : Verdict
    findings : tuple of Finding
        Most important first; those that are small left out.
    before, after : Statistics
        Of the held-out errors.
    remaining : Remaining
    named_share : float or None
        Of the error beyond the noise that has a name.

    Returns
    -------
    Text
    """
    if verdict is Verdict.CONSISTENT:
        noise = "" if leading_key(remaining.sentence) == _AS_STATED else remaining.sentence
        return together(message("message.consistent"), noise)
    if not findings:
        return together(message("message.unexplained"), remaining.sentence)
    explained = verdict is Verdict.EXPLAINED
    # Faulty readings are no inadequacy of the model: they have sentences of their own.
    if findings[0].effect in effects_with(Trait.OF_READINGS):
        wrong = message("message.readings_wrong", sentence=findings[0].sentence)
        return together(wrong, "" if explained else remaining.sentence)
    return together(
        _lacking(findings, before, after, remaining), "" if explained else _beside(remaining, named_share)
    )


def _lacking(
    findings: tuple[Finding, ...], before: Statistics, after: Statistics, remaining: Remaining
) -> Message:
    """Return what the model lacks, and what the error becomes with it."""
    lead, others = findings[0], len(findings) - 1
    more = message("message.one_more" if others == 1 else "message.more", causes=others)
    return message(
        "message.lacks" if lead.confidence == "certain" else "message.probably_lacks",
        cause=spoken(Cause(lead.effect, lead.subject)),
        more=more if others else "",
        beside=message("message.and_described") if remaining.described else "",
        before_mm=before.mean_mm,
        after_mm=after.mean_mm,
    )


def _beside(remaining: Remaining, named_share: float | None) -> Text:
    """Return what is said of the rest beside a named cause: in full where a point is far worse now."""
    if remaining.worse_at is not None or leading_key(remaining.sentence) == _CONTRADICTED:
        return remaining.sentence
    if named_share is None:
        return message("message.something_left")
    return message("message.share_named", share=named_share)


def spoken(cause: Cause) -> Message:
    """Return a cause in words.

    Parameters
    ----------
    cause : Cause

    Returns
    -------
    Message
        E.g. `backlash (joint 4)`.
    """
    return message("cause.spoken", effect=cause.effect, subject=cause.subject)


def remaining_sentence(left: Remainder, *, full: bool) -> Text:
    """Return what is left, and what the model could not take.

    Parameters
    ----------
    left : Remainder
    full : bool
        The readings do not carry more parameters, though more is there.

    Returns
    -------
    Text
    """
    return together(_left(left), _withheld(left), message("remaining.full") if full else "")


def _withheld(left: Remainder) -> Text:
    """Return that a description was withheld, with what it would have done; "" where none was."""
    if left.withheld is None:
        return ""
    gain = left.withheld
    return message("remaining.withheld", before_mm=gain.rms_before_mm, after_mm=gain.rms_after_mm)


def _left(left: Remainder) -> Message:
    """Return the one thing that is said of what is left."""
    # The gravest first: one sentence has to do.
    if left.contradicted:
        return message(_CONTRADICTED)
    if left.worse_at is not None:
        return message(
            "remaining.worse_at",
            config=left.worse_at.config,
            before_mm=left.worse_at.before_mm,
            after_mm=left.worse_at.after_mm,
        )
    if left.depends:
        return message("remaining.depends", variables=tuple(one.variable for one in left.depends[:2]))
    if left.clearly_worse_unseen:
        return message("remaining.worse_unseen", times=left.worse_unseen, calibration=_of_calibration(left))
    if left.steps is not None:
        steps = left.steps
        key = "remaining.steps_of_lengths" if steps.of_lengths else "remaining.steps"
        return message(key, step_deg=steps.step_deg, scatter_mm=steps.scatter_mm)
    return _noise_left(left)


def _noise_left(left: Remainder) -> Message:
    """Return of which kind the noise is, where nothing else is left."""
    if not left.more_than_stated:
        return message(_AS_STATED)
    key = "remaining.repeats" if left.explained_by_repeats else "remaining.like_noise"
    return message(key, times=left.noise_scale)


def _of_calibration(left: Remainder) -> Message:
    """Return how the calibration points fit."""
    if left.more_than_stated and not left.explained_by_repeats:
        return message("remaining.calibration_too", times=left.noise_scale)
    return message("remaining.calibration_fits")


def noise_of(left: Remainder) -> Noise:
    """Return what the readings say of their own noise.

    Parameters
    ----------
    left : Remainder

    Returns
    -------
    Noise
        Degrees of freedom where its tails are heavy.
    """
    degrees = left.tails.degrees_of_freedom
    stated = message("noise.stated" if left.steps is None else "noise.stated_and_steps")
    sentence = message("noise.normal", times=left.noise_scale, stated=stated)
    if degrees is not None:
        key = "noise.heavy_tails" if left.structure else "noise.heavy_tails_alone"
        sentence = message(key, times=left.noise_scale, stated=stated, degrees=degrees)
    return Noise(left.noise_scale, degrees, sentence)


def with_scatter_told(answer: Diagnosis, scatter: Scatter) -> Diagnosis:
    """Return a diagnosis that says, in its first line too, on what the size of the noise depends.

    Parameters
    ----------
    answer : Diagnosis
        Of readings that are as uncertain as they scatter.
    scatter : Scatter

    """
    sentence = message(
        "noise.scatter",
        low_mm=scatter.low_mm,
        at_low=_place(scatter, scatter.at_low),
        high_mm=scatter.high_mm,
        at_high=_place(scatter, scatter.at_high),
    )
    noise = answer.noise and replace(
        answer.noise, sentence=together(answer.noise.sentence, sentence), scatter=scatter
    )
    return replace(answer, message=together(answer.message, sentence), noise=noise)


def _place(scatter: Scatter, value: float) -> Message:
    """Return where the scatter is what it is: at a value of its variable."""
    match scatter.variable:
        case "reach":
            return message("noise.at_reach", value_mm=value)
        case "range":
            return message("noise.at_range", value_mm=value)
        case "angle":
            return message("noise.at_angle", joint=scatter.subject, value_deg=value)
        case "time":
            return message("noise.at_time", time=motions.spoken(value))
        case "temperature":
            return message("noise.at_temperature", value_c=value)
        case "nest":
            return message("gathered.nest", nest=int(value))
        case "mounting":
            return message("gathered.mounting", mounting=int(value))
        case "placement":
            return message("noise.at_placement", number=int(value))
