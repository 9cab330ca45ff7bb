"""Uncertainty budget of the two headline figures: the mean error before and after identification.

The figure is the mean norm of the residuals of the judged readings, taken for the mean error of the arm
in the world. Evaluation after GUM (JCGM 100:2008), type A from the scatter of the figures themselves,
type B from certificates and statements. A mean of norms is not linear in what shifts it: where errors
point everywhere its first derivative nearly vanishes. Each systematic source is therefore carried by
Monte Carlo (JCGM 101:2008) with a fixed seed.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, sites
from truepose.domain.identification import Identification, Model, NominalAndIdentified, Statistics
from truepose.identification.fit.assessment import world_registration
from truepose.identification.model.estimates import identified_estimate
from truepose.identification.verdict.judge import Assessment
from truepose.kinematics.frames import placement_translation
from truepose.messages.message import Message, Text, message
from truepose.reports.rounding import uncertainty
from truepose.reports.traceability import NOT_STATED, ReportConditions

DRAWS = 1000  # standard deviation of a standard deviation: 1 / sqrt(2 * 1000) = 2.2 %
_DRAWS_AT_ONCE = 50
_SEED = 20081001  # any fixed one: the same data give the same report


def parameter_shifts(judged: Assessment, model: Model) -> FloatArray:
    """Return how predictions change per independent draw of the parameters, shape (P, n, d) [mm]."""
    width = np.sqrt(np.diag(model.covariance))
    used = np.flatnonzero(width > 0.0)
    here = _predicted(judged, model)
    steps = np.array([_predicted(judged, _moved(model, int(k), float(width[k]))) - here for k in used])
    correlation = model.covariance[np.ix_(used, used)] / np.outer(width[used], width[used])
    eigenvalues, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(np.maximum(eigenvalues, 0.0))
    return np.asarray(np.einsum("pk,pnd->knd", root, steps.reshape(len(used), *here.shape)))


def _predicted(judged: Assessment, model: Model) -> FloatArray:
    """Return what a model predicts of the judged readings, but for a constant, shape (n, d) [mm]."""
    moved = identified_estimate(model)
    return -judged.block.result(moved.structure, moved.values, None).residual


def _moved(model: Model, parameter: int, by: float) -> Model:
    parameters = list(model.parameters)
    parameters[parameter] = replace(parameters[parameter], value=parameters[parameter].value + by)
    return replace(model, parameters=tuple(parameters))


def spread_of_mean_mm(residual_mm: FloatArray, shifts: FloatArray) -> float:
    """Return the standard deviation of the mean norm when each source of `shifts` is drawn.

    Parameters
    ----------
    residual_mm : ndarray, shape (n, d)
    shifts : ndarray, shape (K, n, d)
        Change of the residuals per standard deviation of K independent sources [mm].

    Returns
    -------
    float
        In mm; 0 of no source. Drawn with a fixed seed, so that the same data give the same figure.
    """
    if len(shifts) == 0:
        return 0.0
    generator = np.random.default_rng(_SEED)
    flat = shifts.reshape(len(shifts), -1)
    means = []
    for _ in range(DRAWS // _DRAWS_AT_ONCE):
        drawn = (generator.standard_normal((_DRAWS_AT_ONCE, len(shifts))) @ flat).reshape(
            -1, *residual_mm.shape
        )
        means.append(np.linalg.norm(residual_mm + drawn, axis=2).mean(axis=1))
    return float(np.concatenate(means).std(ddof=1))


def nest_shifts(judged: Assessment, model: Model, known: Sequence[tuple[int, float]]) -> FloatArray:
    """Return how predictions change per draw of each coordinate of `known` (nest, u [mm]), (K, n, d) [mm]."""
    here = _predicted(judged, model)
    return np.array([
        _predicted(judged, _nest_moved(model, nest, axis, u_mm)) - here
        for nest, u_mm in known
        for axis in range(3)
    ])


def _nest_moved(model: Model, number: int, axis: int, by_mm: float) -> Model:
    def moved(centre_mm: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = (value + (by_mm if k == axis else 0.0) for k, value in enumerate(centre_mm))
        return x, y, z

    nests = tuple(
        replace(nest, centre_mm=moved(nest.centre_mm)) if nest.nest == number else nest
        for nest in model.nests
    )
    return replace(model, nests=nests)


def growth(judged: Assessment, origin_mm: FloatArray) -> FloatArray:
    """Return how observations change when all lengths from `origin_mm` grow by their own size, (1, n, d)."""
    return judged.block.moved_by_growth(judged.identified, origin_mm)[None]


def motion_shifts(judged: Assessment, covariance: FloatArray) -> FloatArray:
    """Return how positions change per independent small motion of the world, shape (6, n, 3) [mm].

    Parameters
    ----------
    judged : Assessment
        Of positions.
    covariance : ndarray, shape (6, 6)
        Of a translation [mm] and a rotation vector [rad] about the world's origin.
    """
    eigenvalues, vectors = np.linalg.eigh(covariance)
    root = (vectors * np.sqrt(np.maximum(eigenvalues, 0.0))).T  # one independent motion a row
    return np.tensordot(root, judged.block.moved_by_world(judged.identified), 1)


_EXPANSION_PER_K = 23e-6  # aluminium, of which arms of this size are cast; steel would be half of it


@dataclass(frozen=True, slots=True)
class Contribution:
    """One row of the budget; None where the source does not act on that figure or is contained elsewhere."""

    source: Message
    kind: Literal["A", "B"]
    stated: Message
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
    judged: Assessment,
    identification: Identification,
    campaign: Campaign,
    conditions: ReportConditions,
) -> Budget | None:
    """Return the budget of the mean errors in the headline; None where nothing was fitted."""
    model, figures = identification.model, identification.judging
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


def _sampling(judged: Assessment, figures: NominalAndIdentified) -> Contribution:
    n = len(np.unique(sites(judged.stops)))
    return Contribution(
        message("budget.configurations"),
        "A",
        message("budget.configurations.stated", configurations=n),
        _standard_error(judged, judged.nominal_mm, figures.nominal),
        _standard_error(judged, judged.identified_mm, figures.identified),
        message("budget.configurations.remark"),
    )


def _standard_error(judged: Assessment, residual_mm: FloatArray, figures: Statistics) -> float:
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


def _parameters(judged: Assessment, model: Model) -> Contribution:
    shifts = parameter_shifts(judged, model)
    return Contribution(
        message("budget.parameters"),
        "A",
        message("budget.parameters.stated", parameters=len(model.parameters)),
        None,
        spread_of_mean_mm(judged.identified_mm, shifts),
        message("budget.parameters.remark"),
    )


def _acting(
    source: Message, stated: Message, judged: Assessment, shifts: FloatArray, remark: Text = ""
) -> Contribution:
    """Return the row of a systematic source that acts on both figures."""
    before = spread_of_mean_mm(judged.nominal_mm, shifts)
    after = spread_of_mean_mm(judged.identified_mm, shifts)
    return Contribution(source, "B", stated, before, after, remark)


def _instrument(judged: Assessment) -> Contribution:
    per_axis = float(
        np.sqrt(np.trace(judged.block.covariance(), axis1=1, axis2=2).mean() / judged.block.components)
    )
    key = "budget.u_per_length" if judged.block.quantity == "length" else "budget.u_per_axis"
    stated, remark = message(key, u=uncertainty(per_axis)), message("budget.instrument.remark")
    return Contribution(message("budget.instrument"), "B", stated, remark=remark)


def _scatter(judged: Assessment, model: Model, campaign: Campaign) -> Contribution:
    source, contained = message("budget.scatter"), message("budget.contained")
    if campaign.repeatability_in_uncertainty:
        stated = message("budget.scatter.within")
        return Contribution(source, "B", stated, remark=message("budget.scatter.as_stated"))
    if judged.block.scatter_mm == 0.0:
        return Contribution(source, "B", message(NOT_STATED), remark=contained)
    stated = message("budget.u_per_axis", u=uncertainty(model.repeatability_mm))
    return Contribution(source, "B", stated, remark=contained)


def _nests(judged: Assessment, model: Model, campaign: Campaign) -> Contribution:
    known = [
        (number, nest.standard_uncertainty_mm)
        for number, nest in enumerate(campaign.nests, start=1)
        if nest.centre_mm is not None and nest.standard_uncertainty_mm
    ]
    source = message("budget.nests")
    if not known:
        return Contribution(source, "B", message(NOT_STATED), remark=message("budget.nests.none"))
    stated = message("budget.nests.stated", u=uncertainty(max(u for _, u in known)))
    return _acting(source, stated, judged, nest_shifts(judged, model, known))


def _registration(judged: Assessment, campaign: Campaign) -> Contribution:
    source = message("budget.registration")
    if judged.block.quantity == "length":
        idle = message("budget.registration.does_not_act")
        return Contribution(source, "B", idle, remark=message("budget.registration.lengths"))
    registration = world_registration(campaign)
    if registration is None:
        remark = message("budget.registration.not_included")
        return Contribution(source, "B", message(NOT_STATED), remark=remark)
    translation = np.sqrt(np.trace(registration.covariance[:3, :3]) / 3.0)
    stated = message("budget.registration.stated", u=uncertainty(float(translation)))
    return _acting(source, stated, judged, motion_shifts(judged, registration.covariance))


def scale_stated(conditions: ReportConditions) -> Message:
    """Return what is known of the scale of lengths."""
    relative = conditions.scale_standard_uncertainty
    if relative is None:
        return message("budget.scale.not_verified")
    return message("budget.scale.stated", u=uncertainty(relative))


def _scale(judged: Assessment, model: Model, conditions: ReportConditions) -> Contribution:
    source, stated = message("budget.scale"), scale_stated(conditions)
    relative = conditions.scale_standard_uncertainty
    if relative is None:
        return Contribution(source, "B", stated, remark=message("budget.scale.not_included"))
    origin = model.instrument_mm if model.instrument_mm is not None else (0.0, 0.0, 0.0)
    shifts = relative * growth(judged, np.array(origin))
    return _acting(source, stated, judged, shifts)


def _temperature(judged: Assessment, model: Model, conditions: ReportConditions) -> Contribution:
    source = message("budget.temperature")
    if conditions.temperature_c is None:
        return Contribution(
            source, "B", message(NOT_STATED), remark=message("budget.temperature.not_included")
        )
    half_k = (conditions.temperature_c[1] - conditions.temperature_c[0]) / 2.0
    relative = _EXPANSION_PER_K * half_k / float(np.sqrt(3.0))  # rectangular, GUM 4.3.7
    shifts = relative * growth(judged, placement_translation(model.base))
    remark = message("budget.temperature.remark", per_million=_EXPANSION_PER_K * 1e6)
    stated = message("budget.temperature.stated", half_k=half_k)
    return _acting(source, stated, judged, shifts, remark)
