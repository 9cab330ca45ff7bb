"""What an identification may claim: enough data, the right table, few enough gross readings, an end.

What readings teach of a parameter of prior width w and posterior variance C is

    1 - C / w^2        0 for its prior alone, 1 for the data alone

and summed up over the parameters that were asked for, how many parameters' worth was learnt: less than one is
nothing. Errors of the geometry beyond ten prior widths, and tables after whose identification more than
0.0015 of the reach is left, are no robot's.
"""

import numpy as np

from truepose.domain.arrays import distinct_values
from truepose.domain.campaign import Campaign, PointReadings
from truepose.domain.identification import Status
from truepose.effects.frames.base_frame import WIDTH_MM as BASE_WIDTH_MM
from truepose.effects.frames.base_frame import WIDTH_RAD as BASE_WIDTH_RAD
from truepose.effects.ports import Trait
from truepose.effects.registry import effect_named, effects_with
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.structure import NOMINAL_EFFECTS
from truepose.identification.observations.joint_priors import BeliefBlock
from truepose.identification.problem.build import Problem
from truepose.identification.problem.problem_setup import known_placement, setting_of
from truepose.identification.verdict.conventions import (
    Change,
    Evidence,
    change_that_fits,
    plausible_mm,
    reach_mm,
)
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.frames import placement_rotation, placement_translation
from truepose.messages.message import Message, message

# Rows that differ by the rounding of a table are one configuration.
_SAME_RAD = 1e-6
# No two configurations of an arm that moves are read alike to this: the instrument is stuck.
_SAME_MM = 1e-3
_PART = 0.15  # share of the readings from which on it is no accident
_TOO_MANY_GROSS = 0.2
# Of widths of 1 mm and 5 mrad: a centimetre, or three degrees.
_IMPLAUSIBLE_WIDTHS = 10.0
_IDENTIFIED_SHARE = 0.0015  # of the reach: no identified model of the right robot leaves so much
_SUSPICIOUS_CHI2 = 2.0
_CERTAINLY_NEGATIVE = 5.0  # standard uncertainties; at 3 a spring that is hardly loaded would be accused
_ONE_PARAMETER = 1.0  # what is learnt of all, each from 0 for its prior to 1 for the data alone
_UNLIKE = 1e-3  # chance of a robot of the type to be called unlike it
_FAR_WIDTHS = 3.0  # of the base's prior


def too_few_data(campaign: Campaign, effects: tuple[str, ...]) -> Message | None:
    """Return the sentence that says what is missing, None where there is enough to fit.

    Parameters
    ----------
    campaign : Campaign
    effects : tuple of str
        Whose parameters are to be found.
    """
    readings = campaign.readings
    if readings is None:
        return None
    setting = setting_of(campaign, readings.stops)
    parameters = sum(len(effect_named(name).specs(setting)) for name in effects)
    joints = np.round(readings.stops.joints_rad / _SAME_RAD)
    distinct, place = np.unique(joints, axis=0, return_inverse=True)
    configurations = len(distinct)
    pairs = np.column_stack([place.reshape(-1), readings.ends])
    per_reading = readings.observed_mm.shape[1]
    # Repeats of a reading say nothing new of the parameters.
    different = len(readings) if configurations == len(readings) else len(distinct_values(pairs, axis=0))
    observations = per_reading * different
    if configurations == 1:
        return message("status.one_configuration", readings=len(readings))
    # An instrument that is stuck reads the same wherever the arm is; a probe that stops the arm may read 0.
    if readings.frozen_if_equal and np.ptp(readings.observed_mm, axis=0).max() < _SAME_MM:
        key = "status.same_position" if readings.quantity == "position" else "status.same_length"
        return message(key, readings=len(readings))
    if observations < parameters:
        return message(
            "status.too_few",
            configurations=configurations,
            observations=observations,
            parameters=parameters,
            needed=int(np.ceil(1.5 * parameters / per_reading)),
        )
    return None


def before_fitting(campaign: Campaign, problem: Problem) -> Message | None:
    """Return the sentence of a wrong convention where the nominal robot cannot be placed at all.

    Parameters
    ----------
    campaign : Campaign
    problem : Problem
        Whose nominal residuals [mm] are those of the placed robot.
    """
    points = campaign.calibration
    if points is None:
        return None
    typical = float(np.median(np.linalg.norm(problem.nominal_residual_mm, axis=1)))
    evidence = _evidence(points)
    if typical < plausible_mm(campaign.robot) and not _collapsed(campaign, evidence):
        return None
    change = change_that_fits(campaign.robot, evidence, known_placement(campaign))
    if change:
        return _would_fit(typical, change)
    return None


def _would_fit(typical_mm: float, change: Change) -> Message:
    return message("status.would_fit", typical_mm=typical_mm, change=change.sentence)


