"""The start of a diagnosis: the present model fitted to the campaign, its labels put right first.

Order matters. Swapped labels are put right before anything is judged, since a swap is a large residual that
would be found as something else. Steps of the joint angles are looked for next, since points weigh by them.
Only the fit after both decides whether the readings fit one another at all.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.angle_steps import AngleSteps, telling_steps, with_steps
from truepose.diagnosis.reading_faults import shared_properties, swapped_labels
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, PointReadings
from truepose.domain.identification import Status
from truepose.effects.causes import Scene
from truepose.effects.frames.tool_certificate import NAME as CERTIFICATE
from truepose.effects.frames.tool_certificate import certificate_specs
from truepose.effects.names import joint_name
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.identification.fit.robust import RobustFit, counted_fit, robust_fit
from truepose.identification.model.evaluation import State, rows_of
from truepose.identification.model.structure import Structure, anchor_places
from truepose.identification.problem.build import Problem, automatic_effects, build
from truepose.identification.verdict import status as verdict
from truepose.messages.message import Text, together


def scene_of(problem: Problem, fit: RobustFit) -> Scene:
    """Return the scene of a fitted problem.

    Parameters
    ----------
    problem : Problem
    fit : RobustFit
        Of this problem, or of an extension of its structure.

    Returns
    -------
    Scene
        Of the first block of readings, which is that of the arm.
    """
    fixed = [block.targets.stops.time_s for block in fit.blocks if block.table == "reference"]
    times = [time_s for time_s in fixed if time_s is not None]
    return scene_at(problem, fit.results[0].state, np.concatenate(times) if times else np.zeros(0))


def scene_at(problem: Problem, state: State, reference_s: FloatArray) -> Scene:
    """Return the scene of a model evaluated at its readings.

    Parameters
    ----------
    problem : Problem
    state : State
        At n readings.
    reference_s : ndarray, shape (r,)
        When fixed nests were read [s]; empty where none was.

    Returns
    -------
    Scene
        Softness of each joint [rad/(N mm)] as fitted; 0 of joints without a spring in the model.
    """
    rows, structure = rows_of(state), state.structure
    spring = dict(zip(structure.names, state.values.tolist(), strict=True))
    x, y, z = structure.gravity_m_s2.tolist()
    return Scene(
        setting=problem.setting,
        stops=state.targets.stops,
        nest=state.targets.nest,
        chain=state.chain,
        torque_n_mm=rows.torque_n_mm,
        turn_rad=rows.turn_rad,
        softness_rad_per_n_mm=np.array([
            spring.get(joint_name("c", joint), 0.0) for joint in range(structure.robot.n_joints)
        ]),
        present=frozenset(structure.names),
        effects=structure.effects,
        reference_s=reference_s,
        origin_s=structure.origin_s,
        gravity_m_s2=(x, y, z),
        legs=problem.quantity == "length",
        initialisation=state.targets.initialisation,
        placement=state.targets.placement,
        instrument_mm=structure.instrument_mm,
        fixtures_mm=_fixtures_mm(structure, state.values),
    )


def _fixtures_mm(structure: Structure, values: FloatArray) -> dict[int, FloatArray]:
    """Return the middle of the base nests of each placement (3,) [mm], world; empty without lengths."""
    if not structure.anchors:
        return {}
    places = anchor_places(structure, values)
    placement = np.array([placement for placement, _ in structure.anchors])
    return {number: places[placement == number].mean(axis=0) for number in placement.tolist()}


NUISANCE = effects_with(Trait.NUISANCE)  # a diagnosis needs them, no model keeps them
_UNUSABLE = (Status.WRONG_NOMINAL_MODEL, Status.OUTLIERS_DOMINATE, Status.TOO_FEW_DATA)


@dataclass(frozen=True, slots=True)
class Start:
    """What a diagnosis starts from.

    Attributes
    ----------
    campaign : Campaign
        Labels put right; points as uncertain as the steps of their joint angles make them.
    problem : Problem
        Of that campaign.
    fit : RobustFit
        Of that problem. Where outliers dominate, every reading counts in it.
    scene : Scene
        Of that fit.
    effects : tuple of str
        Of the present model.
    written : Campaign
        As it was measured, labels included.
    steps : AngleSteps or None
        Rounding of the joint angles, where it explains the noise.
    doubt : Text
        Why no model may be trusted unless a cause is found; "" as a rule.
    """

    campaign: Campaign
    problem: Problem
    fit: RobustFit
    scene: Scene
    effects: tuple[str, ...]
    written: Campaign
    steps: AngleSteps | None = None
    doubt: Text = ""


def fit_baseline(campaign: Campaign, effects: tuple[str, ...] | None, *, relabel: bool) -> Start | Text:
    """Fit the present model to a campaign.

    Parameters
    ----------
    campaign : Campaign
    effects : tuple of str or None
        Of the model; None takes what `automatic_effects` gives.
    relabel : bool
        Whether swapped labels of nests are put right.

    Returns
    -------
    Start or Text
        A sentence where the present model cannot be fitted.

    Raises
    ------
    UnknownEffectError, ConfigurationError
        The request cannot be understood.
    """
    chosen = automatic_effects(campaign) if effects is None else effects
    too_few = verdict.too_few_data(campaign, chosen)
    if too_few:
        return too_few
    problem = _problem(campaign, chosen)
    collapsed = verdict.before_fitting(campaign, problem)
    if collapsed:
        return collapsed
    fitted = robust_fit(problem.structure, problem.blocks, problem.start)
    corrected = _relabelled(campaign, fitted) if relabel else campaign
    if corrected is not campaign:
        problem, fitted = _fitted(corrected, chosen)
    steps = telling_steps(fitted)
    if steps is not None and not steps.of_lengths:
        corrected = with_steps(corrected, fitted, steps)
        problem, fitted = _fitted(corrected, chosen)
    status, message = verdict.outcome(corrected, problem, fitted)
    scene = scene_of(problem, fitted)
    if status is Status.OUTLIERS_DOMINATE:
        shared = shared_properties(scene, fitted.gross[0])
        doubt = together(message, shared.sentence) if shared else message
        # A cause that moves many readings at once makes outliers of them; with every reading counted it
        # can still be seen. Measured: a zero that jumps by 0.03 deg after two thirds of the readings is then
        # named.
        counted = counted_fit(problem.structure, problem.blocks, problem.start)
        return Start(corrected, problem, counted, scene_of(problem, counted), chosen, campaign, steps, doubt)
    if status in _UNUSABLE:
        return message
    return Start(corrected, problem, fitted, scene, chosen, campaign, steps)


def stands(start: Start, fitted: RobustFit) -> bool:
    """Return whether the readings fit one another once the findings are in the model.

    Parameters
    ----------
    start : Start
    fitted : RobustFit
        Of the extended model.

    Returns
    -------
    bool
    """
    extended = replace(start.problem, structure=fitted.structure)
    status, _ = verdict.outcome(start.campaign, extended, fitted)
    return status not in _UNUSABLE


def _fitted(campaign: Campaign, effects: tuple[str, ...]) -> tuple[Problem, RobustFit]:
    problem = _problem(campaign, effects)
    return problem, robust_fit(problem.structure, problem.blocks, problem.start)


def _problem(campaign: Campaign, effects: tuple[str, ...]) -> Problem:
    """Build the problem with fixed nests as observations, certified nests free within their certificates."""
    # Fixed nests take part: they alone tell an instrument that was kicked from a base that moved (decision
    # 0029).
    problem = build(campaign, effects, with_reference=True)
    if CERTIFICATE in problem.structure.effects:
        return problem
    # Held still, an error of some micrometres that all readings of a nest share is found as a cause (decision
    # 0015). The certificates stay nuisance: the model in the end is fitted without them.
    specs = certificate_specs({
        number: nest.standard_uncertainty_mm
        for number, nest in enumerate(campaign.nests, start=1)
        if nest.centre_mm is not None and nest.standard_uncertainty_mm
    })
    structure = problem.structure.extended(CERTIFICATE, specs) if specs else problem.structure
    return replace(problem, structure=structure, start=np.concatenate([problem.start, np.zeros(len(specs))]))


def _relabelled(campaign: Campaign, fitted: RobustFit) -> Campaign:
    points = campaign.calibration
    if points is None:
        return campaign
    nest = swapped_labels(points, fitted.gross[0], fitted)
    if np.array_equal(nest, points.nest):
        return campaign
    return replace(campaign, calibration=replace(points, nest=nest), validation=_validation(campaign, fitted))


def _validation(campaign: Campaign, fitted: RobustFit) -> PointReadings | None:
    """Put labels of the validation right where they are swapped: it is to judge the model, not the labels."""
    points = campaign.validation
    if points is None:
        return None
    # No fit has judged these readings, so none is suspected more than another.
    everything = np.ones(len(points), dtype=bool)
    return replace(points, nest=swapped_labels(points, everything, fitted))
