"""What stands below the outcome of an identification: on which readings it rests, and a few numbers."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from truepose.domain.identification import Identification, NominalAndIdentified, Statistics, Status
from truepose.identification.verdict.judge import Assessment
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Message, Text, message, together
from truepose.reports.cover_page import OneFigure
from truepose.reports.rounding import millimetres, uncertainty
from truepose.reports.traceability import NOT_STATED
from truepose.reports.uncertainty_budget import Budget

# By what judges the model and what it measures.
_JUDGED_ON: Final = {
    ("validation", "position"): "judged.validation.position",
    ("validation", "length"): "judged.validation.length",
    ("cross_validation", "position"): "judged.cross_validation.position",
    ("cross_validation", "length"): "judged.cross_validation.length",
    ("calibration", "position"): "judged.calibration.position",
    ("calibration", "length"): "judged.calibration.length",
}


@dataclass(frozen=True, slots=True)
class Headline:
    """What stands above everything else."""

    sentence: str
    good: bool
    figures: tuple[OneFigure, ...] = ()


def headline(
    identification: Identification,
    judged: Assessment | None,
    budget: Budget | None,
    words: Catalogue = IN_ENGLISH,
) -> Headline:
    """Return the headline; whatever was not reached is said first."""
    pair = identification.judging
    if judged is None or budget is None or pair is None:
        return Headline(words.spoken(identification.message or message("headline.none")), good=False)
    converged = identification.status is Status.CONVERGED
    warning = "" if converged else message("headline.not_to_be_used", message=identification.message)
    aside = identification.set_aside
    # The warning has said it with the message.
    left_out = aside.sentence if converged and aside is not None else ""
    judged_on = _sentence(identification, budget, pair)
    return Headline(
        sentence=words.spoken(together(warning, judged_on, _grown(pair), left_out)),
        good=converged and _improves(pair),
        figures=tuple(_figure(words, *figure) for figure in _figures(identification, budget, pair)),
    )


def _figure(words: Catalogue, name: str, value: Text, remark: Text) -> OneFigure:
    return OneFigure(words.say(name), words.spoken(value), words.spoken(remark))


def _improves(pair: NominalAndIdentified) -> bool:
    nominal, identified = pair.nominal, pair.identified
    return identified.mean_mm < nominal.mean_mm and identified.rms_mm < nominal.rms_mm


def _sentence(identification: Identification, budget: Budget, pair: NominalAndIdentified) -> Message:
    return message(
        "headline.judged",
        judged=basis_of(identification, pair.nominal),
        before=_expanded(budget.before_mm),
        after=_expanded(budget.after_mm),
        noise=_noise(pair.identified),
    )


def _expanded(u_mm: float) -> Message:
    if not math.isfinite(u_mm):
        return message("headline.expanded.unknown")
    return message("headline.expanded", u=uncertainty(2 * u_mm))


def _grown(pair: NominalAndIdentified) -> Text:
    """Say that the mean does not fall, or that it hides growing errors, which it alone would praise."""
    nominal, identified = pair.nominal, pair.identified
    if identified.mean_mm >= nominal.mean_mm:
        return message("headline.no_better")
    if identified.rms_mm < nominal.rms_mm:
        return ""
    return message("headline.grown", before=millimetres(nominal.rms_mm), after=millimetres(identified.rms_mm))


def _noise(identified: Statistics) -> Message:
    if identified.noise_mm == 0.0:
        return message("headline.noise.not_stated")
    below = identified.noise_mm >= identified.mean_mm
    key = "headline.noise.all" if below else "headline.noise.part"
    return message(key, noise=millimetres(identified.noise_mm))


def basis_of(identification: Identification, statistics: Statistics) -> Message:
    """Return what the figures stand on, e.g. "1,000 held-out positions"."""
    return message(_JUDGED_ON[_judged_by(identification), identification.quantity], n=statistics.n)


def _judged_by(identification: Identification) -> str:
    if identification.validation is not None:
        return "validation"
    return "calibration" if identification.cross_validation is None else "cross_validation"


def _figures(
    identification: Identification, budget: Budget, pair: NominalAndIdentified
) -> Iterator[tuple[str, Text, Text]]:
    """Yield the name of each number by its key, the number, and a remark."""
    nominal, identified = pair.nominal, pair.identified
    factor = nominal.mean_mm / identified.mean_mm if identified.mean_mm > 0.0 else float("inf")
    yield "headline.mean_before", _length(millimetres(nominal.mean_mm)), _expanded(budget.before_mm)
    yield "headline.mean_after", _length(millimetres(identified.mean_mm)), _expanded(budget.after_mm)
    before = message("headline.largest_before", largest=millimetres(nominal.max_mm))
    yield "headline.largest_after", _length(millimetres(identified.max_mm)), before
    noise = _length(millimetres(identified.noise_mm))
    yield "report.noise_alone", noise, _noise_of(identification, identified)
    times = message("headline.improvement.value", factor=factor)
    yield "headline.improvement", times, message("headline.improvement.remark")


def _noise_of(identification: Identification, identified: Statistics) -> Message:
    """Return of which readings the noise is, and what is in it."""
    if identified.noise_mm == 0.0:
        return message(NOT_STATED)
    held_out = identification.validation is not None
    key = "headline.noise_alone.held_out" if held_out else "headline.noise_alone.calibration"
    return message(key, n=identified.n)


def _length(number: str) -> Message:
    return message("length", length=number)
