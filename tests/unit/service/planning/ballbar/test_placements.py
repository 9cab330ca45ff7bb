"""The search for places of the base fixture: usable, better than a first guess, and repeatable."""

import numpy as np
import pytest

from tests.helpers.ballbar.cells import ballbar_cell, fixture_before_the_arm
from truepose.planning.ballbar.arm_model import arm_model
from truepose.planning.ballbar.expected_information import predicted_error_mm, work_space_sample
from truepose.planning.ballbar.placements import PlacementRequest, suggest
from truepose.planning.ballbar.pose_selection import candidates, information_after
from truepose.planning.ballbar.poses import setups
from truepose.planning.errors import TooFewCandidatesError

SHORT = {"draws": 50, "moves": 10, "starts": 1}
CELL = ballbar_cell()


def test_a_suggested_place_offers_what_was_asked_for():
    (fixture,) = suggest(CELL, PlacementRequest(poses=60, **SHORT)).fixtures

    assert len(candidates(arm_model(CELL), fixture)) >= 60
    assert len(setups(CELL, fixture)) == 3
    assert fixture.cups_mm[:, 2].min() >= 60.0
    assert fixture.hub_mm[2] >= 60.0


def test_it_leaves_less_error_than_a_place_by_hand():
    model = arm_model(CELL)
    sample = work_space_sample(model, 100, np.random.default_rng(9))

    (fixture,) = suggest(CELL, PlacementRequest(poses=60, seed=1, **SHORT)).fixtures

    by_search, by_hand = (
        predicted_error_mm(information_after(model, [candidates(model, place)], [None], 60), sample)
        for place in (fixture, fixture_before_the_arm())
    )
    assert by_search < 1.05 * by_hand


def test_more_placements_leave_less_error_than_one():
    one = suggest(CELL, PlacementRequest(poses=40, **SHORT))
    two = suggest(CELL, PlacementRequest(placements=2, poses=40, **SHORT))

    assert [fixture.number for fixture in two.fixtures] == [1, 2]
    assert two.error_mm < one.error_mm


def test_a_fourth_cup_is_placed_as_well():
    (fixture,) = suggest(CELL, PlacementRequest(base_points=4, poses=40, **SHORT)).fixtures

    assert fixture.cups_mm.shape == (4, 3)


def test_the_same_seed_gives_the_same_place():
    first, second = (suggest(CELL, PlacementRequest(poses=40, draws=20, moves=4, starts=1)) for _ in range(2))

    assert first.fixtures[0].frame == second.fixtures[0].frame


def test_a_place_that_holds_no_setting_ball_ends_no_search_that_found_others():
    # The last of its 13 usable places does not hold the ball at every cup.
    request = PlacementRequest(poses=10, draws=24, moves=0, starts=13)

    assert suggest(CELL, request).usable == 13


@pytest.mark.parametrize(("placements", "each"), [(1, 501), (2, 251)])
def test_more_poses_than_any_place_offers_are_refused(placements, each):
    with pytest.raises(TooFewCandidatesError, match=f"positions tried allows {each} "):
        suggest(CELL, PlacementRequest(placements=placements, poses=501, draws=10, moves=0))


def test_where_nothing_is_clear_nothing_is_suggested():
    with pytest.raises(TooFewCandidatesError):
        suggest(ballbar_cell(arm_room_mm=1000.0), PlacementRequest(poses=1, draws=10, moves=0))
