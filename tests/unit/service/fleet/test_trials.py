"""What speaks for a change, against one dense covariance of all readings and against a general optimiser."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.special import chdtrc

from tests.helpers.fleet.linear import Dense, drawn, told
from truepose.fleet.campaigns import FleetCampaign, fleet_of
from truepose.fleet.changes import account_of
from truepose.fleet.instrument_scales import InstrumentDays
from truepose.fleet.minimum_detectable_change import least_of_instruments
from truepose.fleet.mixed_model import Equations, Posterior, Variances
from truepose.fleet.trials import Evidence, Score, excess_of, largest_ratio, shapes

_ROBOT, _DAY = (0.3, 0.1, 0.1), 0.05


@pytest.fixture(scope="module")
def made():
    return drawn(1)


@pytest.fixture(scope="module")
def posterior(made):
    return Posterior(Equations(made.fleet()), Variances(np.array(_ROBOT), _DAY))


def test_score_and_chance_are_those_of_generalised_least_squares(made, posterior):
    dense = Dense(made)
    shape = np.where(posterior.equations.fleet.robot == 2, posterior.equations.fleet.day / 90.0, 0.0)
    of_row = np.where(dense.robots == 2, dense.days / 90.0, 0.0)
    moved = (dense.columns[[0, 2]] * of_row).T
    covariance = dense.covariance(_ROBOT, _DAY)
    score = moved.T @ np.linalg.solve(covariance, dense.read)
    information = moved.T @ np.linalg.solve(covariance, moved)
    directions = np.eye(4)[:, [0, 2]]

    found = Score(posterior, shape)

    assert directions.T @ found.score == pytest.approx(score, abs=1e-8)
    assert directions.T @ found.information @ directions == pytest.approx(information, rel=1e-8)
    expected = chdtrc(2, score @ np.linalg.solve(information, score))
    assert found.of(directions).judged()[1] == pytest.approx(expected, rel=1e-6)


@pytest.mark.parametrize("squares", [(9.0,), (9.0, 2.0), (4.0, 0.1, 12.0)])
def test_the_largest_ratio_is_that_of_a_general_optimiser(squares):
    information = np.array([3.0, 40.0, 0.5])[: len(squares)]
    known = np.array(squares)

    def against(log_size):
        wound = np.exp(log_size) * information
        return -float((known * wound / (1.0 + wound) - np.log1p(wound)).sum())

    best = min(
        minimize_scalar(against, bounds=(low, low + 4.0), method="bounded").fun for low in range(-12, 8, 2)
    )

    assert largest_ratio(known, information) == pytest.approx(-best, abs=0.02)  # a tenth between two sizes


def test_what_noise_explains_has_no_ratio():
    assert largest_ratio(np.array([0.9]), np.array([5.0])) == 0.0
    assert largest_ratio(np.array([0.5, 0.2]), np.array([5.0, 5.0])) == 0.0


def test_scores_that_scatter_more_than_stated_count_less():
    rng = np.random.default_rng(0)
    seen = [Evidence(1.5 * rng.chisquare(1.0, 2), np.ones(2)) for _ in range(400)]
    aged = [Evidence(np.array([900.0, 30.0]), np.ones(2)) for _ in range(20)]

    excess = excess_of([*seen, *aged])

    assert excess == pytest.approx(1.5, rel=0.2)  # the median of 400 to 7 %, and twenty of them beyond it
    assert excess_of([Evidence(0.5 * one.squares, one.information) for one in seen]) == 1.0
    assert aged[0].judged(excess)[0] < aged[0].judged()[0]


def test_two_campaigns_tell_no_line_from_a_step():
    day = np.array([0.0, 30.0, 0.0, 30.0, 60.0])

    found = list(shapes(day, np.array([True, True, False, False, False])))

    assert [(kind, since) for kind, since, _ in found] == [("step", 30.0)]


def test_a_line_may_begin_on_any_day_but_the_last_two_and_a_day_stands_between_others():
    day = np.array([0.0, 30.0, 60.0, 90.0])

    found = {(kind, since): shape.tolist() for kind, since, shape in shapes(day, day >= 0.0)}

    assert found == {
        ("linear", 0.0): pytest.approx([0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0]),
        ("linear", 30.0): [0.0, 0.0, 0.5, 1.0],
        ("step", 30.0): [0.0, 1.0, 1.0, 1.0],
        ("step", 60.0): [0.0, 0.0, 1.0, 1.0],
        ("step", 90.0): [0.0, 0.0, 0.0, 1.0],
        ("day", 30.0): [0.0, 1.0, 0.0, 0.0],
        ("day", 60.0): [0.0, 0.0, 1.0, 0.0],
    }


def test_of_many_days_lines_begin_on_a_dozen():
    day = np.arange(60.0)

    since = [at for kind, at, _ in shapes(day, day >= 0.0) if kind == "linear"]

    assert len(since) == 12
    assert (since[0], since[-1]) == (0.0, 57.0)


def test_a_tracker_that_drifts_is_beyond_chance_and_one_that_does_not_is_not():
    drifting = drawn(
        3, readings=40, day=0.02, drift=lambda i, k, month: np.array([0, 0, 0, 0.5 * month * (k == 1)])
    )
    fleet = drifting.fleet()
    days = InstrumentDays(Posterior(Equations(fleet), Variances(np.array([0.25, 0.04, 0.09]), 0.1)))
    instrument, day = (np.array(column) for column in zip(*fleet.visits, strict=True))

    ways = {k: next(iter(shapes(day, instrument == k)))[2] for k in (0, 1)}

    assert days.of(ways[1])[1] < 1e-4
    assert days.of(ways[0])[1] > 0.01


def test_two_trackers_that_change_at_once_are_told_by_both_together():
    moved = {0: lambda month: 0.25 * (month >= 4), 1: lambda month: 0.06 * month}
    steps = drawn(
        5,
        robots=8,
        months=8,
        readings=40,
        day=0.0,
        drift=lambda i, k, month: np.array([0, 0, 0, moved[k](month)]),
    )
    fleet = steps.fleet()
    days = InstrumentDays(Posterior(Equations(fleet), Variances(np.array([0.25, 0.04, 0.09]), 0.1)))
    instrument, day = (np.array(column) for column in zip(*fleet.visits, strict=True))
    step = next(one for kind, at, one in shapes(day, instrument == 0) if (kind, at) == ("step", 120.0))
    line = next(iter(shapes(day, instrument == 1)))[2]

    alone, together = min(days.of(step)[1], days.of(line)[1]), days.of(step, line)[1]

    assert together < 0.01 * alone


def test_readings_that_are_all_worse_than_stated_are_told_from_a_change():
    worse, changed = (
        Evidence(np.full(30, 3.0), np.ones(30)),
        Evidence(np.append(90.0, np.zeros(29)), np.ones(30)),
    )

    assert worse.scattered(1.0) == pytest.approx(30 * (2.0 - np.log(3.0)))
    assert worse.scattered(3.0) == 0.0
    assert worse.judged()[0] < worse.scattered(1.0) + 1e-9
    assert changed.scattered(1.0) == worse.scattered(1.0)


def without_scale(information):
    """A campaign as a ballbar or a gauge measures it: of the scale of a tracker it tells nothing."""
    kept = slice(len(information.specs) - 1)
    return replace(
        information,
        specs=information.specs[kept],
        owners=information.owners[kept],
        normal=information.normal[kept, kept],
        right=information.right[kept],
        motion_mm2=information.motion_mm2[kept, kept],
    )


def fleet_without_scale(blind):
    """A fleet of which some campaigns, by their numbers, tell nothing of the scale."""
    made = drawn(3, readings=40)
    rows = zip(made.jacobians, made.reads, made.robot, made.instrument, made.day, strict=True)
    return fleet_of([
        FleetCampaign(
            f"robot {i}",
            f"tracker {k}",
            day,
            without_scale(told(*of, made.specs)) if blind(number, k) else told(*of, made.specs),
        )
        for number, (*of, i, k, day) in enumerate(rows)
    ])


def test_instruments_whose_scale_no_reading_tells_do_not_change():
    account = account_of(fleet_without_scale(lambda number, k: True))

    least = least_of_instruments(account)

    assert not [one for one in account.named if one.change.scope == "instrument"]
    assert np.isinf(least.size_mm).all()


def test_one_instrument_is_judged_as_ever_beside_another_whose_scale_no_reading_tells():
    account = account_of(fleet_without_scale(lambda number, k: k == 0))

    least = least_of_instruments(account)
    size_mm = dict(zip(least.of, least.size_mm.tolist(), strict=True))

    assert np.isinf(size_mm["tracker 0"])
    assert 0.0 < size_mm["tracker 1"] < np.inf
