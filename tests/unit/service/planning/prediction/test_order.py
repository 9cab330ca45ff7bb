"""The order of choice: nested sets, the best first, as good as an exchange where it matters."""

import numpy as np
import pytest

from truepose.planning.exchange_algorithm import choose_by_exchange
from truepose.planning.observability import most_informative_first, observability_o1


def rows(n=400, seed=4):
    return np.random.default_rng(seed).standard_normal((n, 3, 8)) * np.logspace(0, 2, 8)


def test_every_next_one_raises_the_determinant_most():
    offered, known = rows(60), np.eye(8)

    order = most_informative_first(offered, 5, known)

    information = known.copy()
    for best in order:
        gains = [np.linalg.slogdet(information + one.T @ one)[1] for one in offered]
        assert gains[best] == pytest.approx(max(gains))
        information += offered[best].T @ offered[best]


def test_nobody_is_chosen_twice_and_all_are_where_more_are_asked_for():
    assert sorted(most_informative_first(rows(7), 20, np.eye(8))) == list(range(7))


def test_nothing_is_chosen_from_nothing():
    assert most_informative_first(rows(0), 5, np.eye(8)).shape == (0,)


def test_an_exchange_finds_hardly_better():
    offered = rows()
    greedy = most_informative_first(offered, 40, np.eye(8))
    best = choose_by_exchange(offered, 40, np.random.default_rng(1), prior_information=np.eye(8))

    of_greedy, of_best = (
        observability_o1(offered[chosen].reshape(-1, 8), 40) for chosen in (greedy, best.indices)
    )
    assert of_greedy > 0.99 * of_best
