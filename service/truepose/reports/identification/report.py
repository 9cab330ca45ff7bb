"""The report of an identification: for the operator, the metrologist and the archive."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from truepose.domain.campaign import Campaign, Stops
from truepose.domain.identification import Identification
from truepose.domain.set_aside import listed
from truepose.identification.verdict.judge import Assessment
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Text
from truepose.reports.captions import figure_captions
from truepose.reports.cover_page import Front, error_bars, graded
from truepose.reports.error_tables import error_table, figures_row, turns_table
from truepose.reports.figures.curves import reach_figure
from truepose.reports.figures.error_maps import work_space
from truepose.reports.figures.histograms import histogram
from truepose.reports.figures.joint_residuals import joint_residuals
from truepose.reports.identification.headline import Headline, headline
from truepose.reports.identification.judged_figures import (
    FAR_OUT,
    figures_table,
    judged,
    noise_split,
    shown_noise_mm,
)
from truepose.reports.identification.observability import (
    correlation_map,
    observability_context,
    strongest_pairs,
)
from truepose.reports.identification.parameters import parameter_rows
from truepose.reports.identification.summary import Truth, truth_table
from truepose.reports.report import Description, Report
from truepose.reports.traceability import condition_rows, with_temperature
from truepose.reports.uncertainty_budget import DRAWS, budget
from truepose.validation.outcome import outcome_of
from truepose.validation.validate import distance_from_axis_1


@dataclass(frozen=True, slots=True)
class DiagnosisLink:
    """Where the report of a diagnosis of the same readings lies, and its first line."""

    href: str  # relative to the report that links it
    message: Text


@dataclass(frozen=True, slots=True)
class IdentificationReport(Report):
    """An identification with the campaign that it was made from; where nothing was fitted it says why."""

    identification: Identification
    campaign: Campaign
    truth: Truth | None = None
    diagnosis: DiagnosisLink | None = None

    @property
    def simulated(self) -> bool:
        """Whether its readings come from simulated devices."""
        return self.conditions.simulated or bool(self.campaign.simulated)

    def described(self, words: Catalogue) -> Description:
        """Return headline, figures, evidence, budget and parameters.

        Raises
        ------
        ConfigurationError
            The campaign is not the one that the identification was made from.
        """
        identification, campaign = self.identification, self.campaign
        conditions = with_temperature(self.conditions, _all_stops(campaign))
        shown = judged(identification, campaign)
        uncertainties = None if shown is None else budget(shown, identification, campaign, conditions)
        found = headline(identification, shown, uncertainties, words)
        filled_in = {
            "identification": identification,
            "campaign": campaign,
            "conditions": conditions,
            "condition_rows": tuple(condition_rows(conditions, words)),
            "headline": found,
            "errors": figures_table(identification, words, shown),
            "turns": turns_table(identification, words),
            "far_out": FAR_OUT,
            "budget": uncertainties,
            "draws": DRAWS,
            "parameters": parameter_rows(identification, campaign, words),
            "diagnosis": self.diagnosis,
            "set_aside": listed(identification.set_aside),
            **_truth(self.truth, words),
            **_evidence(shown, identification, words),
            **_correlation(identification, words),
            **observability_context(identification.parameters, identification.not_identifiable, words),
        }
        front = identification_front(identification, campaign.robot.name, found, words)
        return Description(front.title, front.robot, "identification.html", filled_in, front)


def identification_front(
    identification: Identification, robot: str, found: Headline, words: Catalogue
) -> Front:
    """Return whether the model may be used, and what it makes of the robot."""
    pair = identification.judging
    after = next((one for one in found.figures if one.name == words.say("headline.mean_after")), None)
    return Front(
        title=words.say("identification.title", robot=robot),
        look=graded(found.good),
        word=words.say("front.usable" if found.good else "front.unusable"),
        outcome=words.spoken(outcome_of(identification)),
        sentence=found.sentence,
        robot=robot,
        figure=after,
        picture=None if pair is None else error_bars(pair.nominal, pair.identified, words),
        caption=words.say("front.bars") if pair is not None else "",
        rule=words.say("front.by_validation"),
    )


def _truth(truth: Truth | None, words: Catalogue) -> dict[str, object]:
    """Return how far the errors and the parameters are from what a simulator knows."""
    if truth is None:
        return {"truth": None}
    rows = (figures_row(words.spoken(label), "", errors) for label, errors in truth.errors)
    errors = error_table(rows, words).of_columns(0, 2, 3, 4, 5, 6)
    return {"truth": truth, "true_errors": errors, "true_parameters": truth_table(truth.parameters, words)}


def _all_stops(campaign: Campaign) -> Iterator[Stops]:
    points, legs = (campaign.calibration, campaign.validation), (campaign.legs, campaign.validation_legs)
    for table in (*points, *legs, campaign.contacts, campaign.validation_contacts):
        if table is not None:
            yield table.stops


def _evidence(
    shown: Assessment | None, identification: Identification, words: Catalogue
) -> dict[str, object]:
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
        "seen": figure_captions(shown),
        "joints": joint_residuals(shown, words),
        "space": work_space(shown, words),
        "splits": splits,
    }


def _correlation(identification: Identification, words: Catalogue) -> dict[str, object]:
    model = identification.model
    if model is None:
        return {"correlation": None, "strongest": ()}
    return {"correlation": correlation_map(model, words), "strongest": strongest_pairs(model)}
