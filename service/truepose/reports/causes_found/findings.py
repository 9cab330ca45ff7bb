"""One finding as a block of a page: its numbers as text, its curve, and what else it could be."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from markupsafe import Markup

from truepose.domain.results.causes import Cause, Detail
from truepose.domain.results.diagnosis import Diagnosis, Finding, Gain, Worth
from truepose.domain.sentences import Text
from truepose.effects.cells import amplitude_of
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.reports.causes_found.described import own_text
from truepose.reports.causes_found.look_alikes import Alternatives, alternatives
from truepose.reports.figures.curves.residuals import CurveFigure, residual_curve
from truepose.reports.figures.curves.spectrum import spectrum_picture
from truepose.reports.seen.diagnoses import curve_sentence, spectrum_sentence
from truepose.reports.wording.causes import (
    cause_words,
    confidence_meaning,
    confidence_word,
    place_words,
    printed_unit,
    with_unit,
    worth_words,
)
from truepose.reports.wording.rounding import interval, millimetres, p_value, with_minus, with_uncertainty
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_COVERAGE_95 = 1.96  # of a normal distribution
_WAYS = frozenset({"order", "source joint"})  # a finding may have several, each with its own amplitude


@dataclass(frozen=True, slots=True)
class FindingBlock:
    """What a page shows of one finding; numbers are text with their unit."""

    number: int
    finding: Finding
    name: str
    sentence: str
    amplitude: str
    rows: tuple[tuple[str, str, str], ...]  # what, value, remark
    details: tuple[tuple[str, str, str], ...]  # name, value, unit
    confidence_word: str
    confidence: str  # what the word means here
    curve: CurveFigure | None
    curve_seen: Text
    spectrum: Markup | None
    spectrum_seen: Text
    alternatives: Alternatives


def finding_blocks(diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> tuple[FindingBlock, ...]:
    """Return a block for each finding, in their order, the small ones last."""
    return tuple(
        _block(number, finding, diagnosis, words) for number, finding in enumerate(diagnosis.all_findings, 1)
    )


def _block(number: int, finding: Finding, diagnosis: Diagnosis, words: Catalogue) -> FindingBlock:
    return FindingBlock(
        number=number,
        finding=finding,
        name=cause_words(Cause(finding.effect, finding.subject), words),
        sentence=words.spoken(finding.sentence),
        amplitude=amplitude_text(finding, words),
        rows=tuple(_rows(finding, words)),
        details=tuple(_details(finding.details, words)),
        confidence_word=confidence_word(finding.confidence, words),
        confidence=confidence_meaning(finding, words),
        curve=_curve(number, finding, words),
        curve_seen="" if finding.curve is None else curve_sentence(finding.curve, words),
        spectrum=_spectrum(number, finding, words),
        spectrum_seen="" if finding.spectrum is None else spectrum_sentence(finding.spectrum),
        alternatives=alternatives(finding, diagnosis, words),
    )


def amplitude_text(finding: Finding, words: Catalogue = IN_ENGLISH) -> str:
    """Return amplitude ± standard uncertainty with unit."""
    return with_unit(finding.amplitude, finding.amplitude_standard_uncertainty, finding.unit, words)


def _rows(finding: Finding, words: Catalogue) -> Iterator[tuple[str, str, str]]:
    say = words.say
    yield say("finding.amplitude"), amplitude_text(finding, words), words.name(amplitude_of(finding.effect))
    if 0.0 < finding.amplitude_standard_uncertainty < math.inf:
        yield say("finding.interval"), _interval(finding, words), say("finding.interval.remark")
    if finding.where:
        yield say("finding.place"), place_words(finding, words), ""
    if finding.worth is not None:
        yield say("finding.worth"), worth_words(finding.worth, words), _worth_remark(finding.worth, words)
    yield say("finding.gain"), *gain_text(finding.gain, words)
    yield say("finding.p"), p_value(finding.p_value), say("finding.p.remark")
    share = say("finding.share.value", percent=100.0 * finding.share)
    yield say("finding.share"), share, say("finding.share.remark")


def _worth_remark(worth: Worth, words: Catalogue) -> str:
    if worth.own_mm is None:
        return words.say("finding.worth.remark")
    return words.say("finding.worth.remark_own", own=own_text(worth))


def _interval(finding: Finding, words: Catalogue) -> str:
    u, to = finding.amplitude_standard_uncertainty, words.say("to")
    ends = interval(finding.amplitude - _COVERAGE_95 * u, finding.amplitude + _COVERAGE_95 * u, u, to)
    conversion = words.units.conversion(finding.unit)
    return f"{words.units.number(ends, finding.unit)} {printed_unit(conversion.symbol)}".rstrip()


def gain_text(gain: Gain | None, words: Catalogue = IN_ENGLISH) -> tuple[str, str]:
    """Return what a finding takes off the held-out RMS with its interval, and the two RMS."""
    if gain is None:
        return words.say("finding.gain.unknown"), words.say("finding.gain.unknown.remark")
    low, high = (with_minus(millimetres(end)) for end in gain.interval_95_mm)
    difference = with_minus(millimetres(gain.rms_before_mm - gain.rms_after_mm))
    before, after = millimetres(gain.rms_before_mm), millimetres(gain.rms_after_mm)
    return (
        words.say("finding.gain.value", difference=difference, low=low, high=high),
        words.say("finding.gain.remark", before=before, after=after),
    )


def _details(details: tuple[Detail, ...], words: Catalogue) -> Iterator[tuple[str, str, str]]:
    """Yield each detail; of several ways in which a cause acts, each way with what is told of it."""
    ways = [k for k, detail in enumerate(details) if detail.name in _WAYS]
    if len(ways) < 2:
        yield from (_detail(detail, words) for detail in details)
        return
    yield from (_detail(detail, words) for detail in details[: ways[0]])
    for first, end in pairwise([*ways, len(details)]):
        name, value, unit = _detail(details[first], words)
        told = (" ".join(filter(None, _detail(detail, words))) for detail in details[first + 1 : end])
        yield f"{name} {value} {unit}".rstrip(), words.between.join(told), ""


def _detail(detail: Detail, words: Catalogue) -> tuple[str, str, str]:
    return (
        words.name(detail.name.replace("_", " ")),
        words.units.number(with_uncertainty(detail.value, detail.standard_uncertainty), detail.unit),
        printed_unit(words.units.conversion(detail.unit).symbol),
    )


def _spectrum(number: int, finding: Finding, words: Catalogue) -> Markup | None:
    if finding.spectrum is None:
        return None
    return spectrum_picture(finding.spectrum, f"spectrum-{number}", words)


def _curve(number: int, finding: Finding, words: Catalogue) -> CurveFigure | None:
    if finding.curve is None:
        return None
    return residual_curve(
        finding.curve,
        f"finding-{number}",
        whole=finding.effect in effects_with(Trait.OF_READINGS),  # its far readings are the finding itself
        words=words,
    )
