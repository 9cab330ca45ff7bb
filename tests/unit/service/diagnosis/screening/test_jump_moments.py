"""A jump is placed in the very gap between two stops, also where not every gap was tried."""

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import everything, make_start, select_from
from tests.helpers.identification.synthetic import NOISE_MM
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.refinement import with_exact_moments
from truepose.diagnosis.screening.selection import Selection, refit_picks

READINGS = 130  # 123 gaps have readings enough beside them: every third is tried


def times(start):
    return np.sort(start.campaign.calibration.stops.time_s)


def jumped(after):
    """A start whose joint 3 jumped after a number of readings, with everything that is proposed."""
    plain = times(make_start({}, n=READINGS))
    middle_s = 0.5 * (plain[after - 1] + plain[after])
    start = make_start({"unnamed": {f"cell_jump_3_{middle_s:.0f}_turn": 1.5e-4}}, n=READINGS)
    return start, middle_s, everything(start)


@pytest.mark.parametrize("after", [40, 41, 42, 87])
def test_a_jump_is_placed_in_the_gap_in_which_it_happened(after):
    start, middle_s, propose = jumped(after)
    selected = select_from(start, propose)

    placed = with_exact_moments(start.fit, selected, propose, start.scene)

    (pick,) = placed.picks
    assert pick.subject == "joint 3, time, jump"
    assert pick.variant == pytest.approx(middle_s, abs=1e-6)
    assert not placed.fit.gross[0].any()  # readings on the wrong side of it would pass for bad ones
    assert np.abs(placed.fit.results[0].residual).max() < 6.0 * NOISE_MM


def test_without_a_jump_nothing_is_placed():
    start = make_start({"joint_gain": {"gain_4": 1e-3}})
    propose = everything(start)
    selected = select_from(start, propose)

    assert with_exact_moments(start.fit, selected, propose, start.scene) is selected


def test_two_jumps_that_meet_in_one_gap_are_one_jump():
    start, middle_s, propose = jumped(after=41)
    subject = "joint 3, time, jump"
    tried = sorted((one for one in propose(start.fit) if one.subject == subject), key=lambda one: one.variant)
    before = [one for one in tried if one.variant < middle_s - 1.0][-1]
    after = next(one for one in tried if one.variant > middle_s + 1.0)
    fit = refit_picks(start.fit, start.fit, (before, after))
    selected = Selection(
        fit, (before, after), pool_candidates(fit, (before, after, *propose(fit))), full=False
    )

    placed = with_exact_moments(start.fit, selected, propose, start.scene)

    (pick,) = placed.picks
    assert pick.variant == pytest.approx(middle_s, abs=1e-6)
    assert len(set(placed.fit.structure.names)) == len(placed.fit.structure.names)
