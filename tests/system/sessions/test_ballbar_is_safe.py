"""A few of the sessions in which persons do anything and anything fails: nothing moves that must not.

A thousand of them: `tests/thorough/system/sessions/test_ballbar_is_safe.py`.
"""

import pytest

from tests.helpers.ballbar.crowd import PLAN, SPHERE, require_safe, went_well


@pytest.mark.parametrize(("plan", "sessions"), [(PLAN, 120), (SPHERE, 20)], ids=["six legs", "sphere test"])
def test_nothing_moves_that_must_not_and_no_reading_is_lost_or_doubled(plan, sessions):
    require_safe(plan, went_well(plan), range(sessions))
