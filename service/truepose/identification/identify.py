"""The identification of a campaign, from its readings to the answer: the one function that others call."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.campaign import Campaign, LegReadings, PointReadings
from truepose.domain.results import (
    Counts,
    Identification,
    Model,
    NominalAndIdentified,
    NotIdentifiable,
    PureError,
    Status,
)
from truepose.effects.registry import chosen_effects
from truepose.identification.fit.considered import considered
from truepose.identification.fit.cross_validation import held_out_residuals
from truepose.identification.fit.robust import RobustFit, fit, robust_fit
from truepose.identification.fit.solver import posterior_covariance
from truepose.identification.model.prediction import predict, predict_lengths, predict_nominal
from truepose.identification.model.stops import sites
from truepose.identification.models import Fits, model_of
from truepose.identification.observations.legs import leg_block
from truepose.identification.observations.positions import position_block
from truepose.identification.problem.build import (
    NOMINAL_EFFECTS,
    NUISANCE,
    Problem,
    automatic_effects,
    build,
)
from truepose.identification.verdict import status as verdict
from truepose.identification.verdict.identifiability import not_identifiable
from truepose.identification.verdict.lengths_by_positions import judged_by_positions
from truepose.identification.verdict.outliers import outliers
from truepose.identification.verdict.pure_error import pure_error
from truepose.identification.verdict.reach import WithinReach, within_reach
from truepose.identification.verdict.statistics import expected_noise_mm, statistics
from truepose.version import __version__

_MOVED_RAD = np.deg2rad(0.5)  # a joint that stays within this has not moved

Progress = Callable[[float, str], None]


def identify(
    campaign: Campaign, effects: tuple[str, ...] | list[str] | None = None, progress: Progress | None = None
) -> Identification:
    """Identify the robot of a campaign.

    Parameters
    ----------
    campaign : Campaign
    effects : sequence of str, optional
        Names of effects; None chooses base, tool as far as unknown, geometry, and compliance where
        masses or torques are known.
    progress : callable, optional
        Told the fraction done and what is being done.

    Returns
    -------
    Identification
        Whatever the status; `model` is None where nothing could be fitted.

    Raises
    ------
    UnknownEffectError, ConfigurationError
        The request cannot be understood.
    """
    tell = progress or _silent
    chosen = automatic_effects(campaign) if effects is None else chosen_effects(effects)
    tell(0.05, "placing the nominal robot")
    too_few = verdict.too_few_data(campaign, chosen)
    if too_few:
        return _unfitted(campaign, chosen, Status.TOO_FEW_DATA, too_few)
    reached = within_reach(campaign)
    campaign = reached.campaign
    problem = build(campaign, chosen)
    collapsed = verdict.before_fitting(campaign, problem)
    if collapsed:
        return _unfitted(campaign, chosen, Status.WRONG_NOMINAL_MODEL, collapsed)
    tell(0.2, "identifying")
    identified = robust_fit(problem.structure, problem.blocks, problem.start)
    nominal = nominal_fit(problem, identified)
    tell(0.5, "judging the model on configurations it has not seen")
    return _with_set_aside(_answer(campaign, problem, identified, nominal, tell), reached)


def _with_set_aside(answer: Identification, reached: WithinReach) -> Identification:
    """Return the answer with the readings that took no part in it, by their rows in the table."""
    outliers = reached.with_rows_of_table(answer.outliers)
    return replace(
        answer,
        message=f"{answer.message} {reached.sentence}".rstrip(),
        outliers=outliers,
        counts=replace(answer.counts, outliers=len(outliers)),
    )


def _silent(_fraction: float, _doing: str) -> None:
    return None


def nominal_fit(problem: Problem, identified: RobustFit) -> RobustFit:
    """Nominal robot with only base and unknown nests fitted, without the readings found gross."""
    left = tuple(name for name in problem.structure.effects if name not in NOMINAL_EFFECTS)
    structure = problem.structure.without(left)
    blocks = tuple(
        block.weighted(np.where(flags, 0.0, 1.0), block.discrepancy)
        for block, flags in zip(identified.blocks, identified.gross, strict=True)
    )
    start = np.array([problem.start[problem.structure.index_of(name)] for name in structure.names])
    solution = fit(structure, blocks, start)
    return RobustFit(structure, blocks, solution, identified.gross, float("nan"))


@dataclass(frozen=True, slots=True)
class _HeldOut:
    """Residuals of readings that the parameters never saw."""

    statistics: NominalAndIdentified
    residual_mm: FloatArray  # (n, d) identified
    parameter_variance_mm2: FloatArray  # (n,)
    noise_variance_mm2: FloatArray  # (n,) readings and scatter


def _answer(
    campaign: Campaign, problem: Problem, identified: RobustFit, nominal: RobustFit, tell: Progress
) -> Identification:
    carried = considered(campaign, identified)
    fits = Fits(campaign, identified, nominal, carried.total)
    draft = model_of(fits, discrepancy_mm=0.0, program_version=__version__)
    # Held-out readings share certificates and registration with those of the fit: that part of the
    # uncertainty cannot show in their residuals.
    validation = _validation(campaign, replace(draft, covariance=carried.readings))
    crossed = None if validation else _crossed(identified, nominal)
    held_out = validation or crossed
    model = (
        draft if held_out is None else replace(draft, discrepancy_mm=_discrepancy_mm(held_out, identified))
    )
    tell(0.9, "naming what the data leave open")
    gross = outliers(identified)
    status, message = verdict.judge(campaign, problem, identified, nominal)
    # Where nothing fits, the covariance speaks of the misfit, not of what the configurations can see.
    trusted = status in (Status.CONVERGED, Status.NOT_CONVERGED)
    named = _not_identifiable(problem, identified) if trusted else ()
    kept = ~identified.gross[0]
    return Identification(
        status=status,
        message=message,
        effects=tuple(name for name in problem.structure.effects if name not in NUISANCE),
        counts=_counts(problem, identified, len(gross)),
        parameters=model.parameters,
        not_identifiable=named,
        outliers=gross,
        quantity=problem.quantity,
        calibration=_pair(nominal, identified, np.ones(len(kept), dtype=bool)),
        validation=validation.statistics if validation else None,
        cross_validation=crossed.statistics if crossed else None,
        calibration_without_outliers=_pair(nominal, identified, kept) if gross else None,
        chi2_per_dof=identified.chi2_per_dof,
        pure_error=_pure_error(identified),
        model=model,
        positions=judged_by_positions(campaign, model) if problem.quantity == "length" else None,
    )


def _counts(problem: Problem, identified: RobustFit, outliers_found: int) -> Counts:
    sizes = [result.residual.size for result in identified.results]
    return Counts(
        configurations=len(np.unique(sites(problem.blocks[0].targets.stops))),
        observations=int(sum(sizes)),
        parameters=len(problem.structure.specs),
        outliers=outliers_found,
    )


def _pair(nominal: RobustFit, identified: RobustFit, rows: BoolArray) -> NominalAndIdentified:
    noise = expected_noise_mm(identified.blocks[0].taken(np.flatnonzero(rows)))
    return NominalAndIdentified(
        statistics(nominal.results[0].residual[rows], noise),
        statistics(identified.results[0].residual[rows], noise),
    )


def _validation(campaign: Campaign, model: Model) -> _HeldOut | None:
    if campaign.calibration is not None:
        return _point_validation(campaign, model, campaign.validation)
    return _leg_validation(campaign, model, campaign.validation_legs)


def _point_validation(campaign: Campaign, model: Model, points: PointReadings | None) -> _HeldOut | None:
    if points is None or len(points) == 0:
        return None
    block = position_block(points, campaign.scatter_mm)
    noise = expected_noise_mm(block)
    predicted, uncertainty = predict(replace(model, repeatability_mm=0.0), points.stops, points.nest)
    residual = points.position_mm - predicted
    nominal = points.position_mm - predict_nominal(model, points.stops, points.nest)
    pair = NominalAndIdentified(statistics(nominal, noise), statistics(residual, noise))
    return _HeldOut(pair, residual, uncertainty**2, block.component_variance() + block.scatter_mm**2)


def _leg_validation(campaign: Campaign, model: Model, legs: LegReadings | None) -> _HeldOut | None:
    if legs is None or len(legs) == 0:
        return None
    anchors = tuple(sorted(set(zip(legs.placement.tolist(), legs.base_point.tolist(), strict=True))))
    block = leg_block(legs, campaign.scatter_mm, anchors)
    noise = expected_noise_mm(block)
    residual = (legs.length_mm - predict_lengths(model, legs))[:, None]
    nominal = (legs.length_mm - predict_lengths(model, legs, nominal=True))[:, None]
    pair = NominalAndIdentified(statistics(nominal, noise), statistics(residual, noise))
    return _HeldOut(pair, residual, np.zeros(len(legs)), block.component_variance() + block.scatter_mm**2)


def _crossed(identified: RobustFit, nominal: RobustFit) -> _HeldOut | None:
    if len(np.unique(sites(identified.blocks[0].targets.stops))) < 2:
        return None  # revisits of one place: nothing is left to predict it from
    residual, variance = held_out_residuals(identified)
    before, _ = held_out_residuals(nominal)
    stated = identified.blocks[0].weighted(identified.blocks[0].weights, 0.0)
    noise = expected_noise_mm(stated)
    pair = NominalAndIdentified(statistics(before, noise), statistics(residual, noise))
    return _HeldOut(pair, residual, variance, stated.component_variance() + stated.scatter_mm**2)


def _discrepancy_mm(held_out: _HeldOut, identified: RobustFit) -> float:
    """Return what held-out residuals show per axis beyond noise, scatter and the parameters' share [mm].

    Readings as far out as those found gross do not count: they say nothing of the model.
    """
    squared = (held_out.residual_mm**2).mean(axis=1)
    typical = float(np.median(squared))
    usual = squared <= 25.0 * typical
    expected = held_out.noise_variance_mm2 + held_out.parameter_variance_mm2
    return float(np.sqrt(max(float((squared - expected)[usual].mean()), 0.0)))


def _pure_error(identified: RobustFit) -> PureError | None:
    return pure_error(identified.blocks[0], identified.results[0].residual, len(identified.structure.specs))


def _not_identifiable(problem: Problem, identified: RobustFit) -> tuple[NotIdentifiable, ...]:
    jacobian = identified.solution.final.jacobian
    covariance = posterior_covariance(jacobian, 1.0 / problem.structure.prior_widths**2)
    stops = problem.blocks[0].targets.stops
    moved = np.ptp(stops.joints_rad, axis=0) > _MOVED_RAD
    return not_identifiable(problem.structure, covariance, jacobian, problem.setting, moved)


def _unfitted(campaign: Campaign, effects: tuple[str, ...], status: Status, message: str) -> Identification:
    readings = campaign.readings
    observations = 0 if readings is None else readings.observed_mm.size
    configurations = 0 if readings is None else len(np.unique(readings.stops.config))
    return Identification(
        status=status,
        message=message,
        effects=effects,
        counts=Counts(configurations, observations, 0, 0),
        parameters=(),
        not_identifiable=(),
        outliers=(),
        quantity="length" if readings is None else readings.quantity,
        calibration=None,
        validation=None,
        cross_validation=None,
        calibration_without_outliers=None,
        chi2_per_dof=float("nan"),
        pure_error=None,
        model=None,
    )
