"""Fitted starts and selections for the parts of a diagnosis; a test names what was planted and tried."""

from dataclasses import replace
from functools import cache

import numpy as np

from tests.helpers.diagnosis.point_scenes import telling_campaign
from tests.helpers.identification.synthetic import NOISE_MM, configurations
from truepose.diagnosis.baseline_fit import Start, fit_baseline, scene_of
from truepose.diagnosis.diagnose import propose_candidates
from truepose.diagnosis.evidence.residual_structure import prepared_families, residual_dependence
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.selection import Selection, chosen, refit_picks, select
from truepose.effects.ports import ParameterSpec
from truepose.effects.registry import CAUSES
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.problem.build import build

# Geometry would make each fit three times as slow, and hardly a test here is about it.
PRESENT = ("base", "joint_offset", "compliance")


def planted(effects, campaign=None, n=80, seed=3, noise_mm=NOISE_MM, present=PRESENT):
    """A campaign of the nominal robot with parameter values of further effects: `{effect: {name: value}}`."""
    campaign = telling_campaign(n, seed=seed) if campaign is None else campaign
    problem = build(campaign, present)
    structure, values = problem.structure, problem.start
    for effect, parameters in effects.items():
        structure = structure.extended(effect, tuple(ParameterSpec(p, "1", 0.0, 1.0) for p in parameters))
        values = np.append(values, list(parameters.values()))
    points = campaign.calibration
    true_mm = evaluate(structure, values, Targets(points.stops, points.nest)).position_mm
    noise = noise_mm * np.random.default_rng(seed).standard_normal(true_mm.shape)
    return replace(campaign, calibration=replace(points, position_mm=true_mm + noise))


def with_unseen(effects):
    """What was planted, with forty validation readings of configurations of their own."""
    unseen = planted(effects, telling_campaign(40, joints_rad=configurations(40, seed=9)), seed=11)
    return replace(planted(effects), validation=unseen.calibration)


def make_start(effects, present=PRESENT, *, campaign=None, n=80, seed=3, noise_mm=NOISE_MM):
    """The present model fitted to what was planted; many tests begin alike, and a start never changes."""
    if campaign is not None:
        return started(planted(effects, campaign, n, seed, noise_mm, present), present)
    parameters = tuple((effect, tuple(values.items())) for effect, values in effects.items())
    return _usual_start(parameters, present, n, seed, noise_mm)


@cache
def _usual_start(parameters, present, n, seed, noise_mm):
    effects = {effect: dict(values) for effect, values in parameters}
    return started(planted(effects, None, n, seed, noise_mm, present), present)


def started(campaign, present=PRESENT):
    """The present model fitted to a campaign as it stands."""
    start = fit_baseline(campaign, present, relabel=False)
    assert isinstance(start, Start), start
    return start


def everything(start):
    """What a diagnosis proposes of a fit: every way in which every cause may be present."""
    return lambda fit: propose_candidates(scene_of(start.problem, fit), ())


def those_of(start, *effects):
    """What a diagnosis proposes of a fit where it looks for nothing but these effects."""
    return lambda fit: tuple(
        candidate
        for effect in effects
        for candidate in CAUSES[effect].candidates(scene_of(start.problem, fit))
    )


def make_selected(start, picked, rivals=()):
    """The candidates `picked` fitted, those of `rivals` tried: each (effect, subject, first name or None)."""
    picks = tuple(found for one in picked for found in proposed(start.scene, *one)[:1])
    fit = refit_picks(start.fit, start.fit, picks) if picks else start.fit
    scene = scene_of(start.problem, fit)
    tried = tuple(candidate for one in rivals for candidate in proposed(scene, *one))
    return Selection(fit, picks, pool_candidates(fit, (*picks, *tried)), full=False)


def select_from(start, propose):
    """What a diagnosis would pick of what is proposed."""
    return select(chosen(pool_candidates(start.fit, propose(start.fit))), propose, lambda _share: None)


def left_of(start, selected, without=()):
    """What a selection leaves."""
    return residual_dependence(start, selected, prepared_families(selected.fit, start.scene), without)


def proposed(scene, effect, subject, first=None):
    """The candidates of an effect on a subject, those that begin with a parameter where it is named."""
    return [
        candidate
        for candidate in CAUSES[effect].candidates(scene)
        if candidate.subject == subject
        and (first is None or (candidate.names[0] == first and not candidate.function))
    ]
