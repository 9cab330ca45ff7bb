"""One finding as a block of a page: its numbers as text, its curve, and what else it could be."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from markupsafe import Markup

from truepose.domain.diagnosis import (
    Cause,
    Detail,
    Diagnosis,
    EffectSize,
    Finding,
    Gain,
    NextMeasurement,
    RuledOut,
    Spectrum,
)
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.effects.signatures import alike, amplitude_of, has_trade_name, named_signature, of_legs
from truepose.effects.waves import spoken_order
from truepose.identification.distributions import WITHIN_95
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Text
from truepose.reports.captions import curve_sentence, spectrum_sentence
from truepose.reports.cause_words import (
    cause_words,
    confidence_meaning,
    confidence_word,
    place_words,
    printed_unit,
    with_unit,
    worth_words,
)
from truepose.reports.diagnosis.rows import own_text, ruled_out_table
from truepose.reports.figures.residuals import CurveFigure, residual_curve
from truepose.reports.figures.svg_rendering import AFTER, INK, mark_axis, new_figure, page_style, to_svg
from truepose.reports.rounding import interval, millimetres, p_value, with_minus, with_uncertainty
from truepose.reports.tables import Table


@dataclass(frozen=True, slots=True)
class Rival:
    """A cause that these data cannot tell from the finding, and what would."""

    name: str
    separated_by: str  # sentence of the measurement; "" where none is proposed


@dataclass(frozen=True, slots=True)
class Alternatives:
    """The answer to "could it be something else?" for one finding."""

    rivals: tuple[Rival, ...]
    excluded: Table  # act alike, were tried and not found
    not_excluded: Table  # act alike, and these data cannot show them


def alternatives(finding: Finding, diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> Alternatives:
    """Return what else it could be, and what it is not."""
    alike = [
        entry
        for entry in diagnosis.ruled_out
        if acts_alike(finding, entry) and not _impossible(entry, diagnosis)
    ]
    named = set(finding.confusable_with)
    rest = [entry for entry in alike if Cause(entry.effect, entry.subject) not in named]
    return Alternatives(
        rivals=tuple(_rivals(finding, diagnosis.next_measurements, words)),
        excluded=ruled_out_table((entry for entry in rest if entry.visible), words, tried=True),
        not_excluded=ruled_out_table((entry for entry in rest if not entry.visible), words, tried=False),
    )


def acts_alike(finding: Finding, entry: RuledOut) -> bool:
    """Whether the two leave similar residuals: the same effect elsewhere, or cells that are alike."""
    if finding.effect == entry.effect and (has_trade_name(entry.effect) or finding.subject == entry.subject):
        return finding.subject != entry.subject
    return alike(
        named_signature(finding.effect, finding.subject), named_signature(entry.effect, entry.subject)
    )


def _impossible(entry: RuledOut, diagnosis: Diagnosis) -> bool:
    # What is not there cannot be what was found: a campaign of positions has no ballbar.
    return diagnosis.quantity == "position" and of_legs(named_signature(entry.effect, entry.subject))


def _rivals(finding: Finding, proposals: tuple[NextMeasurement, ...], words: Catalogue) -> Iterator[Rival]:
    own = Cause(finding.effect, finding.subject)
    for cause in finding.confusable_with:
        wanted = (proposal for proposal in proposals if cause in proposal.separates)
        both = sorted(wanted, key=lambda proposal: own not in proposal.separates)
        yield Rival(cause_words(cause, words), words.spoken(both[0].sentence) if both else "")


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


def _worth_remark(worth: EffectSize, words: Catalogue) -> str:
    if worth.own_mm is None:
        return words.say("finding.worth.remark")
    return words.say("finding.worth.remark_own", own=own_text(worth))


def _interval(finding: Finding, words: Catalogue) -> str:
    u, to = finding.amplitude_standard_uncertainty, words.say("to")
    ends = interval(finding.amplitude - _COVERAGE_95 * u, finding.amplitude + _COVERAGE_95 * u, u, to)
    conversion = words.units.conversion(finding.unit)
    return f"{words.units.number(ends, finding.unit)} {printed_unit(conversion.symbol)}".rstrip()


def gain_text(gain: Gain | None, words: Catalogue = IN_ENGLISH) -> tuple[str, str]:
    """Return what a finding takes off the held-out RMS with its interval, and of what."""
    if gain is None:
        return words.say("finding.gain.unknown"), words.say("finding.gain.unknown.remark")
    low, high = (with_minus(millimetres(end)) for end in gain.interval_95_mm)
    difference = with_minus(millimetres(gain.rms_before_mm - gain.rms_after_mm))
    return (
        words.say("finding.gain.value", difference=difference, low=low, high=high),
        words.say("finding.gain.remark"),
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


_MOST_LABELS = 24  # orders whose numbers still stand side by side


def spectrum_picture(spectrum: Spectrum, prefix: str, words: Catalogue = IN_ENGLISH) -> Markup:
    """Draw a bar for each order with its 95 % interval, evenly spaced: orders of gears lie far apart."""
    at, amplitude = np.arange(len(spectrum.order)), spectrum.amplitude_deg
    reach = WITHIN_95 * spectrum.standard_uncertainty_deg
    step = -(-len(at) // _MOST_LABELS)
    with page_style():
        figure = new_figure(8.0, 2.4)
        axes = figure.add_subplot()
        axes.bar(
            at,
            amplitude,
            width=0.6,
            color=AFTER,
            alpha=0.5,
            linewidth=0.0,
            label=words.say("spectrum.amplitude"),
        )
        axes.vlines(
            at,
            np.maximum(amplitude - reach, 0.0),
            amplitude + reach,
            color=INK,
            linewidth=1.1,
            label=words.say("spectrum.interval"),
        )
        axes.set_xticks(at[::step], [spoken_order(order) for order in spectrum.order[::step].tolist()])
        axes.grid(axis="x", visible=False)
        mark_axis(axes.yaxis, words.units.conversion("deg"))
        axes.set_xlabel(words.say("spectrum.order"))
        axes.set_ylabel(words.say("spectrum.amplitude_deg"))
        figure.legend(loc="outside upper left", ncols=2)
        return to_svg(figure, prefix, words.say("spectrum"), words)
