"""Selection: what was planted is picked, nothing else, and nothing where nothing is."""

import numpy as np
import pytest

from tests.helpers.diagnosis.selections import everything, make_selected, make_start, select_from, those_of
from truepose.diagnosis.screening.candidates import pool_candidates
from truepose.diagnosis.screening.selection import best_of, chosen, refit_picks, reselect, select
from truepose.diagnosis.screening.significance import Screening

BACKLASH = {"gap_3": 4e-4}


def named(picks):
    return [(pick.effect, pick.subject) for pick in picks]


@pytest.fixture(scope="module")
def start():
    return make_start({"joint_gain": {"gain_4": 1e-3}, "backlash": BACKLASH})


@pytest.fixture(scope="module")
def selected(start):
    return select_from(start, everything(start))


@pytest.mark.parametrize(
    ("effect", "parameters", "subject"),
    [
        ("joint_gain", {"gain_5": 1e-3}, "joint 5"),
        ("backlash", BACKLASH, "joint 3"),
        ("joint_harmonics", {"wave_6_3_sin": 5e-4}, "joint 6"),
    ],
)
def test_a_planted_cause_is_picked_alone(effect, parameters, subject):
    start = make_start({effect: parameters})

    assert named(select_from(start, everything(start)).picks) == [(effect, subject)]


@pytest.mark.parametrize(("shape", "rate"), [("linear", 0.06), ("exp300", 0.6)])
@pytest.mark.parametrize("seed", [1, 2, 3, 4, 5, 6])
def test_a_drift_settles_only_where_it_is_seen_to(shape, rate, seed):
    start = make_start({"base_drift": {f"drift_{shape}_x": rate, f"drift_{shape}_y": -rate}}, seed=seed)

    (pick,) = select_from(start, those_of(start, "base_drift")).picks

    assert ("exp" in pick.names[0]) == ("exp" in shape)  # a time constant is told to a step of two


def test_two_planted_causes_are_both_picked_and_fitted(selected):
    assert sorted(named(selected.picks)) == [("backlash", "joint 3"), ("joint_gain", "joint 4")]
    fit = selected.fit
    for name, true in {"gain_4": 1e-3, **BACKLASH}.items():
        index = fit.structure.index_of(name)
        # 80 readings state the uncertainty of each well: four of these
        assert fit.values[index] == pytest.approx(
            true, abs=4 * np.sqrt(fit.solution.covariance[index, index])
        )


@pytest.mark.parametrize("seed", [3, 4, 5])
def test_noise_alone_gives_no_name(seed):
    start = make_start({}, seed=seed)

    found = select_from(start, everything(start))

    assert found.picks == ()
    assert found.fit is start.fit
    assert not found.full


def test_few_readings_do_not_carry_more_parameters_and_that_is_said():
    start = make_start({"joint_gain": {"gain_4": 1e-3}}, n=18)

    found = select_from(start, everything(start))

    # 18 readings and 18 of fixed nests have 108 components; every parameter needs two
    assert 2 * len(found.fit.structure.names) <= 108
    assert found.full


def test_progress_is_told_and_never_goes_back(start):
    told = []

    select(chosen(pool_candidates(start.fit, everything(start)(start.fit))), everything(start), told.append)

    assert told[0] == 0.0
    assert told == sorted(told)
    assert told[-1] <= 1.0


def screened(p_values, scores):
    ones = np.ones(len(p_values))
    return Screening(ones, ones, ones, np.array(p_values), np.array(scores), ones)


@pytest.mark.parametrize(
    ("p_values", "scores", "best"),
    [
        ([], [], None),
        ([0.3, 1.0], [5.0, 9.0], None),  # no more than chance
        ([1e-6, 1e-9], [-1.0, -0.5], None),  # not worth the parameters
        ([1e-6, 1e-9, 0.3], [8.0, 3.0, 40.0], 0),
    ],
)
def test_the_best_is_the_one_of_best_score_among_those_beyond_chance(p_values, scores, best):
    assert best_of(screened(p_values, scores)) == best


def test_a_kept_pick_is_fitted_again_without_the_others(start, selected):
    kept = tuple(pick for pick in selected.picks if pick.effect == "backlash")

    again = reselect(start.fit, selected, kept, everything(start))

    assert again.picks == kept
    assert "gain_4" not in again.fit.structure.names
    assert "gap_3" in again.fit.structure.names


def test_keeping_nothing_is_the_start(start, selected):
    again = reselect(start.fit, selected, (), everything(start))

    assert again.picks == ()
    assert again.fit is start.fit


def test_a_pick_that_is_not_worth_it_is_not_kept(start):
    useless = make_selected(start, [("nest_offset", "nest 2"), ("joint_gain", "joint 4")])

    again = reselect(start.fit, useless, useless.picks, everything(start))

    assert named(again.picks) == [("joint_gain", "joint 4")]


def test_a_refit_starts_from_what_is_known(start, selected):
    again = refit_picks(start.fit, selected.fit, selected.picks)

    # what the solver left open the first time, in units of each uncertainty
    moved = (again.values - selected.fit.values) / np.sqrt(np.diag(selected.fit.solution.covariance))
    assert np.abs(moved).max() < 0.1
