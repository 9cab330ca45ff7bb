"""Draws shared out among workers are those of one of them."""

import numpy as np
import pytest

from tests.helpers.archive import ThisProcess
from tests.helpers.identification.synthetic import measured, nominal_campaign
from truepose.analysis import resampling as home
from truepose.analysis.parallel.local_pool import Processes
from truepose.analysis.parallel.tasks import Cluster
from truepose.analysis.resampling import resample_parameters


@pytest.fixture(autouse=True)
def few_together(monkeypatch):
    monkeypatch.setattr(home, "TOGETHER", 10)


def test_two_processes_and_this_one_draw_the_same_bits():
    campaign = measured(nominal_campaign(20), effects=("base",))[0]
    told = []

    here = resample_parameters(Cluster(ThisProcess()), campaign, ("base",), "configurations", 25, seed=5)
    with Processes(2) as places:
        there = resample_parameters(
            Cluster(places), campaign, ("base",), "configurations", 25, 5, lambda *one: told.append(one)
        )

    assert here == there
    assert here.draws == 25
    assert told[-1] == (1.0, "3 of 3: draws 21 to 25")


def test_another_seed_draws_others():
    campaign = measured(nominal_campaign(20), effects=("base",))[0]

    one, other = (
        resample_parameters(Cluster(ThisProcess()), campaign, ("base",), "noise", 10, seed) for seed in (1, 2)
    )

    assert not np.array_equal(
        [each.standard_deviation for each in one.parameters],
        [each.standard_deviation for each in other.parameters],
    )
