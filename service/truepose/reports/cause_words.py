"""Words for causes and quantities: what a name in a document is called on a page."""

from dataclasses import dataclass

from truepose.domain.diagnosis import Cause, Confidence, EffectSize, Finding, Gain, Verdict
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.rounding import millimetres, with_uncertainty


@dataclass(frozen=True, slots=True)
class VerdictWords:
    """A verdict in a word and a sentence; `look` names its shape and colour."""

    word: str
    meaning: str
    look: str


_VERDICTS = {
    Verdict.CONSISTENT: ("verdict.consistent", "verdict.consistent.meaning"),
    Verdict.EXPLAINED: ("verdict.explained", "verdict.explained.meaning"),
    Verdict.PARTLY_EXPLAINED: ("verdict.partly_explained", "verdict.partly_explained.meaning"),
    Verdict.UNEXPLAINED: ("verdict.unexplained", "verdict.unexplained.meaning"),
}
_NOT_ANSWERED = ("verdict.not_answered", "verdict.not_answered.meaning")
_CONFIDENCES = {Confidence.CERTAIN: "confidence.certain", Confidence.LIKELY: "confidence.likely"}
_PRINTED_UNITS = {"1": "", "degC": "°C"}


def verdict_words(verdict: Verdict, *, answered: bool, words: Catalogue = IN_ENGLISH) -> VerdictWords:
    """Return a verdict in words; where nothing could be fitted there is none, whatever the document says."""
    word, meaning = _VERDICTS[verdict] if answered else _NOT_ANSWERED
    return VerdictWords(words.say(word), words.say(meaning), verdict.value if answered else "not_answered")


def confidence_word(confidence: Confidence, words: Catalogue) -> str:
    """Return how far a name can be defended, in a word."""
    return words.say(_CONFIDENCES[confidence])


def cause_words(cause: Cause, words: Catalogue = IN_ENGLISH) -> str:
    """Return a cause as words, e.g. "joint gain, joint 2"."""
    return words.between.join(filter(None, (words.effect(cause.effect), words.name(cause.subject))))


def causes_listed(causes: tuple[Cause, ...], words: Catalogue = IN_ENGLISH) -> str:
    """Return causes as one phrase."""
    return words.listed([cause_words(cause, words) for cause in causes], "semicolons")


def place_words(finding: Finding, words: Catalogue = IN_ENGLISH) -> str:
    """Return where a cause acts, over what and in which shape; "" where a finding does not say so."""
    if not finding.where:
        return ""
    key = "place.constant" if finding.over == "constant" else "place.over"
    return words.say(key, where=finding.where, over=finding.over, shape=str(finding.shape))


def worth_words(worth: EffectSize, words: Catalogue = IN_ENGLISH) -> str:
    """Return how far a cause moves the tool."""
    return words.say("worth", mean=millimetres(worth.mean_mm), most=millimetres(worth.max_mm))


def printed_unit(unit: str) -> str:
    """Return a unit of documents as it is printed; nothing for a ratio."""
    return _PRINTED_UNITS.get(unit, unit.replace("*", "·").replace("mm2", "mm²"))


def with_unit(value: float, standard_uncertainty: float, unit: str, words: Catalogue) -> str:
    """Return value ± standard uncertainty with the unit, as a reader has it."""
    number, conversion = with_uncertainty(value, standard_uncertainty), words.units.conversion(unit)
    return f"{words.units.number(number, unit)} {printed_unit(conversion.symbol)}".rstrip()


def confidence_meaning(finding: Finding, words: Catalogue = IN_ENGLISH) -> str:
    """Return what the word of confidence stands on, in the facts of this finding."""
    rivals = causes_listed(finding.confusable_with, words)
    told = words.say("confidence.rivals", rivals=rivals) if rivals else ""
    gain = words.say(_gain_key(finding.gain))
    if finding.confidence is Confidence.CERTAIN:
        return words.listed([told or words.say("confidence.no_rival"), gain], "semicolons")
    doubts = [told, "" if _shows(finding.gain) else gain]
    return words.listed([*filter(None, doubts)], "semicolons") or words.say("confidence.not_enough")


def _shows(gain: Gain | None) -> bool:
    return gain is not None and gain.interval_95_mm[0] > 0.0


def _gain_key(gain: Gain | None) -> str:
    if gain is None:
        return "confidence.no_gain"
    return "confidence.gain_above" if _shows(gain) else "confidence.gain_reaches"
