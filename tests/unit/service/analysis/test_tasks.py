"""A task reads what it is given and refuses what cannot be done with a sentence."""

import dataclasses

import numpy as np
import pytest

from tests.helpers.domain.builders import make_campaign
from tests.helpers.domain.tracker_sessions import make_plan, make_setup
from truepose.analysis.errors import NothingMeasuredError
from truepose.analysis.job_queue.tasks import PlanTask, PosePlanTask, held_out
from truepose.domain.errors import ConfigurationError
from truepose.exchange.cells.file import simulated_cell
from truepose.planning.workspace.space import (
    SEEN_WITHIN_RAD,
    cosines_to_tracker,
    is_clear,
    nominal_chain,
    space_of_cell,
)
from truepose.sessions.tracker.service import path_warnings_of_plan
from truepose.storage.records import SessionSetup


def quiet(fraction, doing):
    pass


def poses_planned(cell=None, **asked):
    """Return the session of a test of ISO 9283."""
    wanted = dataclasses.replace(make_plan(role="validation"), stops=(), settle_s=7.0)
    setup = SessionSetup(cell or simulated_cell("irb120-tilted", 0))
    return PosePlanTask(setup, wanted, **asked).perform(quiet)


def test_calibration_readings_never_stand_in_for_validation_readings():
    campaign = dataclasses.replace(make_campaign(), validation=None, validation_legs=None)

    with pytest.raises(NothingMeasuredError, match="no validation readings"):
        held_out(campaign)


def test_a_plan_keeps_what_was_wanted_of_the_session():
    cell = simulated_cell("irb120-tilted", 0)
    wanted = dataclasses.replace(
        make_plan(role="validation"), stops=(), settle_s=7.0, approach_offset_rad=None
    )

    plan = PlanTask(SessionSetup(cell), wanted, 4, 1).perform(quiet)

    assert (plan.role, plan.settle_s, plan.approach_offset_rad) == ("validation", 7.0, None)
    assert len(plan.stops) == 4


def test_without_ranges_nothing_is_chosen():
    task = PlanTask(make_setup(), dataclasses.replace(make_plan(), stops=()), 4, 1)

    with pytest.raises(ConfigurationError, match=r"under \[limits\] in the cell file"):
        task.perform(quiet)


def test_the_poses_of_iso_9283_become_cycles_of_the_session():
    place = {"centre_mm": (300.0, 0.0, 350.0), "edge_mm": 100.0, "plane": "y+"}

    plan = poses_planned(**place, quaternion=(0, 2, 0, 0), nest=2, cycles=3)

    assert (len(plan.stops), plan.settle_s, plan.approach_offset_rad) == (15, 7.0, None)
    assert {stop.nest for stop in plan.stops} == {2}
    assert [stop.repeat_of for stop in plan.stops[4:7]] == [None, 1, 2]


UNSAID = {"centre_mm": None, "edge_mm": None, "quaternion": None, "nest": None, "plane": "y+", "cycles": 1}


@pytest.fixture(scope="module")
def of_no_stated_cube():
    """The plan of a cube that is looked for, which takes half a second."""
    return poses_planned(**UNSAID)


def test_a_cube_that_nobody_states_has_room_and_sight(of_no_stated_cube):
    cell, plan = simulated_cell("irb120-tilted", 0), of_no_stated_cube

    space = space_of_cell(cell, (), None)
    chain = nominal_chain(space, np.array([stop.joints_rad for stop in plan.stops]))
    (nest,) = {stop.nest for stop in plan.stops}
    assert is_clear(space, chain).all()
    assert (cosines_to_tracker(space, chain)[nest - 1] >= np.cos(SEEN_WITHIN_RAD)).all()
    places = chain.points(np.array(cell.nests[nest - 1].centre_mm))
    assert np.ptp(places, axis=0) == pytest.approx([320.0, 320.0, 320.0])  # 0.8 of an edge of 400 mm


def test_a_cube_that_nobody_states_keeps_to_what_is_stated():
    plan = poses_planned(**UNSAID | {"nest": 3})

    assert {stop.nest for stop in plan.stops} == {3}


def test_where_the_tracker_sees_no_pose_no_cube_is_made_up():
    cell = dataclasses.replace(simulated_cell("irb120-tilted", 0), tracker_position_mm=(0.0, 0.0, -3000.0))
    asked = UNSAID | {"nest": 1, "quaternion": (0.0, 1.0, 0.0, 0.0)}

    with pytest.raises(ConfigurationError, match="No ISO 9283 cube was found"):
        poses_planned(cell, **asked)


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"edge_mm": None}, "both the centre and the edge length"),
        ({"quaternion": (0.0, 0.0, 0.0, 0.0)}, "is not an orientation"),
        ({"nest": 4}, "no tool nest 4"),
        ({"edge_mm": 2000.0}, "out of the robot's reach"),
    ],
)
def test_poses_that_cannot_be_had_are_refused(wrong, sentence):
    place = {"centre_mm": (370.0, 0.0, 400.0), "edge_mm": 200.0, "plane": "y+", "nest": 1, "cycles": 3}
    asked = place | {"quaternion": (0.0, 1.0, 0.0, 0.0)} | wrong

    with pytest.raises(ConfigurationError, match=sentence):
        poses_planned(**asked)


@pytest.mark.parametrize(
    ("test", "stops", "ends_when_settled"),
    [({"test": "directions", "approach_mm": 30.0}, 9, False), ({"test": "drift", "hours": 0.5}, 40, True)],
)
def test_the_other_tests_of_iso_9283_take_the_same_poses(of_no_stated_cube, test, stops, ends_when_settled):
    plan = poses_planned(**UNSAID | test)

    five = of_no_stated_cube.stops
    assert {stop.joints_rad for stop in plan.stops} <= {stop.joints_rad for stop in five}
    assert {stop.nest for stop in plan.stops} == {stop.nest for stop in five}
    assert (len(plan.stops), plan.settle_s, plan.approach_offset_rad) == (stops, 7.0, None)
    assert plan.ends_when_settled is ends_when_settled
    assert path_warnings_of_plan(simulated_cell("irb120-tilted", 0), plan) == ""
