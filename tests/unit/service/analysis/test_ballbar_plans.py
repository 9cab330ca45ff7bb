"""Where a ballbar session is measured: at the places that were given, or at one that is looked for."""

from unittest.mock import Mock

import pytest

from tests.helpers.ballbar.cells import domain_cell, frame
from truepose.analysis import ballbar_plans
from truepose.analysis.ballbar_plans import plan_ballbar_session
from truepose.analysis.campaigns.ballbar import ValidReadings
from truepose.domain.errors import ConfigurationError

HERE = frame(450, -200, 150, 0, -30, 60)


def test_a_place_that_was_given_is_where_it_is_measured():
    plan = plan_ballbar_session(domain_cell(), (HERE,), placements=1, poses=6, seed=1, sphere=None)

    (placement,) = plan.placements
    assert len(placement.poses) == 6
    assert placement.cups_mm[0] == pytest.approx((450, -200, 150))


def test_without_a_place_as_many_are_looked_for_as_were_asked_for():
    with pytest.raises(ConfigurationError, match="A session needs at least one placement"):
        plan_ballbar_session(domain_cell(), (), placements=0, poses=10, seed=1, sphere=None)


@pytest.mark.parametrize("named", [1, 2, 5])
def test_a_fit_is_without_every_pose_that_is_named_exchanged(monkeypatch, named):
    """Each fit finds one more, until there are no more, or no more rounds."""
    fits = []

    def identified(setup, plan, kit, counting):
        fits.append({kept.config for kept in counting.legs})
        return Mock(), Mock()

    monkeypatch.setattr(ballbar_plans, "_identified", identified)
    monkeypatch.setattr(ballbar_plans, "_exchanged", lambda *_: set(range(min(len(fits), named))))
    counting = ValidReadings(tuple(Mock(config=number, stop=number) for number in range(8)))

    _, _, exchanged = ballbar_plans._fitted(Mock(), Mock(), Mock(), counting, ())

    assert fits[-1] == set(range(8)) - exchanged
    assert len(fits) == min(named, ballbar_plans._ROUNDS) + 1
