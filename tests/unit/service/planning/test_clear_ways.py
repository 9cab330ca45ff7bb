"""Between two stops that are clear of the table the arm may still go through it: chosen orders avoid that."""

import numpy as np
import pytest

from tests.unit.service.planning.test_candidates import SPACE
from truepose.domain.errors import ConfigurationError
from truepose.planning.tracker.plans import plan_calibration, plan_validation
from truepose.planning.tracker.pose_order import clear_order, room_mm
from truepose.planning.workspace.candidates import draw_candidates
from truepose.planning.workspace.space import heights_above_table_mm


def ways(plan):
    joints = np.array([stop.joints_rad for stop in plan.stops])
    return room_mm(SPACE, joints[:-1], joints[1:])


def test_the_room_of_a_way_is_that_of_its_lowest_point():
    joints = draw_candidates(SPACE, 2, np.random.default_rng(1)).joints_rad
    end = joints[1] + (SPACE.approach_offset_rad or 0.0)
    along = joints[0] + np.linspace(0.0, 1.0, 400)[:, None] * (end - joints[0])

    lowest = heights_above_table_mm(SPACE, along).min()

    assert room_mm(SPACE, joints[:1], joints[1:])[0] == pytest.approx(lowest, abs=5.0)


def test_random_orders_lead_through_the_table_and_the_order_of_a_plan_does_not():
    joints = draw_candidates(SPACE, 60, np.random.default_rng(0)).joints_rad
    assert (room_mm(SPACE, joints[:-1], joints[1:]) < 0.0).any()  # else there was nothing to avoid

    order = clear_order(SPACE, joints)

    assert sorted(order) == list(range(60))
    assert room_mm(SPACE, joints[order[:-1]], joints[order[1:]]).min() > 0.0


@pytest.mark.parametrize("seed", range(4))
def test_no_way_of_a_chosen_plan_leads_through_the_table(seed):
    assert ways(plan_calibration(SPACE, 30, seed=seed, n_candidates=300)).min() > 0.0
    assert ways(plan_validation(SPACE, 100, seed=seed)).min() > 0.0


def test_an_order_that_is_clear_stays_as_it_is():
    joints = draw_candidates(SPACE, 1, np.random.default_rng(5)).joints_rad
    few = joints + 0.01 * np.arange(6)[:, None]

    assert clear_order(SPACE, few).tolist() == list(range(6))


def test_one_stop_and_none_are_in_order():
    joints = draw_candidates(SPACE, 1, np.random.default_rng(5)).joints_rad

    assert clear_order(SPACE, joints).tolist() == [0]
    assert clear_order(SPACE, joints, joints[0]).tolist() == [0]
    assert clear_order(SPACE, joints[:0]).tolist() == []
    assert clear_order(SPACE, joints[:0], joints[0]).tolist() == []


def test_a_validation_of_nothing_is_refused():
    with pytest.raises(ConfigurationError, match=r"must be at least 1 \(got 0\)"):
        plan_validation(SPACE, 0, seed=1)
