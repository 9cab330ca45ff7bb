"""From which size on a change would have been shown, against fleets in which it is there."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.fleet.linear import drawn
from truepose.domain.sentences import leading_key
from truepose.fleet.answer.sentences import least_said
from truepose.fleet.changes import account_of
from truepose.fleet.least import least_of_instruments, least_of_robots
from truepose.fleet.mixed_model import Equations, Posterior
from truepose.fleet.trials import InstrumentDays, Score
from truepose.words.catalogue import english

_SEEDS = range(60, 100)
_ZERO, _SCALE = np.eye(4)[0], np.eye(4)[3]


def _fleet(seed, drift=None, **options):
    return drawn(seed, **{"robots": 4, "readings": 20, "months": 3, "drift": drift, **options}).fleet()


def _zero(account):
    return next(one for one in least_of_robots(account) if one.cause.effect == "joint_offset")


def _ages(amount):
    """Return how the zero of robot 2 moves evenly to an amount, in stated widths."""
    return lambda i, k, month: 0.5 * amount * month * (i == 2) * _ZERO


@pytest.fixture(scope="module")
def steady():
    return account_of(_fleet(59))


def _shown(account, share):
    """Return in how many fleets the line of robot 2's zero is beyond chance, at a share of the least size."""
    chances = []
    for seed in _SEEDS:
        amount = share * _least_amount(account, _fleet(seed))
        fleet = _fleet(seed, _ages(amount))  # the same readings, with what ages
        line = (fleet.robot == 2) * fleet.day / fleet.day.max()
        score = Score(Posterior(Equations(fleet), account.estimated.variances), line)
        chances.append(score.of(_ZERO[:, None]).judged()[1])
    return sum(chance <= account.tries.chance("robot") for chance in chances)


def _least_amount(account, fleet):
    estimated = replace(account.estimated, posterior=Posterior(Equations(fleet), account.estimated.variances))
    least = _zero(replace(account, fleet=fleet, estimated=estimated))
    return least.size_mm[2] / np.sqrt(fleet.motion_mm2[0, 0])


def test_what_would_have_been_shown_is_shown_and_much_less_is_not(steady):
    assert _shown(steady, 1.0) > 0.85 * len(_SEEDS)  # 95 % of fleets
    assert 0.25 < _shown(steady, 0.7) / len(_SEEDS) < 0.7  # 49 %
    assert _shown(steady, 0.4) < 0.15 * len(_SEEDS)  # 5 %


def test_a_drift_that_would_have_been_shown_is_shown_and_much_less_is_not():
    options = {"robots": 3, "months": 5, "day": 0.0}
    account = account_of(_fleet(58, **options))
    least = least_of_instruments(account).size_mm[1] / np.sqrt(account.fleet.motion_mm2[3, 3])

    def shown(amount):
        chances = []
        for seed in _SEEDS:
            fleet = _fleet(seed, lambda i, k, month: 0.25 * amount * month * (k == 1) * _SCALE, **options)
            days = InstrumentDays(Posterior(Equations(fleet), account.estimated.variances))
            instrument, day = (np.array(column) for column in zip(*fleet.visits, strict=True))
            chances.append(days.of((instrument == 1) * day / day.max())[1])
        return sum(chance <= account.tries.chance("instrument") for chance in chances)

    assert shown(least) >= len(_SEEDS) - 8
    assert shown(0.4 * least) < len(_SEEDS) // 4


def test_what_is_named_is_not_said_to_have_stayed_unseen():
    account = account_of(_fleet(61, _ages(4.0)))

    assert {one.change.of for one in account.named} == {"robot 2"}
    assert _zero(account).of == ("robot 0", "robot 1", "robot 3")


def test_of_few_days_no_drift_of_an_instrument_can_be_told():
    account = account_of(_fleet(62, months=2))

    assert np.all(np.isinf(least_of_instruments(account).size_mm))
    keys = [leading_key(one) for one in least_said(account)]
    assert keys[-2:] == ["fleet.least.no_drift"] * 2


def test_a_drift_is_said_over_all_of_its_days():
    account = account_of(_fleet(63, months=6, day=0.02))
    found = least_of_instruments(account)
    drift = [english(one) for one in least_said(account) if leading_key(one) == "fleet.least.drift"]

    assert np.all(np.isfinite(found.size_mm))
    assert [one.split(" would")[0] for one in drift] == ["A drift of tracker 0", "A drift of tracker 1"]
    assert all("in 150 days on" in one for one in drift)
