"""Words for causes and quantities: what a name in a document is called on a page."""

from dataclasses import dataclass

from truepose.domain.diagnosis import Cause, Confidence, Finding, Gain, Verdict, Worth
from truepose.effects.unnamed.cause import NAME as UNNAMED
from truepose.reports.rounding import millimetres


@dataclass(frozen=True, slots=True)
class VerdictWords:
    """A verdict in a word and a sentence; `look` names its shape and colour."""

    word: str
    meaning: str
    look: str


_VERDICTS = {
    Verdict.CONSISTENT: ("Consistent", "The present model explains the data within their uncertainties."),
    Verdict.EXPLAINED: (
        "Explained",
        "The model lacked something; it has a name, and what is left looks like noise.",
    ),
    Verdict.PARTLY_EXPLAINED: (
        "Partly explained",
        "Something has a name, and structure is left that has none yet.",
    ),
    Verdict.UNEXPLAINED: ("Unexplained", "The model lacks something, and no known cause explains it."),
}
_NOT_ANSWERED = VerdictWords(
    "Not answered", "Nothing could be fitted, so these data say nothing of the model.", "not_answered"
)
SMALL_FINDINGS = "Small findings, in the model too; each takes less than 2 % off the errors on unseen points"
_PRINTED_UNITS = {"1": "", "degC": "°C"}
_NO_RIVAL = (
    "no rival explains these data nearly as well, and the false-alarm level holds over everything tried"
)


def verdict_words(verdict: Verdict, *, answered: bool) -> VerdictWords:
    """Return a verdict in words; where nothing could be fitted there is none, whatever the document says."""
    return VerdictWords(*_VERDICTS[verdict], verdict.value) if answered else _NOT_ANSWERED


def effect_words(effect: str) -> str:
    """Return the name of an effect as words."""
    return "a cause without a name" if effect == UNNAMED else effect.replace("_", " ")


def cause_words(cause: Cause) -> str:
    """Return a cause as words, e.g. "joint gain, joint 2"."""
    return ", ".join(filter(None, (effect_words(cause.effect), cause.subject)))


def causes_listed(causes: tuple[Cause, ...]) -> str:
    """Return causes as one phrase."""
    return "; ".join(map(cause_words, causes))


def place_words(finding: Finding) -> str:
    """Return where a cause acts, over what and in which shape; "" where a finding does not say so."""
    if not finding.where:
        return ""
    over = "" if finding.over == "constant" else f", over {finding.over}"
    return f"{finding.where.capitalize()}{over} ({finding.shape})"


def worth_words(worth: Worth) -> str:
    """Return how far a cause moves the tool."""
    return f"{millimetres(worth.mean_mm)} mm on average, {millimetres(worth.max_mm)} mm at most"


def printed_unit(unit: str) -> str:
    """Return a unit of documents as it is printed; nothing for a ratio."""
    return _PRINTED_UNITS.get(unit, unit.replace("*", "·").replace("mm2", "mm²"))


def confidence_meaning(finding: Finding) -> str:
    """Return what the word of confidence stands on, in the facts of this finding."""
    rivals = finding.confusable_with
    told = f"these data cannot tell it from {causes_listed(rivals)}" if rivals else ""
    if finding.confidence is Confidence.CERTAIN:
        return "; ".join(filter(None, (told or _NO_RIVAL, _gain_words(finding.gain))))
    doubts = [told, "" if _shows(finding.gain) else _gain_words(finding.gain)]
    return "; ".join(filter(None, doubts)) or "the evidence does not suffice to exclude every other cause"


def _shows(gain: Gain | None) -> bool:
    return gain is not None and gain.interval_95_mm[0] > 0.0


def _gain_words(gain: Gain | None) -> str:
    if gain is None:
        return "nothing held out can show a gain"
    return f"the 95 % interval of the gain {'lies above' if _shows(gain) else 'reaches'} 0"
