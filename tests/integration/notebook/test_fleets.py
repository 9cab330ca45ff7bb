"""Fleets in a notebook: robots of a simulated type, of which one ages."""

from dataclasses import replace
from datetime import date, timedelta

import pytest

import truepose as tp
from tests.studies.fleet.simulated import TRACKERS, Ageing, FleetTruth, draw_fleet, record_robot
from truepose.notebook.campaign import Campaign

_FIRST = date(2026, 1, 1)
_WORN = Ageing("compliance", 3, 3e-7)  # twice the spring itself


@pytest.fixture(scope="module")
def fleet():
    drawn = draw_fleet(3, robots=4, ageing=0, drifting=False)
    robots = tuple(
        type(one)(one.number, one.links, one.changes, _WORN if one.number == 2 else None)
        for one in drawn.robots
    )
    truth = FleetTruth(3, robots, None)
    recorded = [
        record_robot(robot, month, TRACKERS[(robot.number + month) % 2], truth, 25)
        for robot in robots
        for month in (0, 2, 3, 5)
    ]
    return tp.fleet_of(
        (one.robot, one.instrument, _FIRST + timedelta(one.day), Campaign(one.campaign)) for one in recorded
    )


def test_it_says_which_robot_ages_and_what_in_it(fleet):
    pytest.importorskip("pandas")

    changes = fleet.changes

    assert changes[["what", "cause", "kind"]].values.tolist() == [
        ["robot 02", "compliance of joint 3", "linear"]
    ]
    assert changes["since"][0] == _FIRST.toordinal()
    assert "robot 02: compliance of joint 3" in repr(fleet)
    assert "compliance of joint 3" in fleet._repr_html_()


def test_it_says_when_a_limit_is_passed(fleet):
    pytest.importorskip("pandas")
    size_mm = fleet.changes["size_mm"][0]

    found = fleet.forecast(2.0 * size_mm)

    assert found["day"][0] == pytest.approx(_FIRST.toordinal() + 300, abs=1)  # twice 150 days
    assert found["earliest"][0] < found["day"][0] < found["latest"][0]


def test_it_says_what_the_type_is(fleet):
    pytest.importorskip("pandas")

    table = fleet.to_frame().set_index("name")

    assert table.loc["c_2", "unit"] == "rad/(N*mm)"
    assert 0.5 * 3.2e-8 < table.loc["c_2", "value"] < 2.0 * 3.2e-8  # the maker's hint
    assert list(table.index) == list(fleet.belief.names)


def test_it_says_how_a_change_went(fleet):
    pytest.importorskip("pandas")

    course = fleet.course(1)

    assert course["size_mm"].is_monotonic_increasing
    assert course["size_mm"].iloc[-1] == pytest.approx(
        fleet.changes["size_mm"][0], abs=4.0 * course["u_mm"].max()
    )
    with pytest.raises(tp.TrueposeError, match="no change 2: the fleet has 1 change"):
        fleet.course(2)


def test_a_new_robot_is_identified_with_what_its_type_is(fleet):
    pytest.importorskip("pandas")
    newcomer = draw_fleet(3, robots=5, ageing=0, drifting=False).robots[4]
    recorded = record_robot(newcomer, 0, TRACKERS[0], FleetTruth(3, (newcomer,), None), 15)

    found = tp.identify(Campaign(recorded.campaign), fleet=fleet)

    assert found.status == "converged"
    assert set(fleet.belief.names) <= set(found.to_frame()["name"])


def test_a_campaign_counts_once(fleet):
    robot = FleetTruth(3, draw_fleet(3, robots=4, ageing=0, drifting=False).robots, None).robots[0]
    again = record_robot(robot, 0, TRACKERS[robot.number % 2], FleetTruth(3, (robot,), None), 25)

    with pytest.raises(tp.TrueposeError, match="would then count twice"):
        tp.identify(Campaign(again.campaign), fleet=fleet)


def test_robots_of_two_types_are_no_fleet(fleet):
    robot = draw_fleet(3, robots=2, ageing=0, drifting=False).robots[0]
    one = record_robot(robot, 0, TRACKERS[0], FleetTruth(3, (robot,), None), 15).campaign
    other = replace(one, robot=replace(one.robot, name="Another"))

    with pytest.raises(tp.TrueposeError, match=r"one type, but these are .*120.*, Another"):
        tp.fleet_of([("left", "tracker", 0, Campaign(one)), ("right", "tracker", 0, Campaign(other))])
    with pytest.raises(tp.TrueposeError, match="compare each type separately"):
        tp.identify(Campaign(other), fleet=fleet)
