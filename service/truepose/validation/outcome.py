"""The one sentence that every result begins with: the error before and after, the limit, pass or fail.

Pages, PDF, terminals and documents say it first, and all have it from here: where each worded its own, one
page showed three pairs of before and after.
"""

from dataclasses import dataclass
from typing import Final, Literal, Self, TypeAlias

from truepose.domain.diagnosis import Diagnosis
from truepose.domain.identification import Identification, Statistics
from truepose.domain.validation import Decision, Validation, Verdict
from truepose.messages.message import Message, message

Quantity: TypeAlias = Literal["position", "length"]
_DECIDED: Final = {
    "conforms": "outcome.pass",
    "does not conform": "outcome.fail",
    "cannot be decided": "outcome.undecided",
}
NO_LIMIT: Final = message("outcome.no_limit")
NOT_VALIDATED: Final = message("outcome.not_validated")


def judgement(decision: Decision | None, missing: Message = NO_LIMIT) -> Message:
    """Return the limit and whether it is kept, as the end of a sentence.

    Parameters
    ----------
    decision : Decision or None
    missing : Message
        What is said where nothing was decided: what it takes.
    """
    if decision is None:
        return missing
    return held_against(decision.limit_mm, decision.verdict)


def held_against(limit_mm: float, verdict: Verdict) -> Message:
    """Return a limit and whether it is kept, as the end of a sentence."""
    return message(_DECIDED[verdict], limit_mm=limit_mm)


def largest_judged(largest_mm: float, judged: Message) -> Message:
    """Return the largest error with what was judged of it, as the end of a sentence."""
    return message("outcome.largest", largest_mm=largest_mm, judged=judged)


def before_and_after(
    before_mm: float | None, after_mm: float, judged: Message, quantity: Quantity = "position"
) -> Message:
    """Return the sentence of mean errors; `before_mm` is None where nobody recorded it."""
    before = message("outcome.unrecorded")
    if before_mm is not None:
        before = message("outcome.error", error_mm=before_mm)
    key = "outcome.position" if quantity == "position" else "outcome.length"
    return message(key, before=before, after_mm=after_mm, judged=judged)


@dataclass(frozen=True, slots=True)
class Outcome:
    """Errors of the nominal robot and of its model on the same readings, held against a limit.

    Attributes
    ----------
    nominal : Statistics or None
        None in what was stored before it was told.
    model : Statistics or None
        None where no model could be made.
    quantity : str
        "position" or "length".
    decision : Decision or None
        None: no limit was judged.
    missing : Message
        What it takes to have one judged.
    """

    nominal: Statistics | None
    model: Statistics | None
    quantity: Quantity = "position"
    decision: Decision | None = None
    missing: Message = NO_LIMIT

    @classmethod
    def of(cls, found: Identification | Diagnosis | Validation) -> Self:
        """Return what a result came to, by the readings that judge it."""
        match found:
            case Validation(position=pair, decision=decision):
                return cls(pair.nominal, pair.identified, found.quantity, decision)
            case Diagnosis():
                return cls(found.nominal, found.after, found.quantity, missing=NOT_VALIDATED)
        judging = found.judging
        if judging is None:
            return cls(None, None)
        return cls(judging.nominal, judging.identified, found.quantity, missing=NOT_VALIDATED)

    @property
    def sentence(self) -> Message:
        """The sentence."""
        if self.model is None:
            return message("outcome.no_model")
        judged = judgement(self.decision, self.missing)
        if self.decision is not None:
            judged = largest_judged(self.model.max_mm, judged)
        before_mm = None if self.nominal is None else self.nominal.mean_mm
        return before_and_after(before_mm, self.model.mean_mm, judged, self.quantity)


def outcome_of(found: Identification | Diagnosis | Validation) -> Message:
    """Return the sentence that a result begins with."""
    return Outcome.of(found).sentence
