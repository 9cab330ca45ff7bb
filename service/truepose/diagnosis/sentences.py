"""Sentences: what an operator reads first, and what is left in plain words."""

from truepose.diagnosis.evidence.structure_left import Left
from truepose.domain.diagnosis import Cause, Finding, Noise, Remaining, Verdict
from truepose.domain.results import Statistics
from truepose.effects.unnamed.cause import NAME as UNNAMED

_AS_STATED = "What is left looks like the stated noise."
_CONTRADICTED = "The validation readings contradict what was found"
_OF_READINGS = ("label_swap", "outliers")  # causes that lie in the readings, not in the robot


def first_line(
    verdict: Verdict,
    findings: tuple[Finding, ...],
    before: Statistics,
    after: Statistics,
    remaining: Remaining,
) -> str:
    """Return the one sentence that stands above everything."""
    if verdict is Verdict.CONSISTENT:
        noise = "" if remaining.sentence.startswith(_AS_STATED) else f" {remaining.sentence}"
        return f"The present model explains the data: nothing else was found.{noise}"
    if not findings:
        return f"Something is wrong that no known cause explains. {remaining.sentence}"
    if findings[0].effect in _OF_READINGS:
        rest = "" if verdict is Verdict.EXPLAINED else f" {remaining.sentence}"
        return f"Some readings are wrong: {findings[0].sentence}{rest}"
    lead = findings[0]
    others = len(findings) - 1
    more = "" if others == 0 else f", and {others} more cause{'s' if others > 1 else ''}"
    surely = "" if lead.confidence == "certain" else "probably "
    rest = "" if verdict is Verdict.EXPLAINED else f" {_beside(remaining)}"
    beside = " and what is described without a name" if remaining.described else ""
    return (
        f"The model lacks {surely}{spoken(Cause(lead.effect, lead.subject))}{more}: with it{beside}, errors "
        f"on unseen points go from {before.mean_mm:.3f} to {after.mean_mm:.3f} mm on average.{rest}"
    )


def _beside(remaining: Remaining) -> str:
    """Return what is said of the rest beside a named cause: in full where a point is far worse now."""
    told = remaining.worse_at is not None or remaining.sentence.startswith(_CONTRADICTED)
    return remaining.sentence if told else "Something is left that they do not explain."


def spoken(cause: Cause) -> str:
    """Return e.g. `backlash of joint 4`."""
    name = "a cause without a name" if cause.effect == UNNAMED else cause.effect.replace("_", " ")
    return f"{name} ({cause.subject})"


def remaining_sentence(left: Left, *, full: bool) -> str:
    """Return what is left in one sentence."""
    carried = (
        " These readings do not carry a larger model: measure more configurations to find the rest."
        if full
        else ""
    )
    if left.contradicted:
        return (
            f"{_CONTRADICTED}: they are foretold no better with it than without it, and the model stays what "
            "it was. What was found fits the calibration alone: look what differs between the two, or "
            f"measure where the validation was measured.{carried}"
        )
    if left.depends and left.worse_at is None:
        listed = " and ".join(one.variable for one in left.depends[:2])
        return f"What is left depends on the {listed}.{carried}"
    if left.worse_at is not None:
        return (
            f"The mean gets better, but configuration {left.worse_at.config}, which was not fitted, goes "
            f"from {left.worse_at.before_mm:.2f} to {left.worse_at.after_mm:.2f} mm, farther off than any "
            "point before: the readings do not hold the model there. Measure around it before the model is "
            f"used.{carried}"
        )
    if left.clearly_worse_unseen:
        return (
            f"Errors on the validation points are {left.worse_unseen:.1f} times what the noise and the "
            f"parameters explain, {_of_calibration(left)}: the calibration does not cover what the "
            f"validation visits, or something changed between the two.{carried}"
        )
    if left.steps is not None:
        return (
            "What is left is noise, larger than stated: the joint angles are given in steps of "
            f"{left.steps.step_deg:g} deg, and that alone scatters "
            f"{'the lengths' if left.steps.of_lengths else 'the tool'} by {left.steps.scatter_mm:.2g} mm. "
            f"Give them with all their digits.{carried}"
        )
    if left.more_than_stated and not left.explained_by_repeats:
        return (
            f"What is left is {left.noise_scale:.2g} times the stated noise but depends on nothing that was "
            f"looked at: the noise is larger than stated, or an unknown cause scatters like noise.{carried}"
        )
    if left.more_than_stated:
        return (
            f"What is left is {left.noise_scale:.2g} times the stated noise, and so is the scatter of "
            f"revisited configurations: it is noise, larger than stated.{carried}"
        )
    return f"{_AS_STATED}{carried}"


def _of_calibration(left: Left) -> str:
    """Return how the calibration points fit."""
    if left.more_than_stated and not left.explained_by_repeats:
        return f"and those on the calibration points {left.noise_scale:.2g} times their noise"
    return "although the calibration points fit"


def noise_of(left: Left) -> Noise:
    """Return what the readings say of their own noise."""
    degrees = left.tails.degrees_of_freedom
    stated = "what is stated" if left.steps is None else "what is stated and what steps of the angles add"
    size = f"The typical residual is {left.noise_scale:.2f} times {stated}"
    tail = (
        f"; large residuals are more frequent than normal noise has them (Student's t with {degrees:.1f} "
        f"degrees of freedom){_without_cause(left)}."
        if degrees is not None
        else "."
    )
    return Noise(left.noise_scale, degrees, size + tail)


def _without_cause(left: Left) -> str:
    """Return what heavy tails are, where nothing else is wrong that could make them."""
    return "" if left.structure else ": heavy-tailed noise, no cause"
