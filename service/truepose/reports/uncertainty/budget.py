"""Uncertainty budget of the two headline figures: the mean error before and after identification.

The figure is the mean norm of the residuals of the judged readings, taken for the mean error of the arm
in the world. Evaluation after GUM (JCGM 100:2008), type A from the scatter of the figures themselves,
type B from certificates and statements. A mean of norms is not linear in what shifts it: where errors
point everywhere its first derivative nearly vanishes. Each systematic source is therefore carried by
Monte Carlo (JCGM 101:2008) with a fixed seed.
"""

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Campaign
from truepose.domain.results.identification import Identification, Model, NominalAndIdentified, Statistics
from truepose.domain.sentences import Sentence, Text, said
from truepose.identification.fit.considered import world_registration
from truepose.identification.model.stops import sites
from truepose.identification.verdict.judge import Judged
from truepose.kinematics.frames import placement_translation
from truepose.reports.traceability.conditions import NOT_STATED, ReportConditions
from truepose.reports.uncertainty.judged import judging_figures
from truepose.reports.uncertainty.shifts import (
    growth,
    motion_shifts,
    nest_shifts,
    parameter_shifts,
    spread_of_mean_mm,
)
from truepose.reports.wording.rounding import uncertainty

_EXPANSION_PER_K = 23e-6  # aluminium, of which arms of this size are cast; steel would be half of it


@dataclass(frozen=True, slots=True)
class Contribution:
    """One row of the budget; None where the source does not act on that figure or is contained elsewhere."""

    source: Sentence
    kind: Literal["A", "B"]
    stated: Sentence
    before_mm: float | None = None
    after_mm: float | None = None
    remark: Text = ""


@dataclass(frozen=True, slots=True)
class Budget:
    """The rows and their combination."""

    contributions: tuple[Contribution, ...]

    @property
    def before_mm(self) -> float:
        """Combined standard uncertainty of the mean error before; NaN where a part is unknown."""
        return _combined([row.before_mm for row in self.contributions])

    @property
    def after_mm(self) -> float:
        """Combined standard uncertainty of the mean error after; NaN where a part is unknown."""
        return _combined([row.after_mm for row in self.contributions])


def _combined(parts_mm: list[float | None]) -> float:
    return float(np.sqrt(sum(part**2 for part in parts_mm if part is not None)))


def budget(
    judged: Judged, identification: Identification, campaign: Campaign, conditions: ReportConditions
) -> Budget | None:
    """Return the budget of the mean errors in the headline; None where nothing was fitted."""
    model, figures = identification.model, judging_figures(identification)
    if model is None or figures is None:
        return None
    rows = (
        _sampling(judged, figures),
        _parameters(judged, model),
        _instrument(judged),
        _scatter(judged, model, campaign),
        _nests(judged, model, campaign),
        _registration(judged, campaign),
        _scale(judged, model, conditions),
        _temperature(judged, model, conditions),
    )
    return Budget(rows)


def _sampling(judged: Judged, figures: NominalAndIdentified) -> Contribution:
    n = len(np.unique(sites(judged.stops)))
    return Contribution(
        said("budget.configurations"),
        "A",
        said("budget.configurations.stated", configurations=n),
        _standard_error(judged, judged.nominal_mm, figures.nominal),
        _standard_error(judged, judged.identified_mm, figures.identified),
        said("budget.configurations.remark"),
    )


def _standard_error(judged: Judged, residual_mm: FloatArray, figures: Statistics) -> float:
    """Return the standard error of the mean norm; NaN from a single configuration, which tells no scatter."""
    norms = np.linalg.norm(residual_mm, axis=1)
    _, group, sizes = np.unique(sites(judged.stops), return_inverse=True, return_counts=True)
    if len(sizes) < 2:
        return math.nan
    # Clusters of unequal size: the ratio estimator's variance, W. G. Cochran, Sampling Techniques, 1977, 6.4.
    totals = np.bincount(group.ravel(), norms - norms.mean())
    error = float(np.sqrt((totals**2).sum() * len(sizes) / (len(sizes) - 1)) / sizes.sum())
    # Cross-validated errors scatter more than the calibration's, which are all that is at hand then.
    spread = float(norms.std(ddof=1))
    return error * figures.sd_mm / spread if spread > 0.0 else error


