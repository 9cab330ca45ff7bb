"""Configurations that expose rivals, against least squares done the long way."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.point_scenes import START
from tests.helpers.diagnosis.selections import make_selected, make_start
from truepose.diagnosis.configurations import draw_configurations, measured_ranges
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.t_optimality import reading_variance, separation
from truepose.domain.diagnosis import Cause
from truepose.effects.registry import CAUSES
from truepose.identification.model.derivatives import (
    candidate_terms,
    position_jacobian,
    trial_derivatives,
    tried,
)

GAIN = ("joint_gain", "joint 4")
WAVE = ("joint_harmonics", "joint 4", "wave_4_1_sin")
RIVAL = Cause("joint_harmonics", "joint 4")


@pytest.fixture(scope="module")
def scene():
    start = make_start({"joint_gain": {"gain_4": 1e-3}}, present=START)
    selected = make_selected(start, [GAIN], [WAVE])
    return (
        start,
        selected,
        draw_configurations(start, selected, measured_ranges(start), 40, np.random.default_rng(1)),
    )


def _smallest_sum_of_squares(selected, places, rows):
    """What the rival leaves of the gain, fitted to the measured rows and to new ones, priors included."""
    fit, (pick,) = selected.fit, selected.picks
    own = np.isin(fit.structure.names, pick.names)
    rival = next(candidate for candidate in selected.pool.all if candidate.effect == RIVAL.effect)
    index = selected.pool.all.index(rival)
    jacobian = fit.solution.final.jacobian
    state = places.state
    terms = candidate_terms(state, rival.effect, rival.names, 0)
    there = trial_derivatives(position_jacobian(tried(state, rival.specs, terms)), state)
    present = position_jacobian(state)
    spread = np.sqrt(reading_variance(fit))
    new = np.concatenate([present[~own], there])[:, rows].reshape(jacobian.shape[0] - 1 + len(there), -1)
    effect_new = (fit.values[own] @ present[own][:, rows].reshape(1, -1)) / spread
    columns = np.hstack([np.concatenate([jacobian[~own], selected.pool.rows(index)]), new / spread])
    effect = np.concatenate([fit.values[own] @ jacobian[own], effect_new])
    widths = np.concatenate([
        fit.structure.prior_widths[~own], [spec.prior_width for spec in rival.specs]
    ])  # fmt: skip
    scale = np.abs(columns).max(axis=1)  # the widths of geometry and springs are ten orders apart
    design = np.vstack([(columns / scale[:, None]).T, np.diag(1.0 / (widths * scale))])
    target = np.append(effect, np.zeros(len(widths)))
    fitted = np.linalg.lstsq(design, target, rcond=None)[0]
    return float(((target - design @ fitted) ** 2).sum())


def test_the_expected_chi_square_is_what_new_readings_add_to_the_rivals_sum_of_squares(scene):
    _, selected, places = scene

    found = separation(selected, selected.picks, [RIVAL], places)

    rows = list(found.rows)
    added = _smallest_sum_of_squares(selected, places, rows) - _smallest_sum_of_squares(selected, places, [])
    # Both are exact; normal equations of condition 1e8 leave about eight digits.
    assert found.chi_square[0] == pytest.approx(added, rel=1e-5)


def test_the_first_configuration_is_the_best_of_all(scene):
    _, selected, places = scene
    before = _smallest_sum_of_squares(selected, places, [])
    each = [_smallest_sum_of_squares(selected, places, [row]) - before for row in range(40)]

    found = separation(selected, selected.picks, [RIVAL], places)

    assert found.rows[0] == int(np.argmax(each))


def test_no_more_configurations_are_chosen_once_the_rival_is_exposed():
    start = make_start({"joint_gain": {"gain_4": 1e-3}})
    coupling = ("joint_coupling", "joint 4")
    selected = make_selected(start, [GAIN], [coupling])
    places = draw_configurations(start, selected, measured_ranges(start), 300, np.random.default_rng(2))

    found = separation(selected, selected.picks, [Cause(*coupling)], places)

    # A gain of 1e-3 at 90 deg moves a nest at 150 mm by 0.24 mm, sixteen times the noise: three suffice.
    assert len(found.rows) == 3
    assert found.chi_square[0] >= 25.0


def test_repeats_take_the_noise_down_but_not_what_the_model_lacks(scene):
    _, selected, _ = scene
    lacking = selected.fit.blocks[0].discrepancy ** 2

    once, four = (reading_variance(selected.fit, repeats) for repeats in (1, 4))

    assert four - lacking == pytest.approx((once - lacking) / 4.0)


def test_of_several_ways_in_which_a_rival_may_act_the_closest_is_taken():
    start = make_start({"joint_gain": {"gain_4": 1e-3}})
    one, many = (
        make_selected(start, [GAIN], [(RIVAL.effect, RIVAL.subject, first)])
        for first in ("wave_4_1_sin", None)
    )
    places = draw_configurations(start, one, measured_ranges(start), 40, np.random.default_rng(1))

    slow = separation(one, one.picks, [RIVAL], places)
    closest = separation(many, many.picks, [RIVAL], places)

    # Of a hundred orders the slowest bends least over the range, and is the best mimic of a line.
    assert closest.rows == slow.rows
    assert closest.chi_square == pytest.approx(slow.chi_square)


def test_no_configuration_exposes_a_curve_of_any_shape(scene):
    """It mimics everything, so it is left out; the others are exposed as if it were none."""
    start, selected, places = scene
    curve = next(one for one in CAUSES[RIVAL.effect].candidates(start.scene) if one.function)
    assert Cause(curve.effect, curve.subject) != RIVAL
    selected = replace(selected, pool=pool_candidates(selected.fit, (*selected.pool.all, curve)))
    any_shape = Cause(curve.effect, curve.subject)

    alone = separation(selected, selected.picks, [RIVAL], places)
    beside = separation(selected, selected.picks, [any_shape, RIVAL], places)
    nothing_else = separation(selected, selected.picks, [any_shape], places)

    assert (beside.rows, beside.chi_square.tolist()) == (alone.rows, [0.0, *alone.chi_square])
    assert (nothing_else.rows, nothing_else.chi_square.tolist()) == ((), [0.0])
