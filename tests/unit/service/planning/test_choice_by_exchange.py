"""The choice by exchange, against brute force and at its edges."""

import math
from itertools import combinations

import numpy as np
import pytest

from truepose.domain.errors import ConfigurationError
from truepose.planning.errors import TooFewCandidatesError
from truepose.planning.exchange_algorithm import choose_by_exchange, rank_substitutes
from truepose.planning.observability import observability_o1


def candidates(n, rows=3, parameters=4, seed=0):
    """Blocks of very different size, so that the choice matters."""
    rng = np.random.default_rng(seed)
    return rng.standard_normal((n, rows, parameters)) * rng.uniform(0.1, 3.0, (n, 1, 1))


def o1(jacobians, indices):
    chosen = jacobians[list(indices)]
    return observability_o1(chosen.reshape(-1, chosen.shape[2]), len(chosen))


def o1_of_choice(jacobians, n, seed):
    """Return O1 of what is chosen from a random start."""
    return o1(jacobians, choose_by_exchange(jacobians, n, np.random.default_rng(seed)).indices)


def best_of_all(jacobians, n):
    return max(o1(jacobians, indices) for indices in combinations(range(len(jacobians)), n))


@pytest.mark.parametrize("rows", [1, 2, 3])
@pytest.mark.parametrize("seed", range(5))
def test_no_single_exchange_raises_the_index_any_further(rows, seed):
    jacobians = candidates(14, rows, seed=seed)

    selection = choose_by_exchange(jacobians, 6, np.random.default_rng(seed))

    inside, outside = set(selection.indices), set(range(14)) - set(selection.indices)
    neighbours = [inside - {leaving} | {entering} for leaving in inside for entering in outside]
    best = max(o1(jacobians, indices) for indices in neighbours)
    # the exchange stops at a gain of 1e-6 in log det: 1e-6 / 8 relative in O1
    assert best <= o1(jacobians, selection.indices) * (1 + 1e-6)


@pytest.mark.parametrize("seed", range(8))
def test_the_best_of_a_few_starts_is_the_best_of_all_sets(seed):
    jacobians = candidates(9, seed=100 + seed)

    found = max(o1_of_choice(jacobians, 4, k) for k in range(6))

    assert found == pytest.approx(best_of_all(jacobians, 4), rel=1e-6)


def test_a_start_that_is_best_already_is_left_alone():
    jacobians = candidates(9, seed=3)
    best = max(combinations(range(9), 4), key=lambda indices: o1(jacobians, indices))

    selection = choose_by_exchange(jacobians, 4, np.random.default_rng(0), start=np.array(best))

    assert selection.exchanges == 0
    assert tuple(selection.indices) == best


def test_a_start_that_leaves_parameters_undetermined_is_left_behind():
    jacobians = candidates(30, seed=4)
    jacobians[:6, :, 3] = 0.0  # the start sees nothing of the fourth parameter
    blind = np.arange(6)

    selection = choose_by_exchange(jacobians, 6, np.random.default_rng(0), start=blind)

    assert o1(jacobians, blind) == 0.0
    assert o1(jacobians, selection.indices) > 0.5 * max(o1_of_choice(jacobians, 6, k) for k in range(5))


def test_a_set_that_is_just_large_enough_can_still_change():
    # four rows of one for four parameters: without any member the rest is singular
    jacobians = candidates(12, rows=1, seed=5)

    found = max(o1_of_choice(jacobians, 4, k) for k in range(6))

    assert found == pytest.approx(best_of_all(jacobians, 4), rel=1e-5)


def test_a_parameter_that_nobody_sees_does_not_disturb_the_choice_of_the_others():
    seen = candidates(14, seed=6)
    unseen = np.concatenate([seen, np.zeros((14, 3, 1))], axis=2)

    with_it = choose_by_exchange(unseen, 6, np.random.default_rng(1))
    without = choose_by_exchange(seen, 6, np.random.default_rng(1))

    assert o1(unseen, with_it.indices) == 0.0
    assert list(with_it.indices) == list(without.indices)


