"""What a page draws of a step: cups and nests where they are, seen from where a person can stand."""

import numpy as np
import pytest

from tests.helpers.ballbar.cells import domain_cell
from tests.helpers.ballbar.sessions import make_ballbar_plan, measured, moved
from truepose.domain.cell import BallbarKit
from truepose.domain.ledger import EntryKind, LedgerEntry
from truepose.domain.session import SessionState
from truepose.kinematics.chain import forward, nominal_values
from truepose.sessions.ballbar.scene import scene_of
from truepose.sessions.ballbar.service import BallbarView
from truepose.sessions.ballbar.situation import situation
from truepose.storage.records import SessionSetup

PLAN, CELL, KIT = make_ballbar_plan(), domain_cell(ballbar=BallbarKit()), BallbarKit()
START = LedgerEntry("tool/initialise", EntryKind.CONTROL, 1.0, "Ada", "t1", "k", "running: started")
TOOL = [measured(f"tool/{step}", 150.0) for step in ("initialise", "side-1-2", "side-2-3", "side-1-3")]


def done(*step_ids):
    return [LedgerEntry(step_id, EntryKind.CONFIRMED, 60.0, "Ada", "t1") for step_id in step_ids]


def until_pose():
    """Everything up to the first pose."""
    entries = [*TOOL, *done("tool/detach", "placement-1/place", "placement-1/ball")]
    for point in (1, 2, 3):
        entries += [moved(f"placement-1/cup-{point}/move", (0.1 * point,) * 6)]
        entries += done(f"placement-1/cup-{point}/clamp")
    entries += done("placement-1/ball-out")
    entries += [measured(f"placement-1/{s}") for s in ("initialise", "side-1-2", "side-2-3", "side-1-3")]
    return [*entries, *done("placement-1/detach")]


def scene(*entries):
    found = situation(PLAN, KIT, (START, *entries))
    return found.step, scene_of(BallbarView("six legs", SessionSetup(CELL), PLAN, None, 1, found, None))


def named(shown):
    return {point.name: np.array(point.position_mm) for point in shown.points}


def test_a_leg_is_drawn_between_its_cup_and_the_nest_where_the_arm_stands():
    joints = np.full(6, 0.2)
    entries = [*until_pose(), moved("placement-1/pose-1/move", tuple(joints))]

    step, shown = scene(*entries, measured("placement-1/pose-1/initialise", 300.0))

    chain = forward(nominal_values(CELL.robot, joints[None]), np.eye(3), np.zeros(3))
    nest = chain.points(np.array(CELL.nests[0].centre_mm))[0]
    assert step.points == (1, 1)
    assert shown.leg == ("B1", "T1")
    np.testing.assert_allclose(named(shown)["T1"], nest, atol=1e-3)  # as rounded for the page
    np.testing.assert_array_equal(named(shown)["B1"], PLAN.placements[0].cups_mm[0])
    np.testing.assert_allclose(shown.arm_mm[-1], chain.end_origin[0], atol=1e-3)
    assert shown.before_move_arm_mm is None


def test_a_motion_shows_the_arm_where_it_is_and_where_it_will_be():
    step, shown = scene(*until_pose())

    assert step.id == "placement-1/pose-1/move"
    assert shown.leg is None
    assert shown.arm_mm != shown.before_move_arm_mm
    now = forward(nominal_values(CELL.robot, np.full((1, 6), 0.3)), np.eye(3), np.zeros(3)).end_origin[0]
    np.testing.assert_allclose(shown.before_move_arm_mm[-1], now, atol=1e-3)


@pytest.mark.parametrize(
    ("entries", "leg"),
    [(TOOL[:1], ("T1", "T2")), (until_pose()[:-4], ("B1", "B2"))],
    ids=["tool", "base"],
)
def test_a_side_joins_two_points_of_one_triangle(entries, leg):
    _, shown = scene(*entries)

    assert shown.leg == leg


def test_the_person_stands_beyond_what_is_looked_at_as_seen_from_the_robot_and_looks_down_on_it():
    _, shown = scene(*until_pose(), moved("placement-1/pose-1/move", (0.2,) * 6))

    stand, look_at = np.array(shown.stand_mm), np.array(shown.look_at_mm)
    assert np.linalg.norm(stand[:2]) > np.linalg.norm(look_at[:2])
    assert stand[2] > look_at[2]


def test_the_view_stays_while_the_legs_of_a_pose_are_connected():
    arrived = [*until_pose(), moved("placement-1/pose-1/move", (0.2,) * 6)]
    arrived += [measured("placement-1/pose-1/initialise", 300.0)]

    views = [
        scene(*arrived, *(measured(f"placement-1/pose-1/leg-{leg}") for leg in legs))[1].stand_mm
        for legs in ([], ["1-1"], ["1-1", "1-2"])
    ]

    assert len(set(views)) == 1


def test_before_its_first_motion_nobody_says_where_the_arm_is():
    _, initialising = scene()
    _, placing = scene(*TOOL, *done("tool/detach"))

    assert initialising.points == ()
    assert [point.kind for point in placing.points] == ["cup"] * 3
    assert initialising.arm_mm == placing.arm_mm == ((0.0, 0.0, 0.0),)


def test_a_tool_triangle_is_drawn_wherever_the_arm_is():
    _, shown = scene(*TOOL[:1])

    assert [point.name for point in shown.points] == ["T1", "T2", "T3"]
    assert shown.arm_mm == ((0.0, 0.0, 0.0),)


def test_the_first_motion_shows_where_the_arm_will_be_and_not_where_it_was():
    step, shown = scene(*TOOL, *done("tool/detach", "placement-1/place", "placement-1/ball"))

    assert step.id == "placement-1/cup-1/move"
    assert len(shown.arm_mm) > 3
    assert shown.before_move_arm_mm is None


def test_of_a_session_that_is_done_the_cell_is_drawn_as_it_stands():
    ended = LedgerEntry("", EntryKind.CONTROL, 99.0, entered=SessionState.ABORTED, text="asked for")

    _, shown = scene(*until_pose(), ended)

    assert len(shown.arm_mm) > 3
