"""The gain on points that neither choice nor parameters saw."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import START
from tests.helpers.diagnosis.selections import make_start, select_from, started, those_of, with_unseen
from tests.helpers.identification.synthetic import NOISE_MM
from truepose.diagnosis.evidence.cross_validation import Nested, as_found, partition
from truepose.diagnosis.evidence.held_out_errors import (
    CrossValidation,
    Improvement,
    gain_of,
    on_validation,
)
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.selection import chosen, group_by_subject
from truepose.domain.diagnosis import Gain, HeldOutErrors
from truepose.identification.fit.robust import fit
from truepose.identification.observations.poses import position_block

GAIN_4 = {"joint_gain": {"gain_4": 1e-3}}


def drawn(before_mm, after_mm, rng, sites=60, per_site=3):
    """Errors whose configurations share half of their variance."""
    site = np.repeat(np.arange(sites), per_site)
    shared, own = rng.standard_normal((2, len(site), 1))
    shared = shared[site * per_site]
    return before_mm * (shared + own) / np.sqrt(2.0), after_mm * own, site


def test_rms_before_and_after_are_those_of_the_points():
    before, after, site = drawn(2.0, 1.0, np.random.default_rng(0))

    gain = gain_of(before, after, site)

    assert gain.rms_before_mm == pytest.approx(np.sqrt((before**2).mean()))
    assert gain.rms_after_mm == pytest.approx(np.sqrt((after**2).mean()))


def test_the_error_of_a_point_is_that_of_its_vector():
    before, site = np.full((10, 3), 1.0), np.arange(10)

    assert gain_of(before, 0.0 * before, site).rms_before_mm == pytest.approx(np.sqrt(3.0))


def _improved(before_mm, after_mm, noise_mm, components=3, described=None, n=20_000):
    """Held-out errors of so large a standard deviation per axis, before and after."""
    unit = np.random.default_rng(8).standard_normal((n, components))
    errors = HeldOutErrors(np.arange(n), np.zeros((n, 3)), before_mm * unit, after_mm * unit)
    mean = np.linalg.norm(noise_mm * unit, axis=1).mean()
    return Improvement(errors, (), (), np.arange(n), mean, "validation", described=described)


@pytest.mark.parametrize("components", [1, 3])
def test_the_share_that_has_a_name_is_of_the_squared_error_beyond_the_noise(components):
    # 5^2 - 3^2 of 5^2 - 1^2
    assert _improved(5.0, 3.0, 1.0, components).named_share == pytest.approx(16.0 / 24.0, rel=0.01)
    assert _improved(5.0, 1.0, 1.0, components).named_share == pytest.approx(1.0, abs=0.01)
    assert _improved(5.0, 6.0, 1.0, components).named_share == 0.0


def test_what_is_described_has_no_name_and_noise_needs_none():
    described = Gain(4.0 * np.sqrt(3.0), 3.0 * np.sqrt(3.0), (0.0, 0.0))
    assert _improved(5.0, 3.0, 1.0, described=described).named_share == pytest.approx(9.0 / 24.0, rel=0.01)
    assert _improved(1.0, 1.0, 1.2).named_share is None


def test_the_interval_covers_the_true_gain():
    rng = np.random.default_rng(3)
    covered = 0
    for _ in range(200):
        low, high = gain_of(*drawn(2.0, 1.0, rng)).interval_95_mm
        covered += low <= 1.0 <= high

    # 95 % of 200 is 190, sd 3.1; percentile intervals of 60 configurations lose two or three per cent
    assert 174 <= covered <= 199


def test_readings_of_one_configuration_count_as_one():
    rng = np.random.default_rng(4)
    before, after, site = drawn(2.0, 1.0, rng, per_site=1)
    tripled = gain_of(np.repeat(before, 3, axis=0), np.repeat(after, 3, axis=0), np.repeat(site, 3))

    assert tripled.interval_95_mm == pytest.approx(gain_of(before, after, site).interval_95_mm)


def test_an_interval_above_zero_is_rare_where_nothing_was_gained():
    rng = np.random.default_rng(5)
    above = 0
    for _ in range(100):
        before, _, site = drawn(1.0, 1.0, rng)
        other, _, _ = drawn(1.0, 1.0, rng)
        above += gain_of(before, other, site).interval_95_mm[0] > 0.0

    assert above <= 9  # 2.5 expected, percentile intervals are a little short; sd 1.6


@pytest.fixture(scope="module")
def start():
    return make_start(GAIN_4)


@pytest.fixture(scope="module")
def first(start):
    return chosen(pool_candidates(start.fit, propose_for(start)(start.fit)))


@pytest.fixture(scope="module")
def selected(start):
    return select_from(start, propose_for(start))


@pytest.fixture(scope="module")
def judged_elsewhere():
    """A start with forty validation readings of configurations of their own, and what was picked."""
    start = started(with_unseen(GAIN_4), START)
    return start, select_from(start, propose_for(start))


def propose_for(start):
    return those_of(start, "backlash", "joint_gain")


def groups_of(selected):
    return tuple(group for _, group in group_by_subject(selected.picks))


@pytest.mark.parametrize("in_time", [False, True])
def test_every_configuration_is_held_out_once(start, in_time):
    parts = partition(start.fit, in_time=in_time)

    assert [len(part) for part in parts] == [16] * 5
    configurations = start.campaign.calibration.stops.config
    assert np.array_equal(np.sort(np.concatenate(parts)), np.unique(configurations))


def test_parts_in_time_follow_one_another(start):
    stops = start.campaign.calibration.stops
    measured = [stops.time_s[np.isin(stops.config, part)] for part in partition(start.fit, in_time=True)]

    assert all(before.max() < after.min() for before, after in itertools.pairwise(measured))


def test_a_fold_errs_as_a_fit_that_never_saw_it(start, first):
    parts = partition(start.fit, in_time=False)

    errors = Nested(first, parts)

    out = np.isin(start.campaign.calibration.stops.config, parts[2])
    blocks = (start.fit.blocks[0].taken(np.flatnonzero(~out)), *start.fit.blocks[1:])
    again = fit(start.fit.structure, blocks, start.fit.values)
    held = start.fit.blocks[0].taken(np.flatnonzero(out)).result(start.fit.structure, again.values, None)
    # to first order: the parameters move by hundredths of a mm and of a mrad
    assert errors.start[out] == pytest.approx(held.residual, abs=1e-4)


def test_a_held_out_reading_cannot_move_its_own_prediction(start, first):
    parts = partition(start.fit, in_time=False)
    plain = Nested(first, parts)
    block = start.fit.blocks[0]
    moved = block.measured_mm.copy()
    moved[7] += [0.03, 0.0, 0.0]
    blocks = (replace(block, measured_mm=moved), *start.fit.blocks[1:])
    solution = fit(start.fit.structure, blocks, start.fit.values)
    off = replace(start.fit, blocks=blocks, solution=solution)

    changed = Nested(chosen(pool_candidates(off, propose_for(start)(off))), parts)

    # what is read differently is all that its errors change by; its fold never saw it
    for kind in ("start", "chosen", "described"):
        before, after = getattr(plain, kind), getattr(changed, kind)
        assert after[7] - before[7] == pytest.approx([0.03, 0.0, 0.0], abs=1e-4)


def test_what_is_held_out_takes_no_part_in_the_choice():
    """A wave is planted in one fold only: no other fold may foretell it, so it never helps that one."""
    start = make_start({})
    parts = partition(start.fit, in_time=True)
    block = start.fit.blocks[0]
    held = np.isin(block.targets.stops.config, parts[0])
    off = replace(block, measured_mm=block.measured_mm + 0.3 * held[:, None])
    solution = fit(start.fit.structure, (off, *start.fit.blocks[1:]), start.fit.values)
    spoilt = replace(start.fit, blocks=(off, *start.fit.blocks[1:]), solution=solution)

    errors = Nested(chosen(pool_candidates(spoilt, propose_for(start)(spoilt))), parts)

    assert errors.chosen[held] == pytest.approx(errors.start[held], abs=1e-12)


def test_cross_validation_gives_the_gain_of_a_planted_cause_to_it(first, selected):
    judged = CrossValidation(first).of(selected, groups_of(selected))

    gain = judged.gains[0]

    assert judged.source == "cross_validation"
    assert gain.interval_95_mm[0] > 0.0
    assert judged.together.interval_95_mm[0] > 0.0
    assert gain.rms_before_mm == pytest.approx(judged.together.rms_before_mm, rel=0.05)
    # noise of three components; forty parameters from 240 components add a tenth to a sixth
    assert np.sqrt(3) * NOISE_MM < gain.rms_after_mm < 1.35 * np.sqrt(3) * NOISE_MM


def test_nothing_chosen_is_the_start_model(first, selected):
    judged = CrossValidation(first).of(selected, ())

    assert np.array_equal(judged.errors.after_mm, judged.errors.before_mm)
    assert judged.gains == ()


def test_a_model_as_found_errs_without_a_cause_as_a_fit_without_it(start, selected):
    parts = partition(selected.fit, in_time=False)

    errors = as_found(selected.fit, parts, [("gain_4",)])[0]

    out = np.isin(start.campaign.calibration.stops.config, parts[1])
    blocks = (selected.fit.blocks[0].taken(np.flatnonzero(~out)), *selected.fit.blocks[1:])
    again = fit(start.fit.structure, blocks, start.fit.values)
    held = selected.fit.blocks[0].taken(np.flatnonzero(out))
    expected = held.result(start.fit.structure, again.values, None).residual
    # to first order: the gain turns by up to 2.6 mrad and moves derivatives by as much of 0.5 mm
    assert errors.before[out] == pytest.approx(expected, abs=2e-3)
    assert np.abs(errors.after[out]).mean() < 0.5 * np.abs(errors.before[out]).mean()


def test_validation_readings_judge_in_the_end_where_there_are_some(judged_elsewhere):
    start, selected = judged_elsewhere
    campaign = start.campaign

    judged = on_validation(campaign, (start.fit, selected.fit), selected, groups_of(selected))

    assert judged is not None
    assert judged.source == "validation"
    assert len(judged.errors.config) == 40
    assert judged.gains[0].interval_95_mm[0] > 0.0
    # without its only finding: what a fit of the start would give that weighs the readings alike
    structure = start.fit.structure
    again = fit(structure, selected.fit.blocks, start.fit.values)
    without = (
        position_block(campaign.validation, campaign.scatter_mm)
        .result(structure, again.values, None)
        .residual
    )
    expected_mm = float(np.sqrt((without**2).sum(axis=1).mean()))
    # to first order, as above
    assert judged.gains[0].rms_before_mm == pytest.approx(expected_mm, abs=2e-3)
    assert judged.described is None


def test_what_is_described_is_judged_beside_what_was_found(judged_elsewhere):
    start, selected = judged_elsewhere

    # the start in the place of a description: it gives away what was found
    judged = on_validation(start.campaign, (start.fit, start.fit), selected, groups_of(selected))

    assert judged is not None
    assert judged.described is not None
    assert judged.described.rms_before_mm == pytest.approx(judged.gains[0].rms_after_mm)
    assert judged.described.rms_after_mm == pytest.approx(judged.together.rms_before_mm)
    assert judged.described.interval_95_mm[1] < 0.0


def test_without_validation_readings_there_is_nothing_to_ask_in_the_end(start, selected):
    assert on_validation(start.campaign, (start.fit, selected.fit), selected, groups_of(selected)) is None
