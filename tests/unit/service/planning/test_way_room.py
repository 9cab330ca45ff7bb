"""Ways between given stops: what touches is found, what does not is left alone, judged twice over."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from tests.unit.service.planning.test_candidates import NESTS
from tests.unit.service.sessions.tracker.fakes import IRB120
from truepose.domain.ballbar import PlannedPlacement
from truepose.domain.cell import Cell, CellLimits
from truepose.domain.robot import FramePlacement, Nest
from truepose.domain.session import PlannedStop, SessionPlan
from truepose.exchange.campaigns.folder import read_campaign
from truepose.messages.catalogue import english
from truepose.planning.ballbar.bodies import base_fixture
from truepose.planning.workspace.bodies import bodies_of, rooms
from truepose.planning.workspace.path_clearance import (
    Ways,
    path_obstruction,
    path_warnings,
    touching,
    ways_between,
)
from truepose.sessions.ballbar.planning import beside_fixture
from truepose.sessions.tracker.steps import Move, visit

CELL = Cell(name="bench", robot_key="", robot=IRB120, nests=NESTS)
STATED = replace(CELL, limits=CellLimits(floor_z_mm=0.0))
OFFSET = np.radians(-5.0)
BEFORE, BEYOND = [-80, 80, -40, 0, -70, -130], [-40, 80, -30, -40, 90, -20]  # both above the table
FOLDED, UNFOLDED = [0, 50, 40, 80, 80, 60], [60, 20, 30, -110, -10, -170]  # the tool off the arm in both
ANGLES = st.lists(st.integers(-150, 150), min_size=6, max_size=6)


def planned(*joints_deg):
    return [PlannedStop(k, tuple(np.radians(q)), 1) for k, q in enumerate(joints_deg, start=1)]


def way(start_deg, end_deg):
    return Ways(("from A to B",), np.radians([start_deg]), np.radians([end_deg]))


def points_by_hand(joints_rad):
    """Frames of the arm and nests of its tool at configurations (n, 6) [mm], by products of matrices."""
    frame, frames = np.eye(4), []
    for row, q in zip(IRB120.joints, joints_rad.T, strict=True):
        ca, sa, c, s = (f(x) for x in (row.alpha_rad, q + row.theta_offset_rad) for f in (np.cos, np.sin))
        one, none = np.ones_like(q), np.zeros_like(q)
        rows = [
            [c, -s, none, row.a_mm * one],
            [s * ca, c * ca, -sa * one, -sa * row.d_mm * one],
            [s * sa, c * sa, ca * one, ca * row.d_mm * one],
            [none, none, none, one],
        ]
        frame = frame @ np.moveaxis(np.array(rows), -1, 0)
        frames.append(frame)
    return frames, [(frame @ [*nest.centre_mm, 1.0])[:, :3] for nest in NESTS]


def lowest_by_hand(joints_rad):
    """Height of the lowest point of the moving arm and its tool, by the radii of its outline."""
    frames, nests = points_by_hand(joints_rad)
    knuckle = (frames[2] @ [70.0, 0.0, 0.0, 1.0])[:, 2]  # where the forearm begins, beside the elbow
    elbow, wrist, flange = (frames[k][:, 2, 3] for k in (2, 3, 5))
    tool = [nest[:, 2] - 8.0 for nest in nests]
    return np.min([*tool, flange - 40.0, wrist - 60.0, knuckle - 70.0, elbow - 70.0])


def all_along(ways, looks=800, begin=0.0):
    return ways.start_rad + np.linspace(begin, 1.0, looks)[:, None] * (ways.end_rad - ways.start_rad)


def first_look(ways):
    """Share of a way at which it is first looked at: where it begins, another ends, which is judged there."""
    return 1.0 / max(1.0, np.ceil(np.degrees(np.abs(ways.end_rad - ways.start_rad).max()) / 2.0))


def test_a_way_through_the_table_between_two_clear_stops_is_named_with_body_and_depth():
    ends = np.radians([BEFORE, BEYOND])
    assert rooms(bodies_of(CELL), np.vstack([ends, ends + OFFSET])).least_mm().min() > 0.0

    refused = path_obstruction(bodies_of(STATED), ways_between(planned(BEFORE, BEYOND), OFFSET))

    assert "from configuration 1 to the approach to configuration 2" in english(refused)
    assert "tool nest 2 would be 76 mm below floor or table" in english(refused)
    lowest = lowest_by_hand(all_along(way(BEFORE, np.add(BEYOND, -5))))
    assert lowest == pytest.approx(-76.0, abs=1.0)  # depths are told in whole millimetres


@settings(max_examples=40)
@given(start=ANGLES, end=ANGLES)
@example(start=[0, -101, -89, 0, 0, 73], end=[0, 0, 0, 0, 0, 0])  # out of the table at once
def test_ways_touch_where_dense_sampling_says_so(start, end):
    ways = way(start, end)
    lowest = lowest_by_hand(all_along(ways, begin=first_look(ways)))

    touches = touching(bodies_of(CELL), ways, floor_only=True).size > 0

    # between two looks the arm moves by some degrees in all joints: it sinks by millimetres at most
    assert abs(lowest) < 6.0 or touches == (lowest < 0.0)


def test_a_way_on_which_the_tool_hits_the_arm_is_found_and_its_depth_is_that_of_the_bodies():
    ways = way(FOLDED, np.add(UNFOLDED, -5))

    told = path_warnings(bodies_of(CELL), ways)

    assert "tool nest 3 would be 4 mm inside the arm itself" in english(told)
    assert touching(bodies_of(CELL), ways, floor_only=True).size == 0
    gap = gap_by_hand(all_along(ways, looks=300))
    assert gap == pytest.approx(-4.0, abs=2.0)  # segments as rows of points 5 mm apart, whole degrees


def gap_by_hand(joints_rad):
    """Least free space between the third nest's arm and the links before the wrist, as rows of points."""
    frames, nests = points_by_hand(joints_rad)
    shoulder, elbow, flange = (frames[k][:, None, :3, 3] for k in (1, 2, 5))
    share = np.linspace(0.0, 1.0, 60)[:, None]
    tool = flange + share * (nests[2][:, None] - flange)
    links = [(0.0 * shoulder, shoulder, 90.0), (shoulder, elbow, 70.0)]
    return min(
        np.linalg.norm(tool[:, :, None] - (a + share * (b - a))[:, None], axis=-1).min() - 8.0 - radius
        for a, b, radius in links
    )


