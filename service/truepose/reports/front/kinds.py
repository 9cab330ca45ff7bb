"""What stands on the first page of each kind of report."""

from typing import Final

from markupsafe import Markup

from truepose.correction.proof.verdict import Proof
from truepose.domain.results.diagnosis import Diagnosis
from truepose.domain.results.identification import Identification, NominalAndIdentified, Statistics
from truepose.domain.results.validation import Decision, Validation
from truepose.domain.sentences import together
from truepose.reports.front.bars import error_bars
from truepose.reports.front.page import Front, OneFigure, graded, text_of
from truepose.reports.headline import Headline
from truepose.reports.proof.sentences import proof_sentence, proof_verdict
from truepose.reports.uncertainty.judged import judging_figures
from truepose.reports.validation.sentences import decision_sentence, verdict_sentence
from truepose.reports.wording.causes import verdict_words
from truepose.reports.wording.rounding import millimetres, rounded, uncertainty
from truepose.words.catalogue import Catalogue

DECIDED: Final = {
    "conforms": ("front.passed", True),
    "does not conform": ("front.failed", False),
    "cannot be decided": ("front.undecided", None),
}


def identification_front(
    identification: Identification, robot: str, found: Headline, words: Catalogue
) -> Front:
    """Return whether the model may be used, and what it makes of the robot."""
    pair = judging_figures(identification)
    after = next((one for one in found.figures if one.name == words.say("headline.mean_after")), None)
    return Front(
        title=words.say("identification.title", robot=robot),
        look=graded(found.good),
        word=words.say("front.usable" if found.good else "front.unusable"),
        sentence=found.sentence,
        robot=robot,
        figure=after,
        picture=None if pair is None else error_bars(pair.nominal, pair.identified, words),
        caption=words.say("front.bars") if pair is not None else "",
        rule=words.say("front.by_validation"),
    )


def validation_front(found: Validation, robot: str, words: Catalogue, title: str = "") -> Front:
    """Return whether the robot passes, against which limit and by which rule."""
    key, good = _validation_verdict(found)
    sentence, decided = verdict_sentence(found), decision_sentence(found)
    return Front(
        title=title or words.say("validation.title", robot=robot),
        look=graded(good),
        word=words.say(key),
        sentence=text_of(sentence if decided is None else together(sentence, decided), words),
        robot=robot,
        figure=_largest(found, words),
        picture=_bars(found.position, found.limit_mm, words),
        caption=words.say("front.bars" if found.limit_mm is None else "front.bars.limit"),
        rule=_rule(found, words),
    )


def diagnosis_front(diagnosis: Diagnosis, words: Catalogue) -> Front:
    """Return what the model gets wrong, and what knowing it brings."""
    answered = diagnosis.model is not None
    verdict = verdict_words(diagnosis.verdict, answered=answered, words=words)
    before, after = diagnosis.before, diagnosis.after
    return Front(
        title=words.say("report.title", robot=diagnosis.robot),
        look=verdict.look,
        word=verdict.word,
        sentence=words.spoken(diagnosis.message),
        robot=diagnosis.robot,
        figure=None if before is None or after is None else _gained(before, after, words),
        picture=None if before is None or after is None else error_bars(before, after, words),
        caption=words.say("front.bars.diagnosis") if before is not None and after is not None else "",
        rule=verdict.meaning,
    )


def proof_front(proof: Proof, robot: str, words: Catalogue) -> Front:
    """Return whether the corrections of a model make the robot better."""
    verdict = proof_verdict(proof)
    low, high = proof.gain_interval_95
    gain = OneFigure(
        words.say("proof.gain"),
        words.say("proof.gain.value", gain=proof.gain),
        words.say("proof.gain.interval", low=low, high=high),
    )
    return Front(
        title=words.say("proof.title", robot=robot),
        look=verdict.look,
        word=words.say(verdict.word),
        sentence=words.spoken(proof_sentence(proof)),
        robot=robot,
        figure=gain,
        picture=error_bars(proof.before, proof.after, words),
        caption=words.say("front.bars.proof"),
        rule=words.say(verdict.next_step),
    )


def _validation_verdict(found: Validation) -> tuple[str, bool | None]:
    if found.decision is not None:
        return DECIDED[found.decision.verdict]
    if found.limit_mm is None:
        return ("front.as_claimed", True) if found.passed else ("front.not_as_claimed", False)
    return ("front.passed", True) if found.passed else ("front.failed", False)


def _rule(found: Validation, words: Catalogue) -> str:
    return words.say("front.no_limit") if found.decision is None else applied_rule(found.decision, words)


def applied_rule(decision: Decision, words: Catalogue) -> str:
    """Return the limit, and how the uncertainty was counted."""
    key = "front.rule.simple" if decision.rule == "simple" else "front.rule.guard_band"
    return words.say(key, limit_mm=decision.limit_mm)


def _largest(found: Validation, words: Catalogue) -> OneFigure:
    """Return the error that a limit is held against, with its expanded uncertainty."""
    figures, name = found.position.identified, words.say("front.largest")
    known = None if found.uncertainty is None else found.uncertainty.position
    if known is None:
        return OneFigure(
            name, words.units.quantity(millimetres(figures.max_mm), "mm"), words.say("front.of", n=figures.n)
        )
    expanded = 2.0 * known.identified.max_mm
    value = rounded(figures.max_mm, expanded)
    remark = words.say("front.of_with", u=uncertainty(expanded), n=figures.n)
    return OneFigure(name, words.units.quantity(value, "mm"), remark)


def _gained(before: Statistics, after: Statistics, words: Catalogue) -> OneFigure:
    remark = words.say("front.rms_before", before=millimetres(before.rms_mm))
    return OneFigure(
        words.say("report.rms_after"), words.units.quantity(millimetres(after.rms_mm), "mm"), remark
    )


def _bars(pair: NominalAndIdentified, limit_mm: float | None, words: Catalogue) -> Markup:
    return error_bars(pair.nominal, pair.identified, words, limit_mm)
