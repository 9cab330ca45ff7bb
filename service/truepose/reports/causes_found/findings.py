"""One finding as a block of a page: its numbers as text, its curve, and what else it could be."""

import math
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

from markupsafe import Markup

from truepose.domain.diagnosis import Cause, Detail, Diagnosis, Finding, Gain, Worth
from truepose.effects.cells import amplitude_of
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.reports.causes import (
    cause_words,
    confidence_meaning,
    place_words,
    printed_unit,
    worth_words,
)
from truepose.reports.causes_found.described import own_text
from truepose.reports.causes_found.look_alikes import Alternatives, alternatives
from truepose.reports.figures.residual_curve import CurveFigure, residual_curve
from truepose.reports.figures.spectrum import spectrum_picture
from truepose.reports.rounding import MINUS, interval, millimetres, p_value, with_uncertainty

_COVERAGE_95 = 1.96  # of a normal distribution
_WAYS = frozenset({"order", "source joint"})  # a finding may have several, each with its own amplitude


@dataclass(frozen=True, slots=True)
class FindingBlock:
    """What a page shows of one finding; numbers are text with their unit."""

    number: int
    finding: Finding
    name: str
    amplitude: str
    rows: tuple[tuple[str, str, str], ...]  # what, value, remark
    details: tuple[tuple[str, str, str], ...]  # name, value, unit
    confidence: str  # what the word means here
    curve: CurveFigure | None
    spectrum: Markup | None
    alternatives: Alternatives


def finding_blocks(diagnosis: Diagnosis) -> tuple[FindingBlock, ...]:
    """Return a block for each finding, in their order, the small ones last."""
    return tuple(
        _block(number, finding, diagnosis) for number, finding in enumerate(diagnosis.all_findings, 1)
    )


def _block(number: int, finding: Finding, diagnosis: Diagnosis) -> FindingBlock:
    return FindingBlock(
        number=number,
        finding=finding,
        name=cause_words(Cause(finding.effect, finding.subject)),
        amplitude=amplitude_text(finding),
        rows=tuple(_rows(finding)),
        details=tuple(_details(finding.details)),
        confidence=confidence_meaning(finding),
        curve=_curve(number, finding),
        spectrum=_spectrum(number, finding),
        alternatives=alternatives(finding, diagnosis),
    )


def amplitude_text(finding: Finding) -> str:
    """Return amplitude ± standard uncertainty with unit."""
    value = with_uncertainty(finding.amplitude, finding.amplitude_standard_uncertainty)
    return f"{value} {printed_unit(finding.unit)}".rstrip()


def _rows(finding: Finding) -> Iterator[tuple[str, str, str]]:
    yield "Amplitude ± standard uncertainty", amplitude_text(finding), amplitude_of(finding.effect)
    if 0.0 < finding.amplitude_standard_uncertainty < math.inf:
        yield "95 % interval of the amplitude", _interval(finding), "normal approximation"
    if finding.where:
        yield "Where, over what (shape)", place_words(finding), ""
    if finding.worth is not None:
        yield "Motion of the tool", worth_words(finding.worth), _worth_remark(finding.worth)
    yield "Held-out gain", *gain_text(finding.gain)
    yield "p value", p_value(finding.p_value), "chance of noise alone showing as much, over everything tried"
    yield (
        "Share of the structure",
        f"{100.0 * finding.share:.0f} %",
        "of what all findings together explain; structure that is left is not in it",
    )


def _worth_remark(worth: Worth) -> str:
    remark = "by this cause, over the calibration readings"
    if worth.own_mm is None:
        return remark
    return f"{remark}; without it, all else fitted again, they are missed by {own_text(worth)} mm RMS"


def _interval(finding: Finding) -> str:
    u = finding.amplitude_standard_uncertainty
    ends = interval(finding.amplitude - _COVERAGE_95 * u, finding.amplitude + _COVERAGE_95 * u, u)
    return f"{ends} {printed_unit(finding.unit)}".rstrip()


def gain_text(gain: Gain | None) -> tuple[str, str]:
    """Return what a finding takes off the held-out RMS with its interval, and the two RMS."""
    if gain is None:
        return "not known", "nothing held out can show it"
    low, high = gain.interval_95_mm
    difference = gain.rms_before_mm - gain.rms_after_mm
    return (
        f"{signed_millimetres(difference)} mm (95 % interval {signed_millimetres(low)} to "
        f"{signed_millimetres(high)} mm)",
        f"RMS {millimetres(gain.rms_before_mm)} mm without it, {millimetres(gain.rms_after_mm)} mm with it",
    )


def signed_millimetres(value_mm: float) -> str:
    """Return a difference of lengths with a proper minus sign."""
    return millimetres(value_mm).replace("-", MINUS)


def _details(details: tuple[Detail, ...]) -> Iterator[tuple[str, str, str]]:
    """Yield each detail; of several ways in which a cause acts, each way with what is told of it."""
    ways = [k for k, detail in enumerate(details) if detail.name in _WAYS]
    if len(ways) < 2:
        yield from map(_detail, details)
        return
    yield from map(_detail, details[: ways[0]])
    for first, end in pairwise([*ways, len(details)]):
        name, value, unit = _detail(details[first])
        told = (" ".join(filter(None, _detail(detail))) for detail in details[first + 1 : end])
        yield f"{name} {value} {unit}".rstrip(), ", ".join(told), ""


def _detail(detail: Detail) -> tuple[str, str, str]:
    return (
        detail.name.replace("_", " "),
        with_uncertainty(detail.value, detail.standard_uncertainty),
        printed_unit(detail.unit),
    )


def _spectrum(number: int, finding: Finding) -> Markup | None:
    return None if finding.spectrum is None else spectrum_picture(finding.spectrum, f"spectrum-{number}")


def _curve(number: int, finding: Finding) -> CurveFigure | None:
    if finding.curve is None:
        return None
    return residual_curve(
        finding.curve,
        f"finding-{number}",
        line="fitted effect",
        whole=finding.effect in effects_with(Trait.OF_READINGS),  # its far readings are the finding itself
    )
