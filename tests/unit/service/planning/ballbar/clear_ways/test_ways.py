"""Ways between stops are clear all along, or there is none."""

from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm, frame
from truepose.planning.ballbar.bodies import base_fixture, chain_of
from truepose.planning.ballbar.clearance import arm_room_mm, bodies_at
from truepose.planning.ballbar.motion_clearance import Stop, Surroundings, between, is_clear_along, lift
from truepose.planning.ballbar.paths import way
from truepose.planning.ballbar.poses import reach, setups
from truepose.planning.errors import NoWayError

CELL = ballbar_cell()
FAR = Surroundings(CELL, base_fixture(1, frame(0, 2000, 100)))


def finely(start, via, end):
    """Configurations along a way, five times as dense as it was checked."""
    points = [np.asarray(start), *(np.asarray(point) for point in via), np.asarray(end)]
    legs = []
    for a, b in pairwise(points):
        share = np.linspace(0, 1, 5 * len(between(a, b)))[:, None]
        legs.append((1 - share) * a + share * b)
    return np.concatenate(legs)


def test_with_nothing_between_there_is_no_via_point():
    stops = (Stop(np.zeros(6)), Stop(np.radians([60.0, 20.0, 10.0, 30.0, 20.0, 40.0])))

    assert way(FAR, *stops, np.random.default_rng(0)) == ()


@pytest.mark.parametrize("points", [3, 4])
def test_all_ways_through_the_poses_of_a_placement_keep_room(points):
    fixture = fixture_before_the_arm(points)
    around = Surroundings(CELL, fixture)
    found = reach(CELL, fixture).joints_rad[::9]

    for start, end in pairwise(found):
        via = way(around, Stop(start), Stop(end), np.random.default_rng(1))

        room = arm_room_mm(bodies_at(CELL, fixture, finely(start, via, end)))
        # between two checks 2 deg apart the tool sinks by less than a hundredth of its 30 mm step
        assert room.min() > CELL.arm_room_mm - 1.0


def test_a_way_round_the_stand_has_via_points():
    fixture = fixture_before_the_arm(4)
    around = Surroundings(CELL, fixture)
    joints = reach(CELL, fixture).joints_rad
    hindered = [end for end in joints if not is_clear_along(around, between(joints[0], end))]

    vias = [way(around, Stop(joints[0]), Stop(end), np.random.default_rng(2)) for end in hindered[:5]]

    assert len(vias) > 0
    assert all(len(via) for via in vias)


def test_the_tool_leaves_the_cup_of_a_set_up_along_its_axis():
    fixture = fixture_before_the_arm()
    around = Surroundings(CELL, fixture)
    setup = setups(CELL, fixture)[0]
    stop = Stop(np.array(setup.joints_rad), setup.base_point)

    first, lifted = lift(around, stop)

    nests = chain_of(CELL, np.array([first, lifted])).points(CELL.nests_mm[0])
    rise = nests[1] - nests[0]
    assert rise @ fixture.axes[0] == pytest.approx(np.linalg.norm(rise))
    assert np.linalg.norm(rise) >= 60.0 - 1e-6


def test_from_set_up_to_set_up_the_way_begins_and_ends_with_a_lift():
    fixture = fixture_before_the_arm()
    around = Surroundings(CELL, fixture)
    one, two = (Stop(np.array(s.joints_rad), s.base_point) for s in setups(CELL, fixture)[:2])

    via = way(around, one, two, np.random.default_rng(0))

    assert via[0] == pytest.approx(tuple(lift(around, one)[1]))
    assert via[-1] == pytest.approx(tuple(lift(around, two)[1]))


def test_the_same_seed_gives_the_same_way():
    fixture = fixture_before_the_arm()
    joints = reach(CELL, fixture).joints_rad
    stops = (Stop(joints[0]), Stop(joints[-1]))
    around = Surroundings(CELL, fixture)

    ways = [way(around, *stops, np.random.default_rng(5)) for _ in range(2)]

    assert ways[0] == ways[1]


def test_to_a_stop_in_the_table_there_is_no_way():
    inside = Stop(np.radians([0.0, 110.0, 40.0, 0.0, 0.0, 0.0]))

    with pytest.raises(NoWayError, match="No collision-free path between two configurations"):
        way(FAR, Stop(np.zeros(6)), inside, np.random.default_rng(0))


def test_a_cup_that_the_tool_cannot_leave_is_named():
    fixture = fixture_before_the_arm()
    tight = Surroundings(ballbar_cell(arm_room_mm=500.0), fixture)
    setup = setups(CELL, fixture)[1]

    with pytest.raises(NoWayError, match="cannot retract from base point 2 of placement 1"):
        lift(tight, Stop(np.array(setup.joints_rad), 2))
