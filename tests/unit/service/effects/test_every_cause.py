"""What every cause keeps to where its data tell all it depends on: seen, a candidate, rebuilt from names."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.leg_scenes import leg_problem, leg_scene
from tests.helpers.diagnosis.point_scenes import rows_at_start, start_for, telling_problem, telling_scene
from truepose.effects.causes import FittedCause
from truepose.effects.registry import CAUSES

OF_RESIDUALS = ("label_swap", "outliers")  # whose candidates are found among the residuals of a fit
OF_LENGTHS = ("ballbar_scale", "ballbar_zero", "fixture_shift")


def scene_for(cause):
    return leg_scene() if cause in OF_LENGTHS else telling_scene(start_for(cause))


def rows_for(cause):
    return rows_at_start(leg_problem() if cause in OF_LENGTHS else telling_problem(start_for(cause)))


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


@pytest.mark.parametrize(
    ("cause", "more", "less", "figures"),
    [
        ("backlash", "short", "past", {"gap_deg": 0.03}),
        ("joint_gain", "too_far", "not_far_enough", {"share": 3e-4}),
        ("compliance_nonlinear", "softer", "stiffer", {"percent": 60.0, "torque_n_m": 0.5}),
        ("thermal_growth", "grow", "shrink", {"um_per_m_k": 30.0, "over_um": 180.147}),
        ("instrument_scale", "long", "short", {"um_per_m": 30.0}),
        ("link_bending", "lower", "higher", {"sag_mm": 0.06607452}),
        ("link_mass", "more", "less", {"extra_kg": 0.63, "stated_kg": 4.2}),
        ("payload", "more", "less", {"extra_kg": 0.405, "stated_kg": 2.7}),
    ],
)
def test_which_way_it_acts_is_another_sentence_with_the_same_figures(cause, more, less, figures):
    scene = scene_for(cause)
    candidate = CAUSES[cause].candidates(scene)[0]
    values = 0.3 * np.array([spec.prior_width for spec in candidate.specs])

    for sign, key in ((1.0, more), (-1.0, less)):
        fitted = FittedCause(candidate.names, sign * values, 1e-12 * np.diag(values**2))
        sentence = CAUSES[cause].describe(candidate.subject, fitted, scene).sentence
        said = dict(sentence.values)
        assert sentence.key == f"causes.{cause}.{key}"
        assert {name: said[name] for name in figures} == pytest.approx(figures, rel=1e-5)
