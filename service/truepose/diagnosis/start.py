"""The start: the present model fitted to the campaign, its labels put right first."""

from dataclasses import dataclass, replace

import numpy as np

from truepose.diagnosis.circumstances import scene_of
from truepose.diagnosis.readings.angle_steps import AngleSteps, telling_steps, with_steps
from truepose.diagnosis.readings.gathered import gathered
from truepose.diagnosis.readings.single_readings import swapped_labels
from truepose.domain.measurement.campaign import Campaign, PointReadings
from truepose.domain.results.identification import Status
from truepose.domain.sentences import Text, together
from truepose.effects.causes import Scene
from truepose.effects.ports import Trait
from truepose.effects.registry import effects_with
from truepose.effects.tool.tool_certificate import NAME as CERTIFICATE
from truepose.effects.tool.tool_certificate import certificate_specs
from truepose.identification.fit.robust import RobustFit, counted_fit, robust_fit
from truepose.identification.problem.build import Problem, automatic_effects, build
from truepose.identification.verdict import status as verdict

NUISANCE = effects_with(Trait.NUISANCE)  # a diagnosis needs them, no model keeps them
_UNUSABLE = (Status.WRONG_NOMINAL_MODEL, Status.OUTLIERS_DOMINATE, Status.TOO_FEW_DATA)


@dataclass(frozen=True, slots=True)
class Start:
    """What a diagnosis starts from."""

    campaign: Campaign  # with labels put right, points as uncertain as steps of their angles make them
    problem: Problem
    fit: RobustFit
    scene: Scene
    effects: tuple[str, ...]
    written: Campaign  # as it was measured
    steps: AngleSteps | None = None  # of the joint angles, by which its readings weigh
    doubt: Text = ""  # so many readings do not fit the others that a cause must be found for it to stand


def started(campaign: Campaign, effects: tuple[str, ...] | None, *, relabel: bool) -> Start | Text:
    """Fit the present model; a sentence where it cannot be fitted.

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
        shared = gathered(scene, fitted.gross[0])
        doubt = together(message, shared.sentence) if shared else message
        counted = counted_fit(problem.structure, problem.blocks, problem.start)
        return Start(corrected, problem, counted, scene_of(problem, counted), chosen, campaign, steps, doubt)
    if status in _UNUSABLE:
        return message
    return Start(corrected, problem, fitted, scene, chosen, campaign, steps)


def stands(start: Start, fitted: RobustFit) -> bool:
    """Whether with what was found the readings fit one another."""
    extended = replace(start.problem, structure=fitted.structure)
    status, _ = verdict.outcome(start.campaign, extended, fitted)
    return status not in _UNUSABLE


def _fitted(campaign: Campaign, effects: tuple[str, ...]) -> tuple[Problem, RobustFit]:
    problem = _problem(campaign, effects)
    return problem, robust_fit(problem.structure, problem.blocks, problem.start)


def _problem(campaign: Campaign, effects: tuple[str, ...]) -> Problem:
    """Build the problem with fixed nests as observations, certified nests free within their certificates."""
    problem = build(campaign, effects, with_reference=True)
    if CERTIFICATE in problem.structure.effects:
        return problem
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
    everything = np.ones(len(points), dtype=bool)
    return replace(points, nest=swapped_labels(points, everything, fitted))
