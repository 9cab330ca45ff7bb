"""The report of a diagnosis: what the model gets wrong, why, and how anyone can check it."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from markupsafe import Markup

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import Dependence, Diagnosis, NextMeasurement
from truepose.domain.results import Model
from truepose.exchange.models.document import file_factor, file_unit
from truepose.reports.causes import causes_listed, printed_unit, verdict_words
from truepose.reports.causes_found.cause_map import MapCell, cause_map
from truepose.reports.causes_found.described import described_rows, described_sentence
from truepose.reports.causes_found.findings import finding_blocks
from truepose.reports.causes_found.ruled_out import ruled_out_rows
from truepose.reports.conditions import ReportConditions, condition_rows
from truepose.reports.figures.cause_map import map_picture, share_text
from truepose.reports.figures.comparison import comparison
from truepose.reports.figures.error_maps import error_maps
from truepose.reports.figures.gains import gains
from truepose.reports.figures.residual_curve import CurveFigure, residual_curve
from truepose.reports.pages import rendered, write_page
from truepose.reports.parameters.meanings import meaning
from truepose.reports.rounding import MISSING, rounded, uncertainty
from truepose.words.catalogue import IN_ENGLISH

_CAMPAIGN = "campaign"  # where a model tells what its readings are called


@dataclass(frozen=True, slots=True)
class DiagnosisInput:
    """What a report is made from; only the diagnosis is needed."""

    diagnosis: Diagnosis
    campaign: str = ""  # what the readings are called; "" is printed as not stated
    conditions: ReportConditions = field(default_factory=ReportConditions)


@dataclass(frozen=True, slots=True)
class DependenceBlock:
    """Something that what is left depends on, with its picture."""

    dependence: Dependence
    curve: CurveFigure | None


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
    write_page(path, "diagnosis.html", **_context(report))


def diagnosis_content(report: DiagnosisInput) -> Markup:
    """Return the same content without its frame, for a page that has one of its own."""
    return rendered("diagnosis_content.html", **_context(report))


def _context(report: DiagnosisInput) -> dict[str, object]:
    diagnosis = report.diagnosis
    blocks, counted = finding_blocks(diagnosis), len(diagnosis.findings)
    return {
        "diagnosis": diagnosis,
        "words": IN_ENGLISH,
        "campaign": report.campaign or _named_campaign(diagnosis.model),
        "conditions": report.conditions,
        "stated_conditions": tuple(_stated(report.conditions)),
        "simulated": report.conditions.simulated,
        "verdict": verdict_words(diagnosis.verdict, answered=diagnosis.model is not None),
        "origin": () if diagnosis.model is None else tuple(_origin(diagnosis.model)),
        "findings": blocks[:counted],
        "small": blocks[counted:],
        **_map(diagnosis),
        "gains": gains(diagnosis.all_findings),
        "dependences": tuple(map(_dependence, range(1, 100), diagnosis.remaining.depends_on)),
        "described": described_rows(diagnosis.remaining.described),
        "added_words": _added_words(diagnosis),
        "described_sentence": described_sentence(diagnosis.remaining),
        "found": ruled_out_rows(entry for entry in diagnosis.ruled_out if entry.visible),
        "unseen": ruled_out_rows(entry for entry in diagnosis.ruled_out if not entry.visible),
        "proposals": tuple(map(_proposal, diagnosis.next_measurements)),
        "added": added_parameters(diagnosis),
        **_errors(diagnosis),
    }


def _added_words(diagnosis: Diagnosis) -> str:
    """Return what the extended model has beyond the start, "" where there is nothing."""
    findings = "the findings" if diagnosis.findings else ""
    described = "what is described" if diagnosis.remaining.described else ""
    added = " and ".join(filter(None, (findings, described)))
    return f"with {added}" if added else ""


def _map(diagnosis: Diagnosis) -> dict[str, object]:
    found = cause_map(diagnosis)
    if found is None:
        return {"map": None}
    rows = tuple(map(_map_row, found.cells))
    return {"map": map_picture(found), "map_rows": rows, "map_rivals": bool(found.links)}


def _map_row(cell: MapCell) -> tuple[str, str, str, str]:
    """Return a cell as where, over what, share, and what is told there."""
    findings = [f"finding {number}" for number in cell.findings]
    rivals = [f"a rival of finding {number}" for number in cell.rival_of]
    told = [*findings, *rivals] or ["described without a name"]
    return cell.where, cell.over, share_text(cell.share) or MISSING, ", ".join(told)


def _origin(model: Model) -> Iterator[tuple[str, str | int | float]]:
    """Yield what the model says of its readings beside their name, in words."""
    told = model.identified_from.items()
    return ((name.replace("_", " "), said) for name, said in told if name != _CAMPAIGN)


def _named_campaign(model: Model | None) -> str:
    return "" if model is None else str(model.identified_from.get(_CAMPAIGN, ""))


def _stated(conditions: ReportConditions) -> Iterator[tuple[str, str]]:
    """Yield what somebody stated: a diagnosis rests on the readings, and what nobody said has no row here."""
    silent = dict(condition_rows(ReportConditions()))
    return ((name, text) for name, text in condition_rows(conditions) if text != silent[name])


def _errors(diagnosis: Diagnosis) -> dict[str, object]:
    errors, after = diagnosis.errors, diagnosis.after
    if errors is None or after is None:
        return {"histogram": None, "beyond": 0, "maps": None}
    before_mm, after_mm = _norms(errors.before_mm), _norms(errors.after_mm)
    known = np.isfinite(before_mm) & np.isfinite(after_mm)
    if not known.any():
        return {"histogram": None, "beyond": 0, "maps": None}
    picture, beyond = comparison(before_mm[known], after_mm[known], after.noise_mm)
    return {"histogram": picture, "beyond": beyond, "maps": error_maps(errors)}


def _norms(errors_mm: FloatArray) -> FloatArray:
    return np.asarray(np.linalg.norm(errors_mm, axis=1))


def _dependence(number: int, dependence: Dependence) -> DependenceBlock:
    if dependence.curve is None:
        return DependenceBlock(dependence, None)
    curve = residual_curve(dependence.curve, f"left-{number}", line="smooth curve")
    return DependenceBlock(dependence, curve)


def _proposal(measurement: NextMeasurement) -> Proposal:
    configurations = tuple(
        tuple(f"{angle:.2f}" for angle in joints) for joints in measurement.configurations_deg
    )
    return Proposal(
        IN_ENGLISH.spoken(measurement.sentence), causes_listed(measurement.separates), configurations
    )


def added_parameters(diagnosis: Diagnosis) -> tuple[AddedParameter, ...]:
    """Return the parameters that the findings name, as the extended model holds them."""
    if diagnosis.model is None:
        return ()
    wanted = dict.fromkeys(name for finding in diagnosis.all_findings for name in finding.parameters)
    return tuple(_added(diagnosis.model, name) for name in wanted if name in _names(diagnosis.model))


def _names(model: Model) -> set[str]:
    return {parameter.name for parameter in model.parameters}


def _added(model: Model, name: str) -> AddedParameter:
    parameter = next(entry for entry in model.parameters if entry.name == name)
    factor = file_factor(parameter.unit)
    u = parameter.standard_uncertainty * factor
    return AddedParameter(
        name=name,
        value=rounded(parameter.value * factor, u),
        standard_uncertainty=uncertainty(u),
        unit=printed_unit(file_unit(parameter.unit)),
        meaning=meaning(name, parameter.effect).replace("_", " "),
    )
