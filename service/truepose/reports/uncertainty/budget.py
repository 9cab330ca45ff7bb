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
from truepose.domain.campaign import Campaign
from truepose.domain.results import Identification, Model, NominalAndIdentified, Statistics
from truepose.identification.fit.considered import world_registration
from truepose.identification.model.stops import sites
from truepose.identification.verdict.judge import Judged
from truepose.kinematics.frames import placement_translation
from truepose.reports.conditions import ReportConditions
from truepose.reports.rounding import uncertainty
from truepose.reports.uncertainty.judged import judging_figures
from truepose.reports.uncertainty.shifts import (
    growth,
    motion_shifts,
    nest_shifts,
    parameter_shifts,
    spread_of_mean_mm,
)

_EXPANSION_PER_K = 23e-6  # aluminium, of which arms of this size are cast; steel would be half of it


@dataclass(frozen=True, slots=True)
class Contribution:
    """One row of the budget; None where the source does not act on that figure or is contained elsewhere."""

    source: str
    kind: Literal["A", "B"]
    stated: str
    before_mm: float | None = None
    after_mm: float | None = None
    remark: str = ""


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
        "Finite number of configurations",
        "A",
        f"{n:,} configurations",
        _standard_error(judged, judged.nominal_mm, figures.nominal),
        _standard_error(judged, judged.identified_mm, figures.identified),
        "standard error of the mean, by configuration: its readings and revisits share its error",
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
        "Identified parameters",
        "A",
        f"covariance of {len(model.parameters)} parameters",
        None,
        spread_of_mean_mm(judged.identified_mm, shifts),
        "what another calibration of the same size would change",
    )


def _acting(source: str, stated: str, judged: Judged, shifts: FloatArray, remark: str = "") -> Contribution:
    """Return the row of a systematic source that acts on both figures."""
    before = spread_of_mean_mm(judged.nominal_mm, shifts)
    after = spread_of_mean_mm(judged.identified_mm, shifts)
    return Contribution(source, "B", stated, before, after, remark)


def _instrument(judged: Judged) -> Contribution:
    per_axis = float(
        np.sqrt(np.trace(judged.block.covariance(), axis1=1, axis2=2).mean() / judged.block.components)
    )
    what = "per length" if judged.block.quantity == "length" else "per axis"
    remark = "random from reading to reading: contained in the standard error"
    return Contribution("Instrument, noise", "B", f"u = {uncertainty(per_axis)} mm {what}", remark=remark)


def _scatter(judged: Judged, model: Model, campaign: Campaign) -> Contribution:
    if campaign.repeatability_in_uncertainty:
        return Contribution(
            "Robot, scatter", "B", "within the stated uncertainty", remark="as the campaign says"
        )
    if judged.block.scatter_mm == 0.0:
        return Contribution("Robot, scatter", "B", "not stated", remark="contained in the standard error")
    stated = f"u = {uncertainty(model.repeatability_mm)} mm per axis"
    return Contribution("Robot, scatter", "B", stated, remark="contained in the standard error")


def _nests(judged: Judged, model: Model, campaign: Campaign) -> Contribution:
    known = [
        (number, nest.standard_uncertainty_mm)
        for number, nest in enumerate(campaign.nests, start=1)
        if nest.centre_mm is not None and nest.standard_uncertainty_mm
    ]
    if not known:
        return Contribution(
            "Certified tool nests", "B", "not stated", remark="none is certified with an uncertainty"
        )
    stated = f"u up to {uncertainty(max(u for _, u in known))} mm per axis"
    return _acting("Certified tool nests", stated, judged, nest_shifts(judged, model, known))


def _registration(judged: Judged, campaign: Campaign) -> Contribution:
    source = "Registration of the world frame"
    if judged.block.quantity == "length":
        return Contribution(source, "B", "does not act", remark="lengths need no world frame")
    registration = world_registration(campaign)
    if registration is None:
        remark = "not included: errors are those in the instrument's own frame"
        return Contribution(source, "B", "not stated", remark=remark)
    translation = np.sqrt(np.trace(registration.covariance[:3, :3]) / 3.0)
    stated = f"u = {uncertainty(float(translation))} mm per axis at the origin"
    return _acting(source, stated, judged, motion_shifts(judged, registration.covariance))


def _scale(judged: Judged, model: Model, conditions: ReportConditions) -> Contribution:
    source, relative = "Scale of the instrument", conditions.scale_standard_uncertainty
    if relative is None:
        remark = "not included: U is that of lengths in the instrument's own scale"
        return Contribution(source, "B", "scale not verified", remark=remark)
    origin = model.instrument_mm if model.instrument_mm is not None else (0.0, 0.0, 0.0)
    shifts = relative * growth(judged, np.array(origin))
    return _acting(source, f"relative u = {uncertainty(relative)}", judged, shifts)


def _temperature(judged: Judged, model: Model, conditions: ReportConditions) -> Contribution:
    source = "Temperature of the arm"
    if conditions.temperature_c is None:
        return Contribution(source, "B", "not stated", remark="not included")
    half_k = (conditions.temperature_c[1] - conditions.temperature_c[0]) / 2.0
    relative = _EXPANSION_PER_K * half_k / float(np.sqrt(3.0))  # rectangular, GUM 4.3.7
    shifts = relative * growth(judged, placement_translation(model.base))
    remark = f"all lengths grow by {_EXPANSION_PER_K * 1e6:.0f}e-6 per K (aluminium, assumed)"
    return _acting(source, f"± {half_k:.1f} K, rectangular", judged, shifts, remark)