def fixture_at(point_mm):
    """A base fixture with its first cup at a point."""
    frame = FramePlacement(*map(float, point_mm))
    cups = tuple(map(tuple, base_fixture(1, frame).cups_mm.tolist()))
    return PlannedPlacement(1, frame, cups, (), ())


def test_a_way_into_the_base_fixture_that_stands_there_is_found_and_the_cup_gone_to_is_no_obstacle():
    ways, bodies = way(BEFORE, np.add(BEFORE, 3)), bodies_of(STATED)
    _, nests = points_by_hand(ways.end_rad)
    place, far = fixture_at(nests[1][0]), fixture_at((-2000.0, 0.0, 300.0))

    told = path_warnings(beside_fixture(bodies, place, None), ways)

    assert "tool nest 2 would be" in english(told)
    assert "inside the base fixture" in english(told)
    assert path_warnings(bodies, ways) == ""
    assert path_warnings(beside_fixture(bodies, far, None), ways) == ""
    assert (
        len(beside_fixture(bodies, place, 1).fixture) == len(beside_fixture(bodies, place, None).fixture) - 1
    )


def test_a_clear_plan_is_neither_refused_nor_spoken_of():
    ways = ways_between(planned(BEFORE, np.add(BEFORE, 3), np.add(BEFORE, -4)), OFFSET)

    assert path_obstruction(bodies_of(STATED), ways) is None
    assert path_warnings(bodies_of(STATED), ways) == ""
    assert lowest_by_hand(np.vstack([ways.start_rad, ways.end_rad])) > 0.0


