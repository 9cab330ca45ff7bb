"""The report of an identification: one HTML file for the operator, the metrologist and the archive."""

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
from markupsafe import Markup

from truepose.domain.measurement.campaign import Campaign, Stops
from truepose.domain.results.identification import Identification
from truepose.domain.sentences import Text
from truepose.identification.verdict.judge import Judged
from truepose.judgement.places import distance_from_axis_1
from truepose.reports.figures.curves.joint_residuals import joint_residuals
from truepose.reports.figures.histograms.errors import histogram
from truepose.reports.figures.maps.correlation import correlation_map, strongest_pairs
from truepose.reports.figures.maps.work_space import work_space
from truepose.reports.figures.reach import reach_figure
from truepose.reports.figures_rows import figures_rows
from truepose.reports.front.kinds import identification_front
from truepose.reports.front.page import front_page
from truepose.reports.headline import headline
from truepose.reports.observability.shown import observability_context
from truepose.reports.pages import rendered
from truepose.reports.paper import write_report_text
from truepose.reports.parameters.rows import parameter_rows
from truepose.reports.seen.judged import seen_by
from truepose.reports.traceability.conditions import ReportConditions, condition_rows, temperature_range
from truepose.reports.traceability.imprint import imprint_of
from truepose.reports.truth import Truth, truth_row
from truepose.reports.uncertainty.budget import Budget, budget
from truepose.reports.uncertainty.judged import FAR_OUT, judged, noise_split, shown_noise_mm
from truepose.reports.uncertainty.shifts import DRAWS
from truepose.reports.wording.turns import turns_rows
from truepose.words.catalogue import ENGLISH, Catalogue, catalogue


@dataclass(frozen=True, slots=True)
class DiagnosisLink:
    """Where the report of a diagnosis of the same readings lies, and its first line."""

    href: str  # relative to the report that links it
    message: Text


@dataclass(frozen=True, slots=True)
class ReportInput:
    """What a report is made from; only the identification and its campaign are needed."""

    identification: Identification
    campaign: Campaign
    conditions: ReportConditions = field(default_factory=ReportConditions)
    truth: Truth | None = None
    diagnosis: DiagnosisLink | None = None
    language: str = ENGLISH  # one of `LANGUAGES`


def write_identification_report(path: Path, report: ReportInput) -> None:
    """Write the report of an identification as one self-contained HTML file.

    Whatever the status: where nothing was fitted the report says why and has no figures.

    Parameters
    ----------
    path : Path
        Replaced where it exists; its folder is made.
    report : ReportInput

    Raises
    ------
    UnwritableReportError
        The file cannot be written.
    ConfigurationError
        The campaign is not the one that the identification was made from.
    """
    write_report_text(path, identification_page(report))


def identification_page(report: ReportInput) -> Markup:
    """Return the report as one self-contained page."""
    return rendered("identification.html", **_context(report))


def _context(report: ReportInput) -> dict[str, object]:
    identification, campaign, words = report.identification, report.campaign, catalogue(report.language)
    conditions = _with_temperature(report.conditions, campaign)
    shown = judged(identification, campaign)
    uncertainties = _budget(shown, identification, campaign, conditions)
    found = headline(identification, shown, uncertainties, words)
    robot = campaign.robot.name
    return dict(
        front=front_page(identification_front(identification, robot, found, words), conditions, words),
        words=words,
        say=words.say,
        identification=identification,
        campaign=campaign,
        conditions=conditions,
        condition_rows=tuple(condition_rows(conditions, words)),
        imprint=imprint_of(robot, conditions, words),
        simulated=conditions.simulated or bool(campaign.simulated),
        headline=found,
        figures_rows=tuple(figures_rows(identification, shown)),
        turns_rows=turns_rows(identification, words),
        far_out=FAR_OUT,
        budget=uncertainties,
        draws=DRAWS,
        parameters=parameter_rows(identification, campaign, words),
        truth=report.truth,
        diagnosis=report.diagnosis,
        truth_rows=()
        if report.truth is None
        else tuple(truth_row(p, words) for p in report.truth.parameters),
        **_evidence(shown, identification, words),
        **_correlation(identification, words),
        **observability_context(identification.parameters, identification.not_identifiable, words),
    )


def _with_temperature(conditions: ReportConditions, campaign: Campaign) -> ReportConditions:
    """Take the range of the readings where nobody stated one."""
    if conditions.temperature_c is not None:
        return conditions
    return replace(conditions, temperature_c=temperature_range(_all_stops(campaign)))


def _all_stops(campaign: Campaign) -> Iterator[Stops]:
    points, legs = (campaign.calibration, campaign.validation), (campaign.legs, campaign.validation_legs)
    for table in (*points, *legs, campaign.contacts, campaign.validation_contacts):
        if table is not None:
            yield table.stops


def _budget(
    shown: Judged | None, identification: Identification, campaign: Campaign, conditions: ReportConditions
) -> Budget | None:
    return None if shown is None else budget(shown, identification, campaign, conditions)


def _evidence(shown: Judged | None, identification: Identification, words: Catalogue) -> dict[str, object]:
    """Return the figures drawn from residuals; all None where there are none."""
    model = identification.model
    if shown is None or model is None:
        return dict.fromkeys(("judged", "histogram", "joints", "reach", "seen", "space", "splits"))
    splits = (
        ("before", noise_split(shown, shown.nominal_mm)),
        ("after", noise_split(shown, shown.identified_mm)),
    )
    reach = distance_from_axis_1(shown.identified.state.chain)
    before, after = np.linalg.norm(shown.nominal_mm, axis=1), np.linalg.norm(shown.identified_mm, axis=1)
    return {
        "judged": shown,
        "histogram": histogram(shown, shown_noise_mm(identification), words),
        "reach": reach_figure(reach, before, after, words),
        "seen": seen_by(shown),
        "joints": joint_residuals(shown, words),
        "space": work_space(shown, words),
        "splits": splits,
    }


def _correlation(identification: Identification, words: Catalogue) -> dict[str, object]:
    model = identification.model
    if model is None:
        return {"correlation": None, "strongest": ()}
    return {"correlation": correlation_map(model, words), "strongest": strongest_pairs(model)}
