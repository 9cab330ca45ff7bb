"""A task reads what it is given and refuses what cannot be done with a sentence."""

import dataclasses

import pytest

from tests.helpers.domain.builders import make_campaign
from tests.helpers.domain.tracker_sessions import make_plan, make_setup
from truepose.analysis.errors import NothingMeasuredError
from truepose.analysis.workers.tasks import PlanTask, PosePlanTask, held_out
from truepose.domain.errors import ConfigurationError
from truepose.exchange.cells.file import simulated_cell
from truepose.storage.records import SessionSetup


def quiet(fraction, doing):
    pass


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

    with pytest.raises(ConfigurationError, match=r"under \[limits\] of the cell file"):
        task.perform(quiet)


def test_the_poses_of_iso_9283_become_cycles_of_the_session():
    cell = simulated_cell("irb120-tilted", 0)
    wanted = dataclasses.replace(make_plan(role="validation"), stops=(), settle_s=7.0)
    place = {"centre_mm": (300.0, 0.0, 350.0), "edge_mm": 100.0, "plane": "y+"}
    task = PosePlanTask(SessionSetup(cell), wanted, **place, quaternion=(0, 2, 0, 0), nest=2, cycles=3)

    plan = task.perform(quiet)

    assert (len(plan.stops), plan.settle_s, plan.approach_offset_rad) == (15, 7.0, None)
    assert {stop.nest for stop in plan.stops} == {2}
    assert [stop.repeat_of for stop in plan.stops[4:7]] == [None, 1, 2]


@pytest.mark.parametrize(
    ("wrong", "sentence"),
    [
        ({"quaternion": (0.0, 0.0, 0.0, 0.0)}, "no orientation"),
        ({"nest": 4}, "no tool nest 4"),
        ({"edge_mm": 2000.0}, "out of the robot's reach"),
    ],
)
def test_poses_that_cannot_be_had_are_refused(wrong, sentence):
    cell = simulated_cell("irb120-tilted", 0)
    wanted = dataclasses.replace(make_plan(role="validation"), stops=())
    place = {"centre_mm": (370.0, 0.0, 400.0), "edge_mm": 200.0, "plane": "y+", "nest": 1, "cycles": 3}
    asked = place | {"quaternion": (0.0, 1.0, 0.0, 0.0)} | wrong

    with pytest.raises(ConfigurationError, match=sentence):
        PosePlanTask(SessionSetup(cell), wanted, **asked).perform(quiet)
