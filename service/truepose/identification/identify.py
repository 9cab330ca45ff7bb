"""The identification of a campaign, from its readings to the answer: the one function that others call.

Enough data? -> readings out of reach set aside -> base, nests, cups and targets placed for the nominal robot
-> could any convention be wrong? -> robust fit of all parameters, and of base and nests alone around the
nominal robot -> certificates carried into the covariance -> held-out readings, else cross-validation -> what
the model lacks -> status and what is not identifiable.

All residuals are observation minus prediction. The discrepancy that a model states comes from readings that
it never saw; 0 where there are none.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from truepose.domain.arrays import distinct_values
from truepose.domain.campaign import Campaign, ReadingsSetAside, sites
from truepose.domain.identification import (
    Counts,
    Identification,
    Model,
    NotIdentifiable,
    PureError,
    Status,
)
from truepose.effects.ports import Trait
from truepose.effects.registry import chosen_effects, effects_with
from truepose.identification.fit.assessment import held_out_residuals, propagate_certificates
from truepose.identification.fit.inadequacy import shortfall
from truepose.identification.fit.robust import RobustFit, fit, robust_fit
from truepose.identification.fit.solver import absorbed, posterior_covariance
from truepose.identification.model.structure import NOMINAL_EFFECTS
from truepose.identification.model_of_fit import Fits, model_of
from truepose.identification.observations.joint_priors import QUANTITY as BELIEF
from truepose.identification.problem.build import (
    JointPrior,
    Problem,
    automatic_effects,
    build,
    with_belief,
)
from truepose.identification.verdict import status as verdict
from truepose.identification.verdict.identifiability import not_identifiable
from truepose.identification.verdict.judge import Assessment, judge, pure_error
from truepose.identification.verdict.outliers import (
    ReachableCampaign,
    outliers,
    with_set_aside,
    within_reach,
)
from truepose.identification.verdict.relative_accuracy import (
    judged_by_positions,
    relative_errors,
    turn_errors,
)
from truepose.messages.message import Text, message, together
from truepose.version import __version__

_MOVED_RAD = np.deg2rad(0.5)  # a joint that stays within this has not moved

Progress = Callable[[float, Text], None]


def identify(
    campaign: Campaign,
    effects: tuple[str, ...] | list[str] | None = None,
    progress: Progress | None = None,
    *,
    believed: JointPrior | None = None,
) -> Identification:
    """Identify the robot of a campaign.

    Parameters
    ----------
    campaign : Campaign
    effects : sequence of str, optional
        Names of effects; None chooses base, tool as far as unknown, geometry, and compliance where
        masses or torques are known.
    progress : callable, optional
        Told the fraction done, 0 to 1, and what is being done.
    believed : JointPrior, optional
        What robots of the type say of this one beforehand; its parameters are identified besides.

    Returns
    -------
    Identification
        Whatever the status; `model` is None where nothing could be fitted.

    Raises
    ------
    UnknownEffectError, ConfigurationError
        The request cannot be understood.
    """
    answer = _identified(campaign, effects, progress or _silent, believed)
    return answer if campaign.set_aside is None else _made_without(answer, campaign.set_aside)


def _made_without(answer: Identification, aside: ReadingsSetAside) -> Identification:
    """Return the answer with the readings that a person had set aside before, by their rows in the table."""
    return replace(
        answer,
        message=together(answer.message, aside.sentence),
        outliers=tuple(replace(one, row=aside.row_in_table(one.row)) for one in answer.outliers),
        set_aside=aside,
    )


def _identified(
    campaign: Campaign,
    effects: tuple[str, ...] | list[str] | None,
    tell: Progress,
    believed: JointPrior | None,
) -> Identification:
    chosen = automatic_effects(campaign) if effects is None else chosen_effects(effects)
    tell(0.05, message("job.doing.placing"))
    # Before anything is placed: a search among too few readings finds some place for anything.
    too_few = verdict.too_few_data(campaign, chosen)
    if too_few:
        return _unfitted(campaign, chosen, Status.TOO_FEW_DATA, too_few)
    reached = within_reach(campaign)
    campaign = reached.campaign
    problem = build(campaign, chosen)
    problem = problem if believed is None else with_belief(problem, believed)
    # A table or unit that is wrong is told before the fit, which would bend everything to it.
    collapsed = verdict.before_fitting(campaign, problem)
    if collapsed:
        return _unfitted(campaign, chosen, Status.WRONG_NOMINAL_MODEL, collapsed)
    tell(0.2, message("job.doing.identifying"))
    identified = robust_fit(problem.structure, problem.blocks, problem.start)
    nominal = nominal_fit(problem, identified)
    tell(0.5, message("job.doing.cross_validating"))
    return _with_set_aside(_answer(campaign, problem, identified, nominal, tell), reached)


def _with_set_aside(answer: Identification, reached: ReachableCampaign) -> Identification:
    """Return the answer with the readings that took no part in it, by their rows in the table."""
    # The fit numbered the rows that were left; people look them up in their own table.
    outliers = reached.with_rows_of_table(answer.outliers)
    return replace(
        answer,
        message=together(answer.message, reached.sentence),
        outliers=outliers,
        model=with_set_aside(answer.model, reached),
        counts=replace(answer.counts, outliers=answer.counts.outliers + len(reached.outliers)),
    )


def _silent(_fraction: float, _doing: Text) -> None:
    return None


def nominal_fit(problem: Problem, identified: RobustFit) -> RobustFit:
    """Fit only base and unknown nests around the nominal robot, without the readings found gross.

    Parameters
    ----------
    problem : Problem
    identified : RobustFit
        Of that problem, which tells the gross readings and the discrepancy.

    Returns
    -------
    RobustFit
        Its chi-square is NaN: what the nominal robot leaves is no noise.
    """
    left = tuple(name for name in problem.structure.effects if name not in NOMINAL_EFFECTS)
    structure = problem.structure.without(left)
    # Both models are held against the same readings: neither is better for what it left out.
    blocks = tuple(
        block.weighted(np.where(flags, 0.0, 1.0), block.discrepancy)
        for block, flags in zip(identified.blocks, identified.gross, strict=True)
    )
    start = np.array([problem.start[problem.structure.index_of(name)] for name in structure.names])
    solution = fit(structure, blocks, start)
    return RobustFit(structure, blocks, solution, identified.gross, float("nan"))


def _answer(
    campaign: Campaign, problem: Problem, identified: RobustFit, nominal: RobustFit, tell: Progress
) -> Identification:
    carried = propagate_certificates(campaign, identified)
    fits = Fits(campaign, identified, nominal, carried.total)
    # Without what it lacks: that is told by holding this draft against readings.
    draft = model_of(fits, discrepancy_mm=0.0, program_version=__version__)
    calibration = _calibration(identified, nominal)
    # Held-out readings share certificates and registration with those of the fit: that part of the
    # uncertainty cannot show in their residuals.
    validation = _validation(campaign, replace(draft, covariance=carried.readings))
    crossed = None if validation else _crossed(calibration, identified, nominal)
    # Readings that were held out on purpose come before those that take turns.
    held_out = validation or crossed
    model = replace(draft, shortfall=shortfall(identified, problem.setting))
    model = model if held_out is None else replace(model, discrepancy_mm=held_out.discrepancy_mm())
    tell(0.9, message("job.doing.open"))
    gross = outliers(identified)
    status, sentence = verdict.outcome(campaign, problem, identified)
    # Where nothing fits, the covariance speaks of the misfit, not of what the configurations can see.
    trusted = status in (Status.CONVERGED, Status.NOT_CONVERGED)
    named = _not_identifiable(problem, identified) if trusted else ()
    kept = ~identified.gross[0]
    return Identification(
        status=status,
        message=sentence,
        effects=tuple(name for name in problem.structure.effects if name not in effects_with(Trait.NUISANCE)),
        counts=_counts(problem, identified),
        parameters=model.parameters,
        not_identifiable=named,
        outliers=gross,
        quantity=problem.quantity,
        calibration=calibration.pair(),
        validation=validation.pair() if validation else None,
        cross_validation=crossed.pair() if crossed else None,
        relative=relative_errors(held_out) if held_out else None,
        calibration_without_outliers=calibration.pair(kept) if gross else None,
        chi2_per_dof=identified.chi2_per_dof,
        pure_error=_pure_error(identified),
        model=model,
        # Lengths leave the frame open: only such models need to be tied before positions judge them.
        positions=judged_by_positions(campaign, model) if problem.quantity == "length" else None,
        calibration_turns=turn_errors(model, campaign.calibration),
        validation_turns=turn_errors(model, campaign.validation),
    )


def _counts(problem: Problem, identified: RobustFit) -> Counts:
    each = zip(identified.blocks, identified.results, strict=True)
    # A belief is no observation of this robot.
    sizes = [result.residual.size for block, result in each if block.quantity != BELIEF]
    return Counts(
        configurations=len(distinct_values(sites(problem.blocks[0].targets.stops))),
        observations=int(sum(sizes)),
        parameters=len(problem.structure.specs),
        outliers=identified.without_weight,
    )


def _calibration(identified: RobustFit, nominal: RobustFit) -> Assessment:
    """Return the readings of the fits against these, with the uncertainties as stated."""
    block, result = identified.blocks[0], identified.results[0]
    # Noise is what readings state, not what the model lacks besides.
    stated = block.weighted(block.weights, 0.0)
    return Assessment(stated, nominal.results[0], result, np.zeros(len(block.weights)))


def _validation(campaign: Campaign, model: Model) -> Assessment | None:
    readings = campaign.held_out
    return None if readings is None else judge(model, readings, campaign.scatter_mm)


def _crossed(calibration: Assessment, identified: RobustFit, nominal: RobustFit) -> Assessment | None:
    """Return the readings of the fits, each against fits that never saw its configuration."""
    if len(distinct_values(sites(calibration.stops))) < 2:
        return None  # revisits of one place: nothing is left to predict it from
    after, variance = held_out_residuals(identified)
    before, _ = held_out_residuals(nominal)
    return replace(
        calibration,
        nominal=replace(calibration.nominal, residual=before),
        identified=replace(calibration.identified, residual=after),
        variance=variance,
    )


def _pure_error(identified: RobustFit) -> PureError | None:
    # Of the first block, which all figures are of.
    block, result = identified.blocks[0], identified.results[0]
    return pure_error(block, result.residual, absorbed(result.white_jacobian, identified.solution.covariance))


def _not_identifiable(problem: Problem, identified: RobustFit) -> tuple[NotIdentifiable, ...]:
    jacobian = identified.solution.final.jacobian
    # With the stated widths: those that the fit widened would call less undetermined than is.
    covariance = posterior_covariance(jacobian, 1.0 / problem.structure.prior_widths**2)
    stops = problem.blocks[0].targets.stops
    moved = np.ptp(stops.joints_rad, axis=0) > _MOVED_RAD
    return not_identifiable(problem.structure, covariance, jacobian, problem.setting, moved)


def _unfitted(campaign: Campaign, effects: tuple[str, ...], status: Status, sentence: Text) -> Identification:
    readings = campaign.readings
    observations = 0 if readings is None else readings.observed_mm.size
    configurations = 0 if readings is None else len(distinct_values(readings.stops.config))
    return Identification(
        status=status,
        message=sentence,
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
