"""Lengths under effects of ballbar, fixture and base: predicted as geometry says, differentiated exactly."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from tests.helpers.diagnosis.leg_scenes import LEG_START, PER_PLACEMENT, leg_scene, telling_legs
from tests.helpers.identification.differences import require_alike
from truepose.effects.registry import CAUSES
from truepose.identification import identify, judge
from truepose.identification.problem.build import build
from truepose.kinematics.frames import rotation_xyz

ON_LENGTHS = ("ballbar_zero", "fixture_shift", "base_drift", "base_shift")


@cache
def extended():
    """The problem of the telling legs with two candidates of each cause."""
    problem = build(telling_legs(), (*LEG_START, "instrument_scale"))
    structure, start = problem.structure, problem.start
    for cause in ON_LENGTHS:
        for candidate in CAUSES[cause].candidates(leg_scene())[:2]:
            structure = structure.extended(cause, candidate.specs)
            start = np.concatenate([start, np.zeros(len(candidate.specs))])
    return replace(problem, structure=structure, start=start)


def at(problem, **values):
    full = problem.start.copy()
    for name, value in values.items():
        full[problem.structure.index_of(name)] = value
    return full


def predicted(problem, values):
    (block,) = problem.blocks
    return block.length_mm - block.result(problem.structure, values, None).residual[:, 0]


def test_every_effect_on_lengths_is_differentiated_exactly():
    problem = extended()
    structure = problem.structure
    rng = np.random.default_rng(3)
    anchors = np.char.startswith(np.array(structure.names), "anchor")
    steps = np.where(anchors, 0.03, 0.3) * structure.prior_widths
    values = problem.start + steps * rng.standard_normal(len(problem.start))

    require_alike(structure, problem.blocks, values)


def test_a_fixture_that_moved_takes_its_base_nests_along():
    problem = extended()
    name = next(name for name in problem.structure.names if name.startswith("fixture_1_"))
    prefix = name.rsplit("_", 1)[0]
    moved = at(problem, **{f"{prefix}_x": 0.7, f"{prefix}_rz": 2e-3, f"{prefix}_ry": -1e-3})
    anchor = np.array([problem.start[problem.structure.index_of(f"anchor_1_1_{axis}")] for axis in "xyz"])
    there = rotation_xyz(0.0, -1e-3, 2e-3) @ anchor + [0.7, 0.0, 0.0]
    elsewhere = at(problem, **{f"anchor_1_1_{axis}": x for axis, x in zip("xyz", there, strict=True)})

    lengths = predicted(problem, moved)

    first = int(np.searchsorted(problem.blocks[0].targets.stops.time_s, float(prefix.rsplit("_", 1)[1])))
    assert 0 < first < PER_PLACEMENT
    after = slice(first, PER_PLACEMENT)
    assert lengths[after] == pytest.approx(predicted(problem, elsewhere)[after], abs=1e-9)
    still = np.delete(np.arange(len(lengths)), after)
    assert lengths[still] == pytest.approx(predicted(problem, problem.start)[still], abs=1e-12)


def test_what_a_ballbar_reads_too_much_is_part_of_the_predicted_length():
    problem = extended()

    more = predicted(problem, at(problem, zero_2=0.05, ballbar_scale=1e-4))

    here = problem.blocks[0].targets.initialisation == 2
    excess = 0.05 * here + 1e-4 * problem.blocks[0].length_mm
    assert more - predicted(problem, problem.start) == pytest.approx(excess, abs=1e-9)


def test_a_part_of_the_lengths_keeps_what_their_effects_depend_on():
    targets = extended().blocks[0].targets
    rows = np.array([3, 40])

    some = targets.taken(rows)

    assert some.placement.tolist() == [1, 2]
    assert some.initialisation.tolist() == [1, 7]
    assert some.length_mm.tolist() == targets.length_mm[rows].tolist()


def test_a_model_with_zeros_predicts_the_lengths_that_it_was_made_from():
    campaign = telling_legs()
    legs = campaign.legs
    zeros = 0.2 * np.random.default_rng(1).standard_normal(11)
    off = replace(campaign, legs=replace(legs, length_mm=legs.length_mm + zeros[legs.initialisation]))

    model = identify(off, (*LEG_START, "ballbar_zero")).model

    residual = judge(model, off.legs, 0.0).identified_mm[:, 0]
    unnumbered = judge(model, replace(off.legs, initialisation=None), 0.0).identified_mm[:, 0]
    # noise 0.005 mm; the zeros are 0.2 mm
    assert np.sqrt(np.mean(residual**2)) < 0.01
    assert np.sqrt(np.mean(unnumbered**2)) > 0.05
