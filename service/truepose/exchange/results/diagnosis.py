"""A diagnosis as a JSON document: what `diagnose --json` prints and the REST API shows.

Amplitudes, details and curves already state the unit that they are in; nothing is converted here. What is
not a finite number becomes null.
"""

from collections.abc import Sequence

from truepose.domain.arrays import FloatArray
from truepose.domain.diagnosis import (
    Cause,
    Curve,
    CurvePoints,
    Dependence,
    Described,
    Detail,
    Diagnosis,
    Finding,
    Gain,
    NextMeasurement,
    Noise,
    Remaining,
    RuledOut,
    Spectrum,
    Worth,
)
from truepose.domain.results import Statistics
from truepose.exchange.json_text import Json, number_or_null
from truepose.exchange.results.documents import statistics_document


def diagnosis_document(diagnosis: Diagnosis) -> dict[str, Json]:
    """Return the document of a diagnosis, whatever its verdict.

    `before` and `after` are null where nothing could be fitted, `gain` where nothing held out shows it,
    `curve` where there is nothing to draw, `described_gain` where nothing is described.
    """
    return {
        "robot": diagnosis.robot,
        "verdict": diagnosis.verdict.value,
        "message": diagnosis.message,
        "start_effects": list(diagnosis.start_effects),
        "findings": [_finding(finding) for finding in diagnosis.findings],
        "small_findings": [_finding(finding) for finding in diagnosis.small],
        "quantity": diagnosis.quantity,
        "before": _statistics(diagnosis.before),
        "after": _statistics(diagnosis.after),
        "held_out": diagnosis.held_out,
        "worst": _worst(diagnosis),
        "remaining": _remaining(diagnosis.remaining),
        "next_measurements": [_next_measurement(entry) for entry in diagnosis.next_measurements],
        "ruled_out": [_ruled_out(entry) for entry in diagnosis.ruled_out],
        "withdrawn": list(diagnosis.withdrawn),
        "noise": _noise(diagnosis.noise),
    }


def _finding(finding: Finding) -> Json:
    return {
        "effect": finding.effect,
        "subject": finding.subject,
        "amplitude": number_or_null(finding.amplitude),
        "unit": finding.unit,
        "amplitude_standard_uncertainty": number_or_null(finding.amplitude_standard_uncertainty),
        "p_value": number_or_null(finding.p_value),
        "confidence": finding.confidence.value,
        "details": [_detail(detail) for detail in finding.details],
        "sentence": finding.sentence,
        "confusable_with": _causes(finding.confusable_with),
        "gain": _gain(finding.gain),
        "share": number_or_null(finding.share),
        "parameters": list(finding.parameters),
        "curve": _curve(finding.curve),
        "where": finding.where,
        "over": finding.over,
        "shape": finding.shape,
        "worth": _worth(finding.worth),
        "spectrum": _spectrum(finding.spectrum),
    }


def _spectrum(spectrum: Spectrum | None) -> Json:
    if spectrum is None:
        return None
    return {
        "order": _numbers(spectrum.order),
        "amplitude_deg": _numbers(spectrum.amplitude_deg),
        "standard_uncertainty_deg": _numbers(spectrum.standard_uncertainty_deg),
    }


def _worth(worth: Worth | None) -> Json:
    if worth is None:
        return None
    return {
        "mean_mm": number_or_null(worth.mean_mm),
        "max_mm": number_or_null(worth.max_mm),
        "own_mm": None if worth.own_mm is None else number_or_null(worth.own_mm),
    }


def _detail(detail: Detail) -> Json:
    return {
        "name": detail.name,
        "value": number_or_null(detail.value),
        "unit": detail.unit,
        "standard_uncertainty": number_or_null(detail.standard_uncertainty),
    }


def _causes(causes: Sequence[Cause]) -> Json:
    return [{"effect": cause.effect, "subject": cause.subject} for cause in causes]


def _gain(gain: Gain | None) -> Json:
    if gain is None:
        return None
    return {
        "rms_before_mm": number_or_null(gain.rms_before_mm),
        "rms_after_mm": number_or_null(gain.rms_after_mm),
        "interval_95_mm": [number_or_null(bound) for bound in gain.interval_95_mm],
    }


def _statistics(statistics: Statistics | None) -> Json:
    return None if statistics is None else statistics_document(statistics)


def _worst(diagnosis: Diagnosis) -> Json:
    """Return the held-out point at which the extended model is farthest off; null where none was fitted."""
    if diagnosis.errors is None or not len(diagnosis.errors.config):
        return None
    worst = diagnosis.errors.worst
    return {
        "config": worst.config,
        "before_mm": number_or_null(worst.before_mm),
        "after_mm": number_or_null(worst.after_mm),
    }


def _remaining(remaining: Remaining) -> Json:
    return {
        "structure": remaining.structure,
        "depends_on": [_dependence(dependence) for dependence in remaining.depends_on],
        "sentence": remaining.sentence,
        "described": [_described(entry) for entry in remaining.described],
        "described_gain": _gain(remaining.described_gain),
    }


def _described(described: Described) -> Json:
    return {"where": described.where, "over": described.over, "worth": _worth(described.worth)}


def _dependence(dependence: Dependence) -> Json:
    return {
        "variable": dependence.variable,
        "p_value": number_or_null(dependence.p_value),
        "curve": _curve(dependence.curve),
    }


def _curve(curve: Curve | None) -> Json:
    if curve is None:
        return None
    return {
        "variable": curve.variable,
        "variable_unit": curve.variable_unit,
        "quantity": curve.quantity,
        "quantity_unit": curve.quantity_unit,
        "x": _numbers(curve.x),
        "residual": _numbers(curve.residual),
        "standard_uncertainty": _numbers(curve.standard_uncertainty),
        "line_x": _numbers(curve.line_x),
        "line": _numbers(curve.line),
        "line_band": _numbers(curve.line_band),
        "unseen": _points(curve.unseen),
    }


def _points(points: CurvePoints | None) -> Json:
    if points is None:
        return None
    return {
        "x": _numbers(points.x),
        "residual": _numbers(points.residual),
        "standard_uncertainty": _numbers(points.standard_uncertainty),
    }


def _numbers(array: FloatArray) -> Json:
    return [number_or_null(entry) for entry in array.tolist()]


def _next_measurement(entry: NextMeasurement) -> Json:
    return {
        "sentence": entry.sentence,
        "configurations_deg": [[float(angle) for angle in joints] for joints in entry.configurations_deg],
        "separates": _causes(entry.separates),
    }


def _ruled_out(entry: RuledOut) -> Json:
    return {
        "effect": entry.effect,
        "subject": entry.subject,
        "reason": entry.reason,
        "p_value": None if entry.p_value is None else number_or_null(entry.p_value),
        "visible": entry.visible,
        "upper_limit_mm": None if entry.upper_limit_mm is None else number_or_null(entry.upper_limit_mm),
    }


def _noise(noise: Noise | None) -> Json:
    if noise is None:
        return None
    degrees = noise.tail_degrees_of_freedom
    return {
        "scale": number_or_null(noise.scale),
        "tail_degrees_of_freedom": None if degrees is None else number_or_null(degrees),
        "sentence": noise.sentence,
    }
