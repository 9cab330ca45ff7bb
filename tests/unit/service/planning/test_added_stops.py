"""What somebody wants to add to a plan becomes stops of it, or is refused with the reason."""

import math
from dataclasses import replace

import pytest

from tests.unit.service.sessions.tracker.fakes import FIXED_NESTS, IRB120, TRACKER_AT
from truepose.domain.cell import Cell, CellLimits
from truepose.domain.robot import FramePlacement, Nest
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.planning.errors import WorkSpaceError
from truepose.planning.tracker.added_stops import WantedStop, addition

REACHING_OUT = tuple(math.radians(q) for q in (0.0, 30.0, -10.0, 0.0, 20.0, 0.0))
TURNED = (math.radians(20.0), *REACHING_OUT[1:])
INTO_THE_TABLE = tuple(math.radians(q) for q in (0.0, 90.0, 40.0, 0.0, 30.0, 0.0))
PLAN = SessionPlan("calibration", (PlannedStop(4, REACHING_OUT, 1),))


def stops_to_add(cell, plan, wanted):
    return addition(cell, plan, wanted).stops


def make_cell(**changes):
    values = {
        "name": "bench",
        "robot_key": "irb",
        "robot": IRB120,
        "base_nominal": FramePlacement(),
        "nests": (Nest((0.0, 0.0, 125.0)),),
        "fixed_nests": FIXED_NESTS,
        "tracker_position_mm": TRACKER_AT,
    }
    return Cell(**{**values, **changes})


def test_stops_follow_the_numbers_of_the_plan():
    stops = stops_to_add(make_cell(), PLAN, [WantedStop(TURNED, 1), WantedStop((*TURNED[:5], 0.5), 1)])

    assert [stop.config for stop in stops] == [5, 6]
    assert [stop.joints_rad for stop in stops] == [TURNED, (*TURNED[:5], 0.5)]
    assert [stop.repeat_of for stop in stops] == [None, None]


def test_a_configuration_that_is_in_the_plan_already_is_a_revisit():
    stops = stops_to_add(
        make_cell(), PLAN, [WantedStop(REACHING_OUT), WantedStop(TURNED), WantedStop(TURNED)]
    )

    assert [stop.repeat_of for stop in stops] == [4, None, 6]


def test_the_nest_that_faces_the_tracker_is_measured_where_none_is_named():
    # Seen from +x the tool's own z axis, along the forearm, points towards the tracker.
    nests = (
        Nest((0.0, 0.0, 125.0), facing=(0.0, 0.0, -1.0)),
        Nest((0.0, 0.0, 125.0), facing=(0.0, 0.0, 1.0)),
    )
    ahead = tuple(math.radians(q) for q in (-15.0, 30.0, -30.0, 0.0, 0.0, 0.0))

    (stop,) = stops_to_add(make_cell(nests=nests), PLAN, [WantedStop(ahead)])

    assert stop.nest == 2
    with pytest.raises(WorkSpaceError, match="Additional configuration 1: the tracker cannot see nest 1"):
        stops_to_add(make_cell(nests=nests), PLAN, [WantedStop(ahead, 1)])


@pytest.mark.parametrize(
    ("wanted", "words"),
    [
        ([WantedStop(TURNED), WantedStop((0.0,) * 5)], "Additional configuration 2 needs 6 finite"),
        ([WantedStop((math.nan,) * 6)], "Additional configuration 1 needs 6 finite"),
        (
            [WantedStop(TURNED), WantedStop(INTO_THE_TABLE)],
            "Additional configuration 2: the measurement pose is too close to",
        ),
        ([WantedStop(TURNED, 7)], "The tool has no nest 7; it has 1 nests"),
        (
            [WantedStop((2.0, *TURNED[1:]))],
            r"outside the joint limits \(joint 1 at 114\.59 deg, limits -95\.00",
        ),
    ],
)
def test_what_cannot_be_measured_is_refused_with_the_reason(wanted, words):
    with pytest.raises(WorkSpaceError, match=words):
        stops_to_add(make_cell(), PLAN, wanted)


def test_the_approach_is_judged_like_the_stop():
    # 40 deg further down on all joints the forearm is in the table; the stop itself is clear of it.
    steep = replace(PLAN, approach_offset_rad=math.radians(40.0))

    with pytest.raises(WorkSpaceError, match="Additional configuration 1: the approach"):
        stops_to_add(make_cell(), steep, [WantedStop(TURNED)])


def test_without_any_limits_nothing_is_added():
    robot = replace(IRB120, calibration_ranges=None, joint_limits=None)

    with pytest.raises(WorkSpaceError, match="does not move without joint limits"):
        stops_to_add(make_cell(robot=robot), PLAN, [WantedStop(TURNED)])


def test_the_limits_of_the_cell_serve_where_no_ranges_are_stated():
    robot = replace(IRB120, calibration_ranges=None, joint_limits=None)
    cell = make_cell(robot=robot, limits=CellLimits(joints=IRB120.calibration_ranges))

    assert len(stops_to_add(cell, PLAN, [WantedStop(TURNED)])) == 1


def test_what_cannot_be_measured_is_left_out_where_that_is_wanted_and_said():
    wanted = [WantedStop(INTO_THE_TABLE), WantedStop(TURNED), WantedStop((2.0, *TURNED[1:]))]

    found = addition(make_cell(), PLAN, wanted, leave_out_unfit=True)

    assert [(stop.config, stop.joints_rad) for stop in found.stops] == [(5, TURNED)]
    assert [entry.number for entry in found.left_out] == [1, 3]
    assert "table" in found.left_out[0].reason
    assert "joint 1" in found.left_out[1].reason


def test_where_none_can_be_measured_none_is_added():
    with pytest.raises(
        WorkSpaceError, match="Additional configuration 1: the measurement pose is too close to"
    ):
        addition(make_cell(), PLAN, [WantedStop(INTO_THE_TABLE)] * 2, leave_out_unfit=True)


def test_degrees_with_nine_decimals_still_are_the_same_configuration():
    rounded = tuple(math.radians(round(math.degrees(q + 1e-12), 9)) for q in REACHING_OUT)

    (stop,) = stops_to_add(make_cell(), PLAN, [WantedStop(rounded, 1)])

    assert (stop.repeat_of, stop.joints_rad) == (4, REACHING_OUT)