def test_above_a_floor_that_nobody_states_the_way_is_spoken_of_and_not_refused():
    ways = ways_between(planned(BEFORE, BEYOND, BEFORE, BEYOND), OFFSET)

    assert path_obstruction(bodies_of(CELL), ways) is None
    told = path_warnings(bodies_of(CELL), ways)
    assert "assumed floor" in english(told)
    assert "76 mm below floor or table" in english(told)
    assert "2 other paths do not look clear either." in english(told)


@pytest.mark.parametrize("offset_rad", [OFFSET, None])
def test_ways_are_those_that_a_session_goes(offset_rad):
    stops = planned(BEFORE, BEYOND, FOLDED)
    plan = SessionPlan("calibration", tuple(stops), approach_offset_rad=offset_rad)
    steps = [operation for stop in stops for operation in visit(plan, stop).operations]
    targets = np.array([step.target_rad for step in steps if isinstance(step, Move)])

    ways = ways_between(stops, offset_rad)

    np.testing.assert_allclose(ways.start_rad, targets[:-1], rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(ways.end_rad, targets[1:], rtol=0.0, atol=1e-12)


def test_from_where_the_arm_stands_leads_one_way_more():
    ways = ways_between(planned(BEYOND), None, here_rad=np.radians(BEFORE))

    assert tuple(map(english, ways.names)) == ("from the present position of the arm to configuration 1",)
    assert "from the present position of the arm" in english(path_warnings(bodies_of(CELL), ways))


def test_many_ways_at_once_are_judged_as_each_by_itself():
    bodies = bodies_of(CELL)
    ends = np.random.default_rng(0).uniform(-2.5, 2.5, (301, 6))  # some 40,000 looks: several batches
    ways = Ways(("",) * 300, ends[:-1], ends[1:])

    found = touching(bodies, ways)

    some = range(0, 300, 10)
    alone = [k for k in some if touching(bodies, Ways(("",), ends[k : k + 1], ends[k + 1 : k + 2])).size]
    assert alone == [k for k in found if k in some]
    assert 0 < len(found) < 300


def test_no_way_is_none_that_touches():
    bodies = bodies_of(CELL)

    assert path_warnings(bodies, ways_between([], OFFSET)) == ""
    assert path_warnings(bodies, ways_between(planned(BEFORE), None)) == ""
    assert path_warnings(bodies, ways_between(planned(BEFORE, BEFORE), None)) == ""


# The two arms of a double cell hang from a column: nobody knows where their floor is.
@pytest.mark.parametrize(
    "name", ["fanuc-r2000", "iiwa7-0kg", "iiwa7-1p25kg", "iiwa7-2p5kg", "irb120-drawwire"]
)
def test_the_ways_of_measured_campaigns_look_clear(measured_data, name):
    read = read_campaign(measured_data / "campaigns" / name)
    stops = (read.calibration or read.legs).stops.joints_rad
    ends = stops[np.sort(np.unique(stops, axis=0, return_index=True)[1])]
    cell = Cell(name=name, robot_key="", robot=read.robot, nests=(Nest((0.0, 0.0, 1.0)),))
    bodies = bodies_of(replace(cell, limits=CellLimits(floor_z_mm=0.0)))

    assert path_obstruction(bodies, Ways(("",) * (len(ends) - 1), ends[:-1], ends[1:])) is None


def test_an_arm_without_links_to_look_at_touches_nothing_without_a_tool():
    tiny = tuple(replace(row, a_mm=1e-3 * row.a_mm, d_mm=1e-3 * row.d_mm) for row in IRB120.joints)
    cell = replace(CELL, robot=replace(IRB120, joints=tiny), nests=())

    found = rooms(bodies_of(cell), np.zeros((2, 6)))

    assert found.names == ()
    assert (found.least_mm() == np.inf).all()
