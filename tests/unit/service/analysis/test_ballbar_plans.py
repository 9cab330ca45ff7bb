"""Where a ballbar session is measured: at the places that were given, or at one that is looked for."""

import pytest

from tests.helpers.ballbar.cells import domain_cell, frame
from truepose.analysis.ballbar_plans import plan_ballbar_session
from truepose.domain.errors import ConfigurationError

HERE = frame(450, -200, 150, 0, -30, 60)


def test_a_place_that_was_given_is_where_it_is_measured():
    plan = plan_ballbar_session(domain_cell(), (HERE,), placements=1, poses=6, seed=1, sphere=None)

    (placement,) = plan.placements
    assert len(placement.poses) == 6
    assert placement.cups_mm[0] == pytest.approx((450, -200, 150))


def test_without_a_place_as_many_are_looked_for_as_were_asked_for():
    with pytest.raises(ConfigurationError, match="no session"):
        plan_ballbar_session(domain_cell(), (), placements=0, poses=10, seed=1, sphere=None)
