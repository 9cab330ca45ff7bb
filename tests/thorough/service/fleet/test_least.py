"""From which size on a change would have been shown, against fleets in which it is there."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.fleet.ageing import SCALE, ZERO, ages, fleet_of, zero
from truepose.fleet.changes import account_of
from truepose.fleet.instrument_scales import InstrumentDays
from truepose.fleet.minimum_detectable_change import least_of_instruments
from truepose.fleet.mixed_model import Equations, Posterior
from truepose.fleet.trials import Score

_SEEDS = range(60, 100)


@pytest.fixture(scope="module")
def steady():
    return account_of(fleet_of(59))


def _shown(account, share):
    """Return in how many fleets the line of robot 2's zero is beyond chance, at a share of the least size."""
    chances = []
    for seed in _SEEDS:
        amount = share * _least_amount(account, fleet_of(seed))
        fleet = fleet_of(seed, ages(amount))  # the same readings, with what ages
        line = (fleet.robot == 2) * fleet.day / fleet.day.max()
        score = Score(Posterior(Equations(fleet), account.estimated.variances), line)
        chances.append(score.of(ZERO[:, None]).judged()[1])
    return sum(chance <= account.tries.chance("robot") for chance in chances)


def _least_amount(account, fleet):
    estimated = replace(account.estimated, posterior=Posterior(Equations(fleet), account.estimated.variances))
    least = zero(replace(account, fleet=fleet, estimated=estimated))
    return least.size_mm[2] / np.sqrt(fleet.motion_mm2[0, 0])


def test_what_would_have_been_shown_is_shown_and_much_less_is_not(steady):
    assert _shown(steady, 1.0) > 0.85 * len(_SEEDS)  # 95 % of fleets
    assert 0.25 < _shown(steady, 0.7) / len(_SEEDS) < 0.7  # 49 %
    assert _shown(steady, 0.4) < 0.15 * len(_SEEDS)  # 5 %


def test_a_drift_that_would_have_been_shown_is_shown_and_much_less_is_not():
    options = {"robots": 3, "months": 5, "day": 0.0}
    account = account_of(fleet_of(58, **options))
    least = least_of_instruments(account).size_mm[1] / np.sqrt(account.fleet.motion_mm2[3, 3])

    def shown(amount):
        chances = []
        for seed in _SEEDS:
            fleet = fleet_of(seed, lambda i, k, month: 0.25 * amount * month * (k == 1) * SCALE, **options)
            days = InstrumentDays(Posterior(Equations(fleet), account.estimated.variances))
            instrument, day = (np.array(column) for column in zip(*fleet.visits, strict=True))
            chances.append(days.of((instrument == 1) * day / day.max())[1])
        return sum(chance <= account.tries.chance("instrument") for chance in chances)

    assert shown(least) >= len(_SEEDS) - 8
    assert shown(0.4 * least) < len(_SEEDS) // 4
