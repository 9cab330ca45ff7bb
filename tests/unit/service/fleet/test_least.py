"""From which size on a change would have been shown: of what, and over which days."""

import numpy as np

from tests.helpers.fleet.ageing import ages, fleet_of, zero
from truepose.fleet.changes import account_of
from truepose.fleet.minimum_detectable_change import least_of_instruments
from truepose.fleet.sentences import least_said
from truepose.messages.catalogue import english
from truepose.messages.message import leading_key


def test_what_is_named_is_not_said_to_have_stayed_unseen():
    account = account_of(fleet_of(61, ages(4.0)))

    assert {one.change.of for one in account.named} == {"robot 2"}
    assert zero(account).of == ("robot 0", "robot 1", "robot 3")


def test_of_few_days_no_drift_of_an_instrument_can_be_told():
    account = account_of(fleet_of(62, months=2))

    assert np.all(np.isinf(least_of_instruments(account).size_mm))
    keys = [leading_key(one) for one in least_said(account)]
    assert keys[-2:] == ["fleet.least.no_drift"] * 2


def test_a_drift_is_said_over_all_of_its_days():
    account = account_of(fleet_of(63, months=6, day=0.02))
    found = least_of_instruments(account)
    drift = [english(one) for one in least_said(account) if leading_key(one) == "fleet.least.drift"]

    assert np.all(np.isfinite(found.size_mm))
    assert [one.split(" by ")[0] for one in drift] == ["A drift of tracker 0", "A drift of tracker 1"]
    assert all("or more in 150 days (" in one for one in drift)