def _collapsed(campaign: Campaign, evidence: Evidence) -> bool:
    flange = nominal_chain(campaign.robot, evidence.joints_rad).origin[-1]
    return bool(np.ptp(evidence.position_mm, axis=0).max() < 0.02 * np.ptp(flange, axis=0).max())


def _evidence(points: PointReadings) -> Evidence:
    return Evidence(points.stops.joints_rad, points.nest, points.position_mm)


def outcome(campaign: Campaign, problem: Problem, identified: RobustFit) -> tuple[Status, Message]:
    """Return status and message of a fit.

    Parameters
    ----------
    campaign : Campaign
    problem : Problem
    identified : RobustFit

    Returns
    -------
    status : Status
    message : Message
    """
    share = float(np.mean(identified.gross[0]))
    typical = _typical(identified)
    gross = int(identified.gross[0].sum())
    n = len(identified.gross[0])
    # Gross readings come first: where they dominate, no other figure of the fit means what it says.
    if share > _TOO_MANY_GROSS or _majority_gross(campaign, typical):
        key = "status.gross" if share > _TOO_MANY_GROSS else "status.half_gross"
        return Status.OUTLIERS_DOMINATE, message(key, gross=gross, readings=n)
    nothing = _nothing_learnt(campaign, problem, identified)
    if nothing:
        return Status.TOO_FEW_DATA, nothing
    # Before convergence: where the table is wrong, whether the solver settled is of no interest.
    wrong = _wrong_model(campaign, problem, identified, typical)
    if wrong:
        return Status.WRONG_NOMINAL_MODEL, wrong
    if not identified.solution.converged:
        return Status.NOT_CONVERGED, message("status.not_settled", steps=identified.solution.iterations)
    return Status.CONVERGED, _converged_message(problem, identified)


def _nothing_learnt(campaign: Campaign, problem: Problem, identified: RobustFit) -> Message | None:
    """Return the sentence for readings that by their own word say less than one parameter's worth."""
    if identified.blocks[0].discrepancy > 0.0:
        return None  # it is the model that says little of them
    structure = problem.structure
    unasked = (*NOMINAL_EFFECTS, *effects_with(Trait.NUISANCE))
    asked = [name for name in structure.effects if name not in unasked]
    wanted = np.isin(structure.owners, asked or list(NOMINAL_EFFECTS))
    # Over the widths of the fit, not the stated ones: widened priors know less to begin with.
    left = np.diag(identified.solution.covariance) / identified.structure.prior_widths**2
    learnt = float(np.clip(1.0 - left[wanted], 0.0, 1.0).sum())
    if learnt >= min(_ONE_PARAMETER, 0.5 * wanted.sum()):
        return None
    readings = campaign.readings
    u_mm = float("nan") if readings is None else float(np.median(readings.standard_uncertainty_mm))
    return message("status.nothing_learnt", effects=", ".join(asked or NOMINAL_EFFECTS), u_mm=u_mm)


def _typical(fit: RobustFit) -> float:
    return float(np.median(np.linalg.norm(fit.results[0].residual, axis=1)))


def _majority_gross(campaign: Campaign, typical_mm: float) -> bool:
    """Return whether a sizeable part agrees with the nominal robot on its base, yet the whole does not."""
    base, points = campaign.base_nominal, campaign.calibration
    if base is None or points is None or typical_mm < plausible_mm(campaign.robot):
        return False
    known = known_placement(campaign)
    if known.nest_unknown.any():
        return False
    chain = nominal_chain(campaign.robot, points.stops.joints_rad)
    here = chain.points(known.nests_mm[points.nest - 1])
    seen = (points.position_mm - placement_translation(base)) @ placement_rotation(base)
    off_mm = np.linalg.norm(seen - here, axis=1)
    usual_mm = plausible_mm(campaign.robot)  # 0 of a table without lengths
    # Two crowds: of one wrong table all readings would be off alike.
    return bool((off_mm < usual_mm).mean() > _PART and (off_mm > 4.0 * usual_mm).mean() > _PART)


def _wrong_model(
    campaign: Campaign, problem: Problem, identified: RobustFit, typical_mm: float
) -> Message | None:
    points = campaign.calibration
    nominal_mm = float(np.median(np.linalg.norm(problem.nominal_residual_mm, axis=1)))
    # A wrong table leaves tens of millimetres; where the nominal robot fits, a large error of the geometry
    # stands for something else that the model lacks, and is said so in the message.
    strange = nominal_mm > plausible_mm(campaign.robot) and implausible_parameter(problem, identified)
    unfit = typical_mm > _IDENTIFIED_SHARE * reach_mm(campaign.robot)
    # A wrong convention may hide in the parameters and show in chi-square alone.
    if points is not None and (strange or unfit or identified.chi2_per_dof > _SUSPICIOUS_CHI2):
        change = change_that_fits(
            campaign.robot, _evidence(points), known_placement(campaign), search_zeros=bool(strange or unfit)
        )
        if change:
            return _would_fit(nominal_mm, change)
    if unfit:
        return message("status.still_misses", typical_mm=typical_mm)
    if strange:
        return message("status.far_beyond", parameter=strange)
    return None


