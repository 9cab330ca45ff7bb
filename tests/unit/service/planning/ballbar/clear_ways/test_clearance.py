"""Clearance of arm, tool and bars in cells where one sees what touches."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm, frame
from truepose.exchange.robots.named import list_robots, load_robot_with_tool
from truepose.planning.ballbar.bodies import (
    arm_body,
    arm_links,
    base_fixture,
    chain_of,
    tool_body,
    tool_normal,
)
from truepose.planning.ballbar.clearance import (
    LEAN_RAD,
    Bars,
    arm_room_mm,
    bar_room_mm,
    bodies_at,
    is_clear,
)
from truepose.planning.ballbar.poses import reach

FAR = base_fixture(1, frame(0, 2000, 100))


def test_an_upright_arm_far_from_everything_is_clear():
    assert is_clear(ballbar_cell(), FAR, np.zeros((1, 6))).tolist() == [True]


def test_an_arm_that_bends_into_the_table_is_not():
    assert is_clear(ballbar_cell(), FAR, np.radians([[0, 110, 40, 0, 0, 0]])).tolist() == [False]


def test_a_tool_folded_back_to_the_forearm_is_not_clear():
    cell = ballbar_cell()

    straight, folded = arm_room_mm(
        bodies_at(cell, FAR, np.radians([[0, 0, 0, 0, 0, 0], [0, 0, 0, 0, 170, 0]]))
    )

    assert straight > 30.0
    assert folded < 10.0


def test_a_forearm_folded_down_to_the_shoulder_is_not_clear():
    folded = np.radians([[0, 80, 66, 90, -90, 0]])  # 3 mm into it; tool and flange are 17 mm off the arm

    assert is_clear(ballbar_cell(), FAR, folded).tolist() == [False]


@pytest.mark.parametrize("name", list_robots())
def test_no_shipped_robot_touches_itself_at_home(name):
    robot = load_robot_with_tool(name).robot
    without_table = replace(ballbar_cell(), robot=robot, ranges=robot.calibration_ranges, table_z_mm=-1e4)

    assert arm_room_mm(bodies_at(without_table, FAR, np.zeros((1, 6)))).min() > 30.0


def test_a_fixture_where_the_tool_is_is_touched():
    cell = ballbar_cell()
    joints = np.radians([[10.0, 40.0, 20.0, 0.0, 30.0, 0.0]])
    centre = chain_of(cell, joints).points(cell.nests_mm.mean(axis=0))[0]

    there = base_fixture(1, frame(*(centre - np.array([150.0, 87.0, -60.0]))))

    assert is_clear(cell, FAR, joints).all()
    assert not is_clear(cell, there, joints).any()


def test_each_piece_of_the_arm_belongs_to_a_link_and_has_its_radius():
    cell = ballbar_cell()

    body = arm_body(cell, chain_of(cell, np.zeros((1, 6))))

    assert len(arm_links(cell)) == len(body)
    assert body.radius_mm.tolist() == [cell.link_radii_mm[link] for link in arm_links(cell)]


def test_the_tool_fixture_is_behind_its_nests():
    cell = ballbar_cell()
    normal = tool_normal(cell.nests_mm)

    body = tool_body(cell, chain_of(cell, np.zeros((1, 6))))

    chain = chain_of(cell, np.zeros((1, 6)))
    towards = chain.end_rotation[0] @ normal
    nest = chain.points(cell.nests_mm[0])[0]
    assert normal @ cell.nests_mm[0] > 0.0
    assert np.all((body.start_mm[:, 0] - nest) @ towards < 0.0)


def a_pose():
    cell, fixture = ballbar_cell(), fixture_before_the_arm()
    found = reach(cell, fixture)
    return cell, fixture, found.joints_rad[:1], found.assembly[0].legs


def bars_of(legs):
    return Bars(np.array([[base] for base, _ in legs]), np.array([[nest] for _, nest in legs]))


def test_the_bars_of_a_reachable_pose_have_room():
    cell, fixture, joints, legs = a_pose()

    room = bar_room_mm(bodies_at(cell, fixture, joints), bars_of(legs))

    assert room.shape == (6, 1)
    assert room.min() >= cell.bar_room_mm


def test_a_bar_that_leans_over_the_rim_of_its_cup_has_none():
    cell, fixture, joints, legs = a_pose()
    from_behind = base_fixture(1, fixture.frame)
    bodies = bodies_at(cell, from_behind, joints)
    turned = type(bodies)(
        **{name: getattr(bodies, name) for name in bodies.__dataclass_fields__}
        | {"fixture_axes": -bodies.fixture_axes}
    )

    assert pytest.approx(np.radians(100.0)) == LEAN_RAD
    assert np.all(bar_room_mm(turned, bars_of(legs)) == -np.inf)


def test_a_bar_through_a_post_has_none():
    cell, fixture, joints, legs = a_pose()
    bodies = bodies_at(cell, fixture, joints)
    base, nest = legs[0]
    middle = (fixture.cups_mm[base - 1] + bodies.nests_mm[nest - 1, 0]) / 2
    post = bodies.fixture.some([len(bodies.fixture) - 1])
    post.start_mm[:] = middle
    post.end_mm[:] = middle - [0.0, 0.0, 50.0]
    hindered = type(bodies)(
        **{name: getattr(bodies, name) for name in bodies.__dataclass_fields__}
        | {
            "fixture": type(post)(
                np.concatenate([bodies.fixture.start_mm, post.start_mm]),
                np.concatenate([bodies.fixture.end_mm, post.end_mm]),
                np.concatenate([bodies.fixture.radius_mm, post.radius_mm]),
            )
        }
    )

    room = bar_room_mm(hindered, bars_of(legs))

    assert room[0, 0] < 0.0
    assert room[1:].max() > 0.0
