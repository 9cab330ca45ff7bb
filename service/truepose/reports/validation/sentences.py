"""What a validation came to, in sentences."""

from typing import Final

from truepose.domain.results.validation import Validation
from truepose.domain.sentences import Sentence, said
from truepose.reports.wording.rounding import millimetres

_DECIDED: Final = {
    ("simple", "conforms"): "validation.simple.conforms",
    ("simple", "does not conform"): "validation.simple.does_not_conform",
    ("guard band", "conforms"): "validation.guard_band.conforms",
    ("guard band", "does not conform"): "validation.guard_band.does_not_conform",
    ("guard band", "cannot be decided"): "validation.guard_band.undecided",
}


def decision_sentence(validation: Validation) -> Sentence | None:
    """Return whether the limit is kept with the uncertainty counted; nothing without a limit."""
    decided = validation.decision
    if decided is None:
        return None
    return said(
        _DECIDED[decided.rule, decided.verdict],
        guard=millimetres(decided.guard_mm),
        error=millimetres(decided.error_mm),
    )


def verdict_sentence(validation: Validation) -> Sentence:
    """Return whether the model passes, and by which measure."""
    if validation.limit_mm is None:
        return _without_limit(validation)
    key = "validation.within_limit" if validation.passed else "validation.beyond_limit"
    return said(key, limit_mm=validation.limit_mm)


def _without_limit(validation: Validation) -> Sentence:
    if validation.passed:
        return said("validation.as_claimed")
    if validation.position.identified.mean_mm > validation.position.nominal.mean_mm:
        return said("validation.not_below")
    return said("validation.far_above", claimed_mm=validation.claimed_mm)
