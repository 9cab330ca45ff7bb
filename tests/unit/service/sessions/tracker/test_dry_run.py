"""Plans are refused before anything moves, each with one sentence; and how long they take."""

import math
from dataclasses import replace

import pytest

from tests.unit.service.sessions.tracker.fakes import (
    FIXED_NESTS,
    IRB120,
    NESTS,
    make_plan,
    make_stop,
)
from tests.unit.service.sessions.tracker.operators import run_session
from truepose.domain.robot import FixedNest, FramePlacement, JointRange, Nest
from truepose.domain.session import PlannedStop
from truepose.sessions.errors import PlanRefusedError
from truepose.sessions.tracker.dry_run import check_plan, dry_run, motion_limits
from truepose.sessions.tracker.runner import TrackerRunner

WIDE = tuple(JointRange(-math.pi, math.pi) for _ in range(6))


def require_fit(plan, nests=NESTS, fixed_nests=FIXED_NESTS, limits=WIDE):
    check_plan(plan, IRB120, nests, fixed_nests, limits)


def test_a_plan_that_fits_passes():
    require_fit(make_plan(20))


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"stops": ()}, "no configuration"),
        ({"stops": (make_stop(1), make_stop(1))}, "Configuration 1 is in the plan twice"),
        ({"stops": (PlannedStop(1, (0.0,) * 5, 1),)}, "needs 6 finite joint angles"),
        ({"stops": (PlannedStop(1, (math.nan,) * 6, 1),)}, "needs 6 finite joint angles"),
        ({"stops": (make_stop(1, nest=4),)}, "tool nest 4; the number of tool nests in the cell is 3"),
        ({"stops": (make_stop(1, nest=0),)}, "tool nest 0; the number of tool nests in the cell is 3"),
        ({"stops": (PlannedStop(2, make_stop(1).joints_rad, 1, 1),)}, "repeats 1, which is not an earlier"),
        ({"stops": (make_stop(1), PlannedStop(2, (0.0,) * 6, 1, 1))}, "the same joints and nest"),
        ({"measure_s": 0.0}, "measure_s is 0.0"),
        ({"search_radius_mm": math.inf}, "search_radius_mm is inf"),
        ({"settle_s": -1.0}, "settle_s is -1.0"),
        ({"reference_every": 0}, "reference_every is 0"),
    ],
)
def test_a_plan_that_makes_no_sense_is_refused_with_its_fault(changes, sentence):
    with pytest.raises(PlanRefusedError, match=sentence):
        require_fit(make_plan(**changes))


def test_a_stop_outside_the_limits_is_named_with_its_joint():
    stop = PlannedStop(7, (0.0, 0.0, 3.2, 0.0, 0.0, 0.0), 1)

    with pytest.raises(PlanRefusedError, match=r"Configuration 7 lies .* joint 3 at 183\.35 deg"):
        require_fit(make_plan(stops=(stop,)))


def test_an_approach_that_begins_outside_the_limits_is_refused_too():
    stop = PlannedStop(7, (0.0, -math.pi, 0.0, 0.0, 0.0, 0.0), 1)

    with pytest.raises(PlanRefusedError, match=r"The approach to configuration 7 .* joint 2"):
        require_fit(make_plan(stops=(stop,)))


def test_an_unknown_tool_nest_cannot_be_looked_for():
    with pytest.raises(PlanRefusedError, match="Tool nest 1 has no centre"):
        require_fit(make_plan(), nests=(Nest(None), *NESTS[1:]))


@pytest.mark.parametrize(
    ("fixed_nests", "sentence"),
    [
        (FIXED_NESTS[:2], "2 reference nests"),
        (tuple(FixedNest((x, 2.0 * x, 0.0), 0.002) for x in (0.0, 400.0, 800.0)), "on one line"),
    ],
)
def test_fixed_nests_that_cannot_place_a_tracker_are_refused(fixed_nests, sentence):
    with pytest.raises(PlanRefusedError, match=sentence):
        require_fit(make_plan(), fixed_nests=fixed_nests)


def test_without_limits_of_cell_and_controller_the_approach_widens_the_calibration_ranges():
    limits = motion_limits(IRB120, None, make_plan(approach_offset_rad=-0.1))

    assert limits[1] == JointRange(-0.1, math.radians(90))


def test_the_controllers_limits_come_before_the_ranges_and_the_cells_before_both():
    robot = replace(IRB120, joint_limits=WIDE)
    own = tuple(JointRange(-2.0, 2.0) for _ in range(6))

    assert motion_limits(robot, None, make_plan()) == WIDE
    assert motion_limits(robot, own, make_plan()) == own


def test_a_robot_of_which_no_limits_are_known_does_not_move():
    with pytest.raises(PlanRefusedError, match="gives joint limits"):
        motion_limits(replace(IRB120, calibration_ranges=None), None, make_plan())


def test_a_runner_refuses_an_unfit_plan_at_once(cell):
    with pytest.raises(PlanRefusedError):
        TrackerRunner(make_plan(stops=()), cell.cell, cell.journal)


def test_a_dry_run_counts_moves_and_readings():
    summary = dry_run(make_plan(12), IRB120, FramePlacement(), NESTS, 3)

    assert summary.configurations == 12
    assert summary.moves == 24
    # 10 of the faces, 15 of the registration, 3 times 3 references, 12 stops
    assert summary.readings == 46


async def test_a_dry_run_announces_what_the_run_does(cell):
    plan = make_plan(12)

    await run_session(cell, plan)

    summary = dry_run(plan, IRB120, FramePlacement(), NESTS, 3)
    assert summary.moves == len(cell.robot.moves)
    assert summary.readings == len(cell.journal.fixed) + len(cell.journal.points)


def test_slower_motion_and_longer_rest_take_longer():
    quick = dry_run(make_plan(10), IRB120, FramePlacement(), NESTS, 3)
    slow = dry_run(
        make_plan(10, orientation_speed_rad_s=0.1, settle_s=5.0), IRB120, FramePlacement(), NESTS, 3
    )

    assert slow.duration_s > quick.duration_s + 10.0  # a second more of rest at each of ten stops
