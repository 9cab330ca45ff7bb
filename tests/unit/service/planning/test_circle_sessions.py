"""Sessions of the circle test: one joint at a time, both ways, as far as one nest is seen."""

from dataclasses import replace

import numpy as np
import pytest

from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.domain.session import SessionPlan, Turn
from truepose.exchange.cells.file import simulated_cell
from truepose.planning.tracker.circles import plan_circles
from truepose.planning.workspace.space import space_to_measure
from truepose.sessions.tracker.service import path_warnings_of_plan

_TEMPLATE = SessionPlan("validation", (), settle_s=7.0)
_CELL = simulated_cell("irb120-tilted", 0)
# Reflectors that somebody, or a motor, keeps turned to the tracker.
_SEEN_CELL = replace(_CELL, nests=tuple(replace(nest, facing=None) for nest in _CELL.nests))


def planned(cell=_SEEN_CELL, turns=()):
    return plan_circles(space_to_measure(cell, None), _TEMPLATE, turns)


@pytest.fixture(scope="module")
def facing_plan():
    """Of the cell whose reflectors face where they face."""
    return planned(_CELL)


def joints_deg(plan):
    return np.degrees([stop.joints_rad for stop in plan.stops])


def turn(joint, low, high, step):
    return Turn(joint, *np.radians([low, high, step]).tolist())


def test_one_joint_moves_at_a_time_and_comes_back_the_way_it_went():
    plan = planned(turns=(turn(1, -30, 30, 10), turn(5, 0, 40, 8)))

    up_1, up_5 = [-30, -20, -10, 0, 10, 20, 30], [0, 8, 16, 24, 32, 40]
    wanted = np.zeros((24, 6))
    wanted[:13, 0] = up_1 + up_1[-2::-1]
    wanted[13:, 4] = up_5 + up_5[-2::-1]
    assert joints_deg(plan) == pytest.approx(wanted, abs=1e-9)
    assert [stop.config for stop in plan.stops] == list(range(1, 25))
    assert (plan.role, plan.settle_s, plan.approach_offset_rad) == ("validation", 7.0, None)


def test_the_usual_test_keeps_the_intervals_of_the_table_within_the_limits():
    plan = planned()
    angles = joints_deg(plan)

    limits = _CELL.robot.joint_limits
    assert limits is not None
    for joint, reach, step in ((1, 60, 5), (2, 40, 1), (3, 40, 1), (4, 155, 5), (5, 90, 5)):
        moved = np.unique(angles[angles[:, joint - 1].nonzero()[0], joint - 1].round(6))
        assert (moved.min(), moved.max()) == (-reach, reach)
        assert np.diff(moved).min() == pytest.approx(step)
    assert angles[:, 5].max() == pytest.approx(np.floor(min(400.0, np.degrees(limits[5].upper_rad) + 1e-9)))
    assert path_warnings_of_plan(_SEEN_CELL, plan) == ""


def test_the_nest_on_the_axis_is_not_the_one_that_is_measured():
    """Nest 1 of the triangular artefact is on axis 6, which axis 4 is in line with."""
    stops = planned(turns=(turn(4, -90, 90, 10), turn(6, -90, 90, 10))).stops

    assert 1 not in {stop.nest for stop in stops}


def sweeps_deg(plan):
    """Which joint is turned, through which angles, at which nest, where the others stand."""
    joints, nests = joints_deg(plan), [stop.nest for stop in plan.stops]
    begins = [row for row, stop in enumerate(plan.stops) if stop.begin_rad is not None]
    for first, last in zip(begins, [*begins[1:], len(joints)], strict=True):
        moved = np.flatnonzero(np.ptp(joints[first:last], axis=0) > 1e-9)
        assert len(moved) == 1
        assert len(set(nests[first:last])) == 1
        turned = joints[first:last, moved[0]]
        yield int(moved[0]) + 1, float(turned.min()), float(turned.max()), np.delete(joints[first], moved)


def test_where_the_others_stand_keeps_a_reflector_in_sight(facing_plan):
    """At 0 the nests of this cell are seen over 25, 11, 10, 0, 55 and 21 deg."""
    found = {joint: (low, high) for joint, low, high, _ in sweeps_deg(facing_plan)}
    arcs = {joint: high - low for joint, (low, high) in found.items()}
    assert found[2] == found[3] == pytest.approx((-40.0, 40.0))
    assert found[4] == pytest.approx((-155.0, 155.0))
    assert arcs[1] >= 45.0  # the axis is across the line of sight: 58 deg at most
    assert arcs[5] >= 120.0
    assert arcs[6] >= 75.0
    assert path_warnings_of_plan(_CELL, facing_plan) == ""


def test_joints_that_are_seen_at_0_are_tested_there():
    assert all(not others.any() for _, _, _, others in sweeps_deg(planned()))


def test_between_two_sweeps_the_arm_goes_to_rest(facing_plan):
    begins = [stop.begin_rad for stop in facing_plan.stops if stop.begin_rad is not None]

    assert begins == [(0.0,) * 6] * 6


def test_the_same_cell_gets_the_same_test(facing_plan):
    assert planned(_CELL, (turn(4, -155, 155, 5),)).stops[0].joints_rad in {
        stop.joints_rad for stop in facing_plan.stops
    }


def test_a_joint_that_was_asked_for_and_shows_no_nest_is_named():
    backwards = replace(_CELL, tracker_position_mm=(0.0, 0.0, -3000.0))  # below the table

    with pytest.raises(
        ConfigurationError, match="For joint 2, the tracker sees no nest over at least 20 deg"
    ):
        planned(backwards, (turn(2, -40, 40, 1),))


def test_no_joint_in_sight_is_said():
    narrow = (JointRange(-0.01, 0.01),) * 6
    held = replace(_SEEN_CELL, limits=replace(_SEEN_CELL.limits, joints=narrow))

    with pytest.raises(ConfigurationError, match="For joint 1, 2, 3, 4, 5, 6"):
        planned(held)


def test_a_joint_that_the_robot_does_not_have_is_refused():
    with pytest.raises(ConfigurationError, match="There is no joint 7"):
        planned(turns=(turn(7, -10, 10, 1),))


@pytest.mark.parametrize("bad", [(40, -40, 1), (-40, 40, 0), (10, 10, 1)])
def test_an_interval_that_is_none_is_refused(bad):
    with pytest.raises(ConfigurationError, match="For joint 1, the end of the range must be above its start"):
        planned(turns=(turn(1, *bad),))


def test_more_stops_than_anybody_waits_for_are_refused():
    with pytest.raises(ConfigurationError, match="5401 configurations; at most 5000 are allowed"):
        planned(turns=(turn(5, -90, 90, 0.0666666666),))


def test_a_turn_that_is_shorter_than_its_step_shows_no_circle():
    with pytest.raises(
        ConfigurationError, match="For joint 1, the tracker sees no nest over at least 20 deg"
    ):
        planned(turns=(turn(1, 0.5, 0.9, 1),))