def implausible_parameter(problem: Problem, identified: RobustFit) -> str | None:
    """Name a geometric error that is certainly larger than any robot's.

    Parameters
    ----------
    problem : Problem
        With the stated prior widths.
    identified : RobustFit

    Returns
    -------
    str or None
        Name and value [deg or mm] of the first that is beyond ten widths by three standard uncertainties.
    """
    uncertainty = np.sqrt(np.diag(identified.solution.covariance))
    for spec, owner, value, u in zip(
        problem.structure.specs, problem.structure.owners, identified.values, uncertainty, strict=True
    ):
        certain = abs(value) - 3.0 * u > _IMPLAUSIBLE_WIDTHS * spec.prior_width
        if owner in effects_with(Trait.GEOMETRY) and certain:
            shown = f"{np.rad2deg(value):.2f} deg" if spec.unit == "rad" else f"{value:.1f} mm"
            return f"{spec.name} = {shown}"
    return None


def _converged_message(problem: Problem, identified: RobustFit) -> Message:
    parts: list[Message] = []
    if identified.without_weight:
        parts.append(message("status.outliers", n=identified.without_weight))
    fixed = _bad_looks(identified)
    if fixed:
        parts.append(message("status.nest_outliers", n=fixed))
    parts += [told for told in (_base_elsewhere(problem, identified), _unlike_its_type(identified)) if told]
    # Converged, with a parameter that stands for something else which the model lacks: said, not refused.
    strange = implausible_parameter(problem, identified)
    if strange:
        parts.append(message("status.strange", parameter=strange))
    backwards = _springs_that_push(problem, identified)
    if backwards:
        parts.append(message("status.negative_springs", springs=tuple(backwards)))
    lacking = identified.blocks[0].discrepancy
    if lacking > 0.0:
        parts.append(message("status.lacking", lacking_mm=lacking))
    parameters = len(problem.structure.specs)
    if not parts:
        return message("status.converged", parameters=parameters)
    return message("status.converged_but", parameters=parameters, parts=tuple(parts))


def _bad_looks(identified: RobustFit) -> int:
    """Count the readings of fixed nests that fit nothing; they stand in no table of the arm."""
    return sum(
        int(flags.sum())
        for block, flags in zip(identified.blocks, identified.gross, strict=True)
        if block.table == "reference"
    )


def _unlike_its_type(identified: RobustFit) -> Message | None:
    """Say so where the robot is not as robots of its type are believed to be."""
    beliefs = (block for block in identified.blocks if isinstance(block, BeliefBlock))
    for belief in beliefs:
        off = belief.unlikeness(identified.structure, identified.values, identified.solution.covariance)
        if off.chance < _UNLIKE:
            return message("status.unlike_its_type", parameter=off.parameter, off_u=off.off_u)
    return None


def _springs_that_push(problem: Problem, identified: RobustFit) -> list[str]:
    """Name the springs that yield against their load; a product with an unknown moment may have any sign."""
    # No gearbox turns against its load: such a spring stands for something else.
    uncertainty = np.sqrt(np.diag(identified.solution.covariance))
    return [
        spec.name
        for spec, owner, value, u in zip(
            problem.structure.specs, problem.structure.owners, identified.values, uncertainty, strict=True
        )
        if owner in effects_with(Trait.SPRINGS) and "*" not in spec.name and value < -_CERTAINLY_NEGATIVE * u
    ]


def _base_elsewhere(problem: Problem, identified: RobustFit) -> Message | None:
    """Say so where the base stands far from the place that the campaign gives it."""
    value = dict(zip(problem.structure.names, identified.values, strict=True))
    width = {spec.name: spec for spec in problem.structure.specs}
    if "base_x" not in value or width["base_x"].prior_mean != 0.0:  # found from the data: no place was given
        return None
    shift_mm = float(np.linalg.norm([value["base_x"], value["base_y"], value["base_z"]]))
    turn_rad = float(np.linalg.norm([value["base_rx"], value["base_ry"], value["base_rz"]]))
    if shift_mm < _FAR_WIDTHS * BASE_WIDTH_MM and turn_rad < _FAR_WIDTHS * BASE_WIDTH_RAD:
        return None
    return message("status.base_elsewhere", shift_mm=shift_mm, turn_deg=float(np.rad2deg(turn_rad)))
