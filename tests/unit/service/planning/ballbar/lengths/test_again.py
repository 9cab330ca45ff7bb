"""Poses aimed anew after a pre-calibration: coded where they can be, none lost, ways between them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm, frame
from tests.helpers.ballbar.nominal_poses import nominal_lengths, reachable
from truepose.planning.ballbar.bodies import base_fixture
from truepose.planning.ballbar.clearance import is_clear
from truepose.planning.ballbar.length_targets import aimed_again
from truepose.planning.ballbar.motion_clearance import between
from truepose.planning.errors import NoWayError

CELL, FIXTURE = ballbar_cell(), fixture_before_the_arm()
POSES = reachable(CELL, FIXTURE)[1:31:2]
HERE = reachable(CELL, FIXTURE)[40].joints_rad
IN_THE_TABLE = tuple(np.radians([0.0, 110.0, 40.0, 0.0, 0.0, 0.0]))
NEXT = base_fixture(2, frame(300, -200, 300, 0, -30, 60))
CLEAR_OF_NEXT = [pose for pose in POSES if is_clear(CELL, NEXT, np.array([pose.joints_rad])).all()]


def found_cups():
    """Cups where a pre-calibration may find them: within the 2 mm in which they snap on the ball."""
    return FIXTURE.cups_mm + np.random.default_rng(0).uniform(-1.0, 1.0, (3, 3))


def lengths_with(cups):
    return lambda pose: nominal_lengths(CELL, cups, pose.legs)


def test_all_poses_come_back_with_coded_lengths_under_the_model():
    lengths = lengths_with(found_cups())

    again = aimed_again(CELL, FIXTURE, POSES, lengths, HERE)

    assert again.refusals == ()
    assert sorted(pose.config for pose in again.poses) == sorted(pose.config for pose in POSES)
    for pose in again.poses:
        assert lengths(pose)(np.array([pose.joints_rad]))[0] == pytest.approx(pose.aimed_mm, abs=1e-4)


def test_the_ways_lead_from_where_the_arm_is_through_all_poses():
    again = aimed_again(CELL, FIXTURE, POSES, lengths_with(found_cups()), HERE)

    stops = [HERE]
    for pose in again.poses:
        stops += [*pose.via_rad, pose.joints_rad]
    for a, b in pairwise(np.array(stops)):
        # 3 mm of the room of 10 may be used by aims, a little by what lies between two checks
        assert is_clear(replace(CELL, arm_room_mm=6.0), FIXTURE, between(a, b)).all()


def test_a_pose_that_cannot_be_coded_is_not_lost():
    doubled = replace(POSES[0], legs=(*POSES[0].legs[:5], POSES[0].legs[0]))

    again = aimed_again(CELL, FIXTURE, [doubled, POSES[1]], lengths_with(FIXTURE.cups_mm), HERE)

    (sentence,) = again.refusals
    kept = next(pose for pose in again.poses if pose.config == doubled.config)
    assert f"Configuration {doubled.config} cannot be given coded ballbar lengths" in sentence
    assert "stays as planned" in sentence
    assert kept.aimed_mm is None
    assert kept.joints_rad == doubled.joints_rad


def test_a_pose_whose_code_is_out_of_range_is_aimed_at_nominal_lengths():
    pose = POSES[0]
    here = zip(CELL.ranges, pose.joints_rad, strict=True)
    tight = tuple(replace(limit, lower_rad=q - 1e-6, upper_rad=q + 1e-6) for limit, q in here)
    held = replace(CELL, ranges=tight)

    again = aimed_again(held, FIXTURE, [pose], lengths_with(FIXTURE.cups_mm), pose.joints_rad)

    assert "all set to nominal" in again.refusals[0]
    assert again.poses[0].joints_rad == pytest.approx(pose.joints_rad, abs=1e-6)


def test_no_poses_are_no_trouble():
    again = aimed_again(CELL, FIXTURE, [], lengths_with(FIXTURE.cups_mm), HERE)

    assert again.poses == ()


def again_before(after, poses, last):
    return aimed_again(CELL, FIXTURE, poses, lengths_with(FIXTURE.cups_mm), HERE, last=last, after=after)


def ends_clear_of_next(again):
    # 3 mm of the room of 10 may be used by aims
    cell = replace(CELL, arm_room_mm=7.0)
    return is_clear(cell, NEXT, np.array([again.poses[-1].joints_rad])).all()


def test_the_pose_where_the_arm_waits_stays_the_last_one():
    last = CLEAR_OF_NEXT[2].config

    again = again_before(NEXT, POSES, last)

    assert again.poses[-1].config == last
    assert len(again.poses) == len(POSES)


def test_where_the_arm_was_to_wait_was_measured_it_waits_where_the_next_fixture_has_room():
    waiting = CLEAR_OF_NEXT[0]

    again = again_before(NEXT, [pose for pose in POSES if pose != waiting], waiting.config)

    assert ends_clear_of_next(again)
    assert len(again.poses) == len(POSES) - 1


def test_where_no_way_leads_to_where_the_arm_was_to_wait_it_waits_elsewhere():
    in_the_table = replace(POSES[0], joints_rad=IN_THE_TABLE)

    again = again_before(NEXT, [in_the_table, *CLEAR_OF_NEXT[:3]], in_the_table.config)

    assert ends_clear_of_next(again)
    assert len(again.poses) == 3


def test_an_arm_that_would_wait_where_the_next_fixture_comes_is_a_sentence():
    among_the_poses = base_fixture(2, frame(300, -200, 400, 0, -30, 60))

    with pytest.raises(NoWayError, match="in the way when the base fixture is moved to placement 2"):
        again_before(among_the_poses, POSES, POSES[0].config)


def test_a_pose_that_the_arm_cannot_go_to_clear_is_left_out_and_named():
    in_the_table = replace(POSES[0], joints_rad=IN_THE_TABLE)

    again = aimed_again(CELL, FIXTURE, [in_the_table, POSES[1]], lengths_with(FIXTURE.cups_mm), HERE)

    assert [pose.config for pose in again.poses] == [POSES[1].config]
    missed = f"No collision-free path to configuration {in_the_table.config} was found; it is left out."
    assert missed in again.refusals
