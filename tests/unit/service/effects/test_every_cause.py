"""What every cause keeps to where its data tell all it depends on: seen, a candidate, rebuilt from names."""

from dataclasses import replace

import pytest

from tests.helpers.diagnosis.leg_scenes import LEG_START, leg_scene, telling_legs
from tests.helpers.diagnosis.point_scenes import START, telling_campaign, telling_scene
from truepose.effects.registry import CAUSES
from truepose.identification.model.evaluation import evaluate, rows_of
from truepose.identification.problem.build import build

OF_RESIDUALS = ("label_swap", "outliers")  # whose candidates are found among the residuals of a fit
OF_LENGTHS = ("ballbar_scale", "ballbar_zero", "fixture_shift")
ANOTHER_START = {
    "axis_parallelism": ("base", "geometry_dhm", "compliance"),
    "compliance": ("base", "geometry"),
}


def scene_for(cause):
    return leg_scene() if cause in OF_LENGTHS else telling_scene(ANOTHER_START.get(cause, START))


def rows_for(cause):
    of_lengths = cause in OF_LENGTHS
    start = LEG_START if of_lengths else ANOTHER_START.get(cause, START)
    problem = build(telling_legs() if of_lengths else telling_campaign(), start)
    return rows_of(evaluate(problem.structure, problem.start, problem.blocks[0].targets))


@pytest.mark.parametrize("cause", [cause for cause in CAUSES if cause not in OF_RESIDUALS])
def test_it_is_seen_and_what_the_model_has_is_no_candidate(cause):
    scene = scene_for(cause)
    candidates = CAUSES[cause].candidates(scene)
    first = set(candidates[0].names)

    left = CAUSES[cause].candidates(replace(scene, present=scene.present | first))

    assert CAUSES[cause].unseen(scene) is None
    assert not any(first & set(candidate.names) for candidate in left)


@pytest.mark.parametrize("cause", CAUSES)
def test_terms_are_rebuilt_from_names_alone_one_parameter_or_all(cause):
    rows = rows_for(cause)
    found = CAUSES[cause].candidates(scene_for(cause))
    names = tuple(dict.fromkeys(name for candidate in found for name in candidate.names))

    together = CAUSES[cause].terms(names, rows)

    assert {term.parameter for term in together} == set(range(len(names)))
    for k, name in enumerate(names):
        alone = CAUSES[cause].terms((name,), rows)
        among = [term for term in together if term.parameter == k]
        assert [term.port for term in alone] == [term.port for term in among]
        for own, shared in zip(alone, among, strict=True):
            # waves of many orders are built up from one another: some hundred roundings
            assert own.weight == pytest.approx(shared.weight, rel=1e-12, abs=1e-12)
