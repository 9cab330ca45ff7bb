"""Where no angle was read a model with waves says that it does not know; elsewhere it says what it said."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.answers import make_described, make_rest
from tests.helpers.diagnosis.diagnosed_cells import make_finding
from tests.helpers.diagnosis.selections import left_of, make_selected, make_start
from truepose.diagnosis.answer import _worse_at
from truepose.diagnosis.confidence import with_open_shapes
from truepose.diagnosis.evidence.held_out_errors import Improvement
from truepose.diagnosis.sentences import first_line, remaining_sentence
from truepose.domain.diagnosis import HeldOutErrors, Remaining, Verdict, WorstPoint
from truepose.domain.identification import Statistics
from truepose.messages.catalogue import english


def test_where_readings_are_the_uncertainty_stays_what_it_was():
    start = make_start({"joint_harmonics": {"wave_4_2_sin": 5e-4, "wave_4_2_cos": 0.0}}, n=120)
    fit = make_selected(start, [("joint_harmonics", "joint 4", "wave_4_2_sin")]).fit

    opened = with_open_shapes(fit, fit)

    known = len(fit.values)
    assert opened.values[:known] == pytest.approx(fit.values)
    assert not opened.values[known:].any()
    told = np.sqrt(np.diag(opened.solution.covariance)[:known] / np.diag(fit.solution.covariance))
    assert (told >= 1.0 - 1e-9).all()
    prediction = opened.solution.final.jacobian  # whitened, at the readings themselves
    before = np.einsum("pm,pq,qm->m", prediction[:known], fit.solution.covariance, prediction[:known])
    after = np.einsum("pm,pq,qm->m", prediction, opened.solution.covariance, prediction)
    assert np.sqrt(after.mean() / before.mean()) < 1.6


def test_a_model_without_waves_is_left_as_it_is():
    start = make_start({"joint_gain": {"gain_4": 1e-3}})

    assert with_open_shapes(start.fit, start.fit) is start.fit


def judged(before_mm, after_mm):
    n = len(before_mm)
    errors = HeldOutErrors(
        np.arange(1, n + 1), np.zeros((n, 3)), np.outer(before_mm, [1, 0, 0]), np.outer(after_mm, [1, 0, 0])
    )
    return Improvement(errors, (), (), np.arange(n), 0.02, "validation")


def test_a_point_that_is_far_worse_than_any_before_is_named():
    before, after = np.full(50, 0.5), np.full(50, 0.1)
    before[7], after[30] = 1.30, 8.58

    found = _worse_at(judged(before, after))

    assert (found.config, found.before_mm, found.after_mm) == (31, 0.5, 8.58)


@pytest.mark.parametrize("largest_after", [0.6, 1.3, 1.38])
def test_another_draw_of_the_noise_is_not_named(largest_after):
    before, after = np.full(50, 0.5), np.full(50, 0.1)
    before[7], after[30] = 1.30, largest_after

    assert _worse_at(judged(before, after)) is None


def test_the_first_line_says_where_more_than_the_finding_makes_errors_smaller():
    statistics = Statistics(50, 0.5, 0.5, 0.1, 1.3, 0.02)
    rest, nothing = make_rest(make_described()), make_rest()

    beside, alone = (
        english(first_line(Verdict.PARTLY_EXPLAINED, (make_finding(),), statistics, statistics, left, share))
        for left, share in ((rest, 0.914), (nothing, None))
    )

    assert "Including it and an empirical description of the residuals changes the mean error" in beside
    assert "Including it changes the mean error" in alone
    assert beside.endswith("account for 91% of the error beyond the noise; the rest remains unexplained.")
    assert alone.endswith("Part of the error remains unexplained.")


def test_the_first_line_names_the_point_that_got_worse():
    worse = WorstPoint(31, 1.30, 8.58)
    left = left_of(make_start({}), make_selected(make_start({}), []))
    told = remaining_sentence(replace(left, worse_at=worse), full=False)
    statistics = Statistics(50, 0.5, 0.5, 0.1, 1.3, 0.02)
    remaining = Remaining(True, (), told, worse)

    line = english(
        first_line(Verdict.PARTLY_EXPLAINED, (make_finding(),), statistics, statistics, remaining, 0.9)
    )

    assert replace(left, worse_at=worse).structure
    assert "configuration 31" in line
    assert "from 1.30 to 8.58 mm" in line
