"""The report of a diagnosis: what the model gets wrong, why, and how anyone can check it."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from markupsafe import Markup

from truepose.domain.arrays import FloatArray
from truepose.domain.results.diagnosis import Confidence, Dependence, Diagnosis, NextMeasurement
from truepose.domain.results.identification import Model
from truepose.domain.sentences import Text
from truepose.exchange.models.document import file_factor, file_unit
from truepose.reports.causes_found.cause_map import MapCell, cause_map
from truepose.reports.causes_found.described import described_rows, described_sentence
from truepose.reports.causes_found.findings import finding_blocks
from truepose.reports.causes_found.ruled_out import ruled_out_rows
from truepose.reports.figures.curves.residuals import CurveFigure, residual_curve
from truepose.reports.figures.gains import gains
from truepose.reports.figures.histograms.comparison import comparison
from truepose.reports.figures.maps.cause_map import map_picture, share_text
from truepose.reports.figures.maps.error_maps import error_maps
from truepose.reports.front.kinds import diagnosis_front
from truepose.reports.front.page import front_page
from truepose.reports.pages import rendered
from truepose.reports.paper import write_report_text
from truepose.reports.parameters.meanings import meaning
from truepose.reports.seen.diagnoses import (
    curve_sentence,
    gains_sentence,
    map_sentence,
    places_sentence,
)
from truepose.reports.seen.errors import errors_sentence
from truepose.reports.traceability.conditions import ReportConditions, condition_rows
from truepose.reports.traceability.imprint import imprint_of
from truepose.reports.wording.causes import causes_listed, printed_unit, verdict_words
from truepose.reports.wording.rounding import MISSING, fixed, rounded, uncertainty, with_minus
from truepose.words.catalogue import ENGLISH, IN_ENGLISH, Catalogue, catalogue

_HELD_OUT = {
    ("validation", "position"): "report.held_out.positions",
    ("validation", "length"): "report.held_out.lengths",
    ("cross_validation", "position"): "report.cross_validated.positions",
    ("cross_validation", "length"): "report.cross_validated.lengths",
}
_CAMPAIGN = "campaign"  # where a model tells what its readings are called


@dataclass(frozen=True, slots=True)
class DiagnosisInput:
    """What a report is made from; only the diagnosis is needed."""

    diagnosis: Diagnosis
    campaign: str = ""  # what the readings are called; "" is printed as not stated
    conditions: ReportConditions = field(default_factory=ReportConditions)
    language: str = ENGLISH  # one of `LANGUAGES`


@dataclass(frozen=True, slots=True)
class DependenceBlock:
    """Something that what is left depends on, with its picture."""

    dependence: Dependence
    name: str
    curve: CurveFigure | None
    seen: Text = ""  # what the curve shows


@dataclass(frozen=True, slots=True)
class Proposal:
    """An action or configurations to measure next, as text."""

    sentence: str
    separates: str
    configurations: tuple[tuple[str, ...], ...]  # deg


@dataclass(frozen=True, slots=True)
class AddedParameter:
    """A parameter that a finding adds to the model, in the unit of documents."""

    name: str
    value: str
    standard_uncertainty: str
    unit: str
    meaning: str


def write_diagnosis_report(path: Path, report: DiagnosisInput) -> None:
    """Write the report of a diagnosis as one self-contained HTML file, whatever the verdict.

    Parameters
    ----------
    path : Path
        Replaced where it exists; its folder is made.
    report : DiagnosisInput

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    """
    write_report_text(path, diagnosis_page(report))


def diagnosis_page(report: DiagnosisInput) -> Markup:
    """Return the report as one self-contained page."""
    return rendered("diagnosis.html", **_context(report))


def diagnosis_content(report: DiagnosisInput) -> Markup:
    """Return the same content without its frame, for a page that has one of its own."""
    return rendered("diagnosis_content.html", **_context(report))


def _context(report: DiagnosisInput) -> dict[str, object]:
    diagnosis, words = report.diagnosis, catalogue(report.language)
    blocks, counted = finding_blocks(diagnosis, words), len(diagnosis.findings)
    return {
        "diagnosis": diagnosis,
        "words": words,
        "say": words.say,
        "campaign": report.campaign or _named_campaign(diagnosis.model),
        "conditions": report.conditions,
        "stated_conditions": tuple(_stated(report.conditions, words)),
        "front": front_page(diagnosis_front(diagnosis, words), report.conditions, words),
        "imprint": imprint_of(diagnosis.robot, report.conditions, words),
        "simulated": report.conditions.simulated,
        "verdict": verdict_words(diagnosis.verdict, answered=diagnosis.model is not None, words=words),
        "origin": () if diagnosis.model is None else tuple(_origin(diagnosis.model, words)),
        "findings": blocks[:counted],
        "counted": _counted(diagnosis, words),
        "held_out": _held_out(diagnosis, words),
        "small": blocks[counted:],
        **_map(diagnosis, words),
        "gains": gains(diagnosis.all_findings, words),
        "gains_seen": gains_sentence(diagnosis.all_findings, words),
        "dependences": _dependences(diagnosis, words),
        "described": described_rows(diagnosis.remaining.described, words),
        "added_words": _added_words(diagnosis, words),
        "described_sentence": described_sentence(diagnosis.remaining, words),
        "found": ruled_out_rows((entry for entry in diagnosis.ruled_out if entry.visible), words),
        "unseen": ruled_out_rows((entry for entry in diagnosis.ruled_out if not entry.visible), words),
        "proposals": tuple(_proposal(one, words) for one in diagnosis.next_measurements),
        "added": added_parameters(diagnosis, words),
        **_errors(diagnosis, words),
    }


def _counted(diagnosis: Diagnosis, words: Catalogue) -> str:
    certain = sum(finding.confidence is Confidence.CERTAIN for finding in diagnosis.findings)
    likely = len(diagnosis.findings) - certain
    if not diagnosis.small:
        return words.say("report.counted", certain=certain, likely=likely)
    return words.say("report.counted.small", certain=certain, likely=likely, small=len(diagnosis.small))


def _held_out(diagnosis: Diagnosis, words: Catalogue) -> str:
    if diagnosis.after is None:
        return ""
    return words.say(_HELD_OUT[diagnosis.held_out, diagnosis.quantity], number=diagnosis.after.n)


def _added_words(diagnosis: Diagnosis, words: Catalogue) -> str:
    """Return what the extended model has beyond the start, "" where there is nothing."""
    if diagnosis.findings:
        return words.say("added.both" if diagnosis.remaining.described else "added.findings")
    return words.say("added.described") if diagnosis.remaining.described else ""


def _map(diagnosis: Diagnosis, words: Catalogue) -> dict[str, object]:
    found = cause_map(diagnosis)
    if found is None:
        return {"map": None}
    rows = tuple(_map_row(cell, words) for cell in found.cells)
    return {
        "map": map_picture(found, words),
        "map_rows": rows,
        "map_rivals": bool(found.links),
        "map_seen": map_sentence(found),
    }


def _map_row(cell: MapCell, words: Catalogue) -> tuple[str, str, str, str]:
    """Return a cell as where, over what, share, and what is told there."""
    findings = [words.say("map.row.finding", number=number) for number in cell.findings]
    rivals = [words.say("map.row.rival", number=number) for number in cell.rival_of]
    told = words.between.join([*findings, *rivals] or [words.say("map.described")])
    return words.name(cell.where), words.name(cell.over), share_text(cell.share) or MISSING, told


def _origin(model: Model, words: Catalogue) -> Iterator[tuple[str, str | int | float]]:
    """Yield what the model says of its readings beside their name, in words."""
    told = model.identified_from.items()
    return ((words.name(name.replace("_", " ")), said) for name, said in told if name != _CAMPAIGN)


def _named_campaign(model: Model | None) -> str:
    return "" if model is None else str(model.identified_from.get(_CAMPAIGN, ""))


def _stated(conditions: ReportConditions, words: Catalogue) -> Iterator[tuple[str, str]]:
    """Yield what somebody stated: a diagnosis rests on the readings, and what nobody said has no row here."""
    silent = dict(condition_rows(ReportConditions(), words))
    return ((name, text) for name, text in condition_rows(conditions, words) if text != silent.get(name))


def _errors(diagnosis: Diagnosis, words: Catalogue) -> dict[str, object]:
    errors, after = diagnosis.errors, diagnosis.after
    if errors is None or after is None:
        return {"histogram": None, "beyond": 0, "maps": None}
    before_mm, after_mm = _norms(errors.before_mm), _norms(errors.after_mm)
    known = np.isfinite(before_mm) & np.isfinite(after_mm)
    if not known.any():
        return {"histogram": None, "beyond": 0, "maps": None}
    picture, beyond = comparison(before_mm[known], after_mm[known], after.noise_mm, words)
    return {
        "histogram": picture,
        "histogram_seen": errors_sentence(before_mm[known], after_mm[known]),
        "beyond": beyond,
        "maps": error_maps(errors, words),
        "maps_seen": places_sentence(errors),
    }


def _norms(errors_mm: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(errors_mm, axis=1))


def _dependences(diagnosis: Diagnosis, words: Catalogue) -> tuple[DependenceBlock, ...]:
    numbered = enumerate(diagnosis.remaining.depends_on, 1)
    return tuple(_dependence(number, one, words) for number, one in numbered)


def _dependence(number: int, dependence: Dependence, words: Catalogue) -> DependenceBlock:
    name = words.name(dependence.variable)
    if dependence.curve is None:
        return DependenceBlock(dependence, name, None)
    curve = residual_curve(dependence.curve, f"left-{number}", of_cause=False, words=words)
    return DependenceBlock(dependence, name, curve, curve_sentence(dependence.curve, words))


def _proposal(measurement: NextMeasurement, words: Catalogue) -> Proposal:
    configurations = tuple(
        tuple(with_minus(fixed(angle, 2, "deg")) for angle in joints)
        for joints in measurement.configurations_deg
    )
    return Proposal(
        words.spoken(measurement.sentence), causes_listed(measurement.separates, words), configurations
    )


def added_parameters(diagnosis: Diagnosis, words: Catalogue = IN_ENGLISH) -> tuple[AddedParameter, ...]:
    """Return the parameters that the findings name, as the extended model holds them."""
    if diagnosis.model is None:
        return ()
    wanted = dict.fromkeys(name for finding in diagnosis.all_findings for name in finding.parameters)
    return tuple(_added(diagnosis.model, name, words) for name in wanted if name in _names(diagnosis.model))


def _names(model: Model) -> set[str]:
    return {parameter.name for parameter in model.parameters}


def _added(model: Model, name: str, words: Catalogue) -> AddedParameter:
    parameter = next(entry for entry in model.parameters if entry.name == name)
    factor = file_factor(parameter.unit)
    u = parameter.standard_uncertainty * factor
    return AddedParameter(
        name=name,
        value=rounded(parameter.value * factor, u, file_unit(parameter.unit)),
        standard_uncertainty=uncertainty(u, file_unit(parameter.unit)),
        unit=printed_unit(words.units.conversion(file_unit(parameter.unit)).symbol),
        meaning=meaning(name, parameter.effect, words),
    )
