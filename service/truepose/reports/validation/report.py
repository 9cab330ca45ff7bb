"""The report of a validation: one HTML file, or the content of a page."""

from dataclasses import dataclass, field
from pathlib import Path

from markupsafe import Markup

from truepose.domain.measurement.campaign import Readings
from truepose.domain.results.identification import Model
from truepose.domain.results.validation import ErrorsByPlace, Validation
from truepose.domain.sentences import Sentence, Text
from truepose.identification import judge
from truepose.judgement.cautions import pose_test_caution
from truepose.judgement.iso9283.judged import PoseTest
from truepose.reports.figures.curves.drift import drift_figure
from truepose.reports.figures.histograms.distances import distance_histogram
from truepose.reports.figures.histograms.errors import histogram
from truepose.reports.figures.place_errors import place_errors
from truepose.reports.front.kinds import validation_front
from truepose.reports.front.page import front_page
from truepose.reports.observability.shown import observability_context
from truepose.reports.pages import rendered
from truepose.reports.paper import write_report_text
from truepose.reports.seen.errors import distances_sentence
from truepose.reports.seen.judged import seen_by
from truepose.reports.traceability.audit import Audit
from truepose.reports.traceability.conditions import ReportConditions
from truepose.reports.traceability.imprint import imprint_of
from truepose.reports.traceability.traced import Traced, traced_context, with_temperature
from truepose.reports.uncertainty.deciding import deciding_budget
from truepose.reports.validation.pose_test_rows import (
    drift_sentences,
    pose_test_cards,
    pose_test_rows,
    stated_conditions,
    withheld_sentences,
)
from truepose.reports.validation.sentences import decision_sentence, verdict_sentence
from truepose.reports.wording.turns import turns_rows
from truepose.words.catalogue import ENGLISH, Catalogue, catalogue


@dataclass(frozen=True, slots=True)
class ValidationInput:
    """What a report of a validation is made from."""

    validation: Validation
    model: Model
    readings: Readings
    remarks: tuple[Text, ...] = ()
    pose_test: PoseTest | None = None
    conditions: ReportConditions = field(default_factory=ReportConditions)
    language: str = ENGLISH  # one of `LANGUAGES`
    audit: Audit | None = None  # None: the readings are no session's


def write_validation_report(path: Path, report: ValidationInput) -> None:
    """Write the report of a validation as one self-contained HTML file.

    Parameters
    ----------
    path : Path
        Replaced where it exists; its folder is made.
    report : ValidationInput

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    ConfigurationError
        The readings are not those that the validation is of.
    """
    write_report_text(path, validation_page(report))


def validation_page(report: ValidationInput) -> Markup:
    """Return the report as one self-contained page."""
    return rendered("validation.html", **_context(report))


def validation_content(report: ValidationInput) -> Markup:
    """Return the report without a frame, for a page that has one of its own."""
    return rendered("validation_content.html", **_context(report))


def _context(report: ValidationInput) -> dict[str, object]:
    found, test, words = report.validation, report.pose_test, catalogue(report.language)
    shown = judge(report.model, report.readings, report.model.repeatability_mm)
    conditions = with_temperature(report.conditions, report.readings.stops)
    return {
        "words": words,
        "say": words.say,
        "model": report.model,
        "validation": found,
        "verdict": verdict_sentence(found),
        "decision": decision_sentence(found),
        "remarks": report.remarks,
        "turns_rows": turns_rows(found, words),
        "front": front_page(validation_front(found, report.model.robot.name, words), conditions, words),
        "imprint": imprint_of(report.model.robot.name, conditions, words),
        "seen": seen_by(shown),
        "distances_seen": _distances_seen(found),
        "simulated": conditions.simulated,
        "histogram": histogram(shown, found.position.identified.noise_mm, words),
        "distances": None
        if found.distance_errors is None
        else distance_histogram(found.distance_errors, words),
        "places": _drawn(found.places, words),
        "pose_test": test,
        "drift": _drift(test, words),
        "drift_sentences": () if test is None else tuple(map(words.spoken, drift_sentences(test))),
        "withheld": () if test is None else tuple(withheld_sentences(test, words)),
        "pose_rows": () if test is None else tuple(pose_test_rows(test, words)),
        "pose_cards": () if test is None else tuple(pose_test_cards(test, words)),
        "caution": "" if test is None else words.spoken(pose_test_caution(test)),
        **_traced(report, words),
        "conditions": conditions,
        "condition_rows": stated_conditions(test, conditions, words),
        **observability_context(report.model.parameters, (), words),
        "deciding": deciding_budget(shown, report.model, found.decision, conditions),
    }


def _distances_seen(found: Validation) -> Sentence | None:
    if found.distance_errors is None or found.distance is None:
        return None
    signed = found.distance_errors.identified
    return distances_sentence(signed.mean_mm, signed.positive_share, found.distance.identified.n)


def _traced(report: ValidationInput, words: Catalogue) -> dict[str, object]:
    if report.audit is None:
        return {"traced": None}
    traced = Traced(report.model.robot.name, report.conditions, report.audit)
    return {"traced": traced, **traced_context(traced, words)}


def _drift(test: PoseTest | None, words: Catalogue) -> object:
    return None if test is None or test.drift is None else drift_figure(test.drift, words)


def _drawn(places: ErrorsByPlace | None, words: Catalogue) -> object:
    return None if places is None else place_errors(places, words)