def _parameters(judged: Judged, model: Model) -> Contribution:
    shifts = parameter_shifts(judged, model)
    return Contribution(
        said("budget.parameters"),
        "A",
        said("budget.parameters.stated", parameters=len(model.parameters)),
        None,
        spread_of_mean_mm(judged.identified_mm, shifts),
        said("budget.parameters.remark"),
    )


def _acting(
    source: Sentence, stated: Sentence, judged: Judged, shifts: FloatArray, remark: Text = ""
) -> Contribution:
    """Return the row of a systematic source that acts on both figures."""
    before = spread_of_mean_mm(judged.nominal_mm, shifts)
    after = spread_of_mean_mm(judged.identified_mm, shifts)
    return Contribution(source, "B", stated, before, after, remark)


def _instrument(judged: Judged) -> Contribution:
    per_axis = float(
        np.sqrt(np.trace(judged.block.covariance(), axis1=1, axis2=2).mean() / judged.block.components)
    )
    key = "budget.u_per_length" if judged.block.quantity == "length" else "budget.u_per_axis"
    stated, remark = said(key, u=uncertainty(per_axis)), said("budget.instrument.remark")
    return Contribution(said("budget.instrument"), "B", stated, remark=remark)


def _scatter(judged: Judged, model: Model, campaign: Campaign) -> Contribution:
    source, contained = said("budget.scatter"), said("budget.contained")
    if campaign.repeatability_in_uncertainty:
        stated = said("budget.scatter.within")
        return Contribution(source, "B", stated, remark=said("budget.scatter.as_stated"))
    if judged.block.scatter_mm == 0.0:
        return Contribution(source, "B", said(NOT_STATED), remark=contained)
    stated = said("budget.u_per_axis", u=uncertainty(model.repeatability_mm))
    return Contribution(source, "B", stated, remark=contained)


def _nests(judged: Judged, model: Model, campaign: Campaign) -> Contribution:
    known = [
        (number, nest.standard_uncertainty_mm)
        for number, nest in enumerate(campaign.nests, start=1)
        if nest.centre_mm is not None and nest.standard_uncertainty_mm
    ]
    source = said("budget.nests")
    if not known:
        return Contribution(source, "B", said(NOT_STATED), remark=said("budget.nests.none"))
    stated = said("budget.nests.stated", u=uncertainty(max(u for _, u in known)))
    return _acting(source, stated, judged, nest_shifts(judged, model, known))


def _registration(judged: Judged, campaign: Campaign) -> Contribution:
    source = said("budget.registration")
    if judged.block.quantity == "length":
        idle = said("budget.registration.does_not_act")
        return Contribution(source, "B", idle, remark=said("budget.registration.lengths"))
    registration = world_registration(campaign)
    if registration is None:
        remark = said("budget.registration.not_included")
        return Contribution(source, "B", said(NOT_STATED), remark=remark)
    translation = np.sqrt(np.trace(registration.covariance[:3, :3]) / 3.0)
    stated = said("budget.registration.stated", u=uncertainty(float(translation)))
    return _acting(source, stated, judged, motion_shifts(judged, registration.covariance))


def _scale(judged: Judged, model: Model, conditions: ReportConditions) -> Contribution:
    source, relative = said("budget.scale"), conditions.scale_standard_uncertainty
    if relative is None:
        unverified = said("budget.scale.not_verified")
        return Contribution(source, "B", unverified, remark=said("budget.scale.not_included"))
    origin = model.instrument_mm if model.instrument_mm is not None else (0.0, 0.0, 0.0)
    shifts = relative * growth(judged, np.array(origin))
    return _acting(source, said("budget.scale.stated", u=uncertainty(relative)), judged, shifts)


def _temperature(judged: Judged, model: Model, conditions: ReportConditions) -> Contribution:
    source = said("budget.temperature")
    if conditions.temperature_c is None:
        return Contribution(source, "B", said(NOT_STATED), remark=said("budget.temperature.not_included"))
    half_k = (conditions.temperature_c[1] - conditions.temperature_c[0]) / 2.0
    relative = _EXPANSION_PER_K * half_k / float(np.sqrt(3.0))  # rectangular, GUM 4.3.7
    shifts = relative * growth(judged, placement_translation(model.base))
    remark = said("budget.temperature.remark", per_million=_EXPANSION_PER_K * 1e6)
    stated = said("budget.temperature.stated", half_k=half_k)
    return _acting(source, stated, judged, shifts, remark)