def test_the_index_is_never_worse_than_that_of_the_start():
    jacobians = candidates(60, parameters=7, seed=7)
    start = np.arange(10)

    selection = choose_by_exchange(jacobians, 10, np.random.default_rng(0), start=start)

    assert o1(jacobians, selection.indices) > o1(jacobians, start)
    assert len(set(selection.indices)) == 10


def test_a_long_way_from_the_worst_start_ends_where_no_exchange_helps():
    jacobians = candidates(800, parameters=12, seed=8)
    worst_first = np.argsort(np.sum(jacobians**2, axis=(1, 2)))[:90]

    selection = choose_by_exchange(jacobians, 90, np.random.default_rng(0), start=worst_first)

    assert selection.exchanges > 60
    inside = selection.indices
    rng = np.random.default_rng(1)
    for _ in range(200):
        changed = inside.copy()
        changed[rng.integers(90)] = rng.choice(np.setdiff1d(np.arange(800), inside))
        assert o1(jacobians, changed) <= o1(jacobians, inside) * (1 + 1e-6)


def test_prior_information_draws_the_choice_to_what_is_not_known():
    # parameter 0 is known beforehand: the two candidates that see the other one are chosen
    jacobians = np.zeros((4, 1, 2))
    jacobians[:2, 0, 0], jacobians[2:, 0, 1] = 3.0, 1.0

    selection = choose_by_exchange(
        jacobians, 2, np.random.default_rng(0), prior_information=np.diag([1e6, 1.0])
    )

    assert list(selection.indices) == [2, 3]


def test_as_many_as_there_are_means_all_of_them():
    selection = choose_by_exchange(candidates(5), 5, np.random.default_rng(0))

    assert list(selection.indices) == [0, 1, 2, 3, 4]
    assert selection.exchanges == 0


def test_more_than_there_are_is_refused_with_both_numbers():
    with pytest.raises(TooFewCandidatesError, match="8 configurations were requested, but there are only 5"):
        choose_by_exchange(candidates(5), 8, np.random.default_rng(0))


@pytest.mark.parametrize(
    ("jacobians", "n", "start"),
    [
        (np.zeros((5, 3)), 2, None),
        (np.zeros((5, 3, 0)), 2, None),
        (np.full((5, 3, 2), math.nan), 2, None),
        (candidates(5), 0, None),
        (candidates(5), 2, np.array([1, 1])),
        (candidates(5), 2, np.array([1, 2, 3])),
        (candidates(5), 2, np.array([1, 5])),
        (candidates(5), 2, np.array([1, -1])),
    ],
)
def test_arguments_that_make_no_sense_are_refused(jacobians, n, start):
    with pytest.raises(ConfigurationError):
        choose_by_exchange(jacobians, n, np.random.default_rng(0), start=start)


@pytest.mark.parametrize("prior", [np.eye(3), np.ones(4), np.full((4, 4), math.nan)])
def test_a_prior_of_other_parameters_is_refused(prior):
    with pytest.raises(ConfigurationError, match="prior information on 4 parameters"):
        choose_by_exchange(candidates(5), 2, np.random.default_rng(0), prior_information=prior)


def test_the_same_seed_gives_the_same_choice():
    jacobians = candidates(50, seed=9)

    first, second = (choose_by_exchange(jacobians, 10, np.random.default_rng(4)).indices for _ in range(2))

    assert list(first) == list(second)


@pytest.mark.parametrize("seed", range(3))
def test_substitutes_are_ranked_by_the_index_that_they_give(seed):
    jacobians = candidates(12, seed=seed)
    chosen = np.isin(np.arange(12), np.random.default_rng(seed).choice(12, 4, replace=False))

    ranked = rank_substitutes(jacobians, chosen, 1e-9 * np.eye(4))

    assert sorted(ranked) == list(np.flatnonzero(~chosen))
    found = [o1(jacobians, [*np.flatnonzero(chosen), row]) for row in ranked]
    assert found == sorted(found, reverse=True)
