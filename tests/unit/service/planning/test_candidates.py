"""Candidates keep every rule of the work space; each rule is looked at by itself."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.service.sessions.tracker.fakes import IRB120, TRACKER_AT
from truepose.domain.robot import FramePlacement, JointRange, Nest
from truepose.planning.errors import TooFewCandidatesError, WorkSpaceError
from truepose.planning.workspace.bodies import bodies_in, rooms
from truepose.planning.workspace.candidates import cosines_in_sight, draw_candidates, judge
from truepose.planning.workspace.space import (
    COLUMN_RADIUS_MM,
    TABLE_CLEARANCE_MM,
    WorkSpace,
    cosines_to_tracker,
    is_clear,
    nest_places,
    nominal_chain,
)

FACINGS = ((-0.80, -0.45, 0.40), (-0.20, 0.70, 0.70), (0.85, -0.40, 0.35))
CENTRES = ((0.0, 0.0, 125.0), (75.0, 93.675, 215.0), (150.0, 0.0, 125.0))
NESTS = tuple(Nest(centre, 0.002, facing) for centre, facing in zip(CENTRES, FACINGS, strict=True))
SPACE = WorkSpace(
    IRB120, FramePlacement(), NESTS, IRB120.calibration_ranges, TRACKER_AT, approach_offset_rad=-0.0873
)


def rng():
    return np.random.default_rng(1)


def without_a_last_length(space):
    """Return the same arm and tool, counted from a flange frame that lies in the wrist."""
    *before, last = space.robot.joints
    robot = replace(space.robot, joints=(*before, replace(last, d_mm=0.0)))
    moved = [(x, y, z + last.d_mm) for x, y, z in CENTRES]
    nests = tuple(replace(nest, centre_mm=centre) for nest, centre in zip(space.nests, moved, strict=True))
    return replace(space, robot=robot, nests=nests)


@pytest.fixture(scope="module")
def drawn():
    return draw_candidates(SPACE, 2000, np.random.default_rng(1))


def test_forearm_and_upper_arm_hide_nests_and_stop_the_tool_whatever_the_last_length_is():
    seen_from_everywhere = tuple(replace(nest, facing=None) for nest in NESTS)
    space = replace(SPACE, table_z_mm=-1e6, nests=seen_from_everywhere)
    short = without_a_last_length(space)
    joints = np.radians(rng().uniform(-150.0, 150.0, (3000, 6)))  # folded in more ways than it is measured

    hidden, hidden_of_short = (
        np.isneginf(cosines_in_sight(one, nominal_chain(one, joints))) for one in (space, short)
    )
    touching, touching_of_short = (rooms(bodies_in(one), joints).least_mm() < 0.0 for one in (space, short))

    assert hidden_of_short.tolist() == hidden.tolist()
    assert 0 < touching.sum() == (touching & touching_of_short).sum()


def test_as_many_are_drawn_as_are_asked_for_and_all_lie_in_the_ranges(drawn):
    low = [limit.lower_rad for limit in SPACE.ranges]
    high = [limit.upper_rad for limit in SPACE.ranges]

    assert len(drawn) == 2000
    assert np.all((drawn.joints_rad >= low) & (drawn.joints_rad <= high))


def test_the_chosen_nest_faces_the_tracker_within_30_degrees_and_best_of_all(drawn):
    chain = nominal_chain(SPACE, drawn.joints_rad)
    beams = np.array(TRACKER_AT) - nest_places(SPACE, chain)
    beams /= np.linalg.norm(beams, axis=-1, keepdims=True)
    facing = np.array(FACINGS) / np.linalg.norm(FACINGS, axis=1, keepdims=True)
    cosines = np.einsum("nij,kj,kni->kn", chain.rotation[-1], facing, beams)

    chosen = cosines[drawn.nest - 1, np.arange(len(drawn))]

    assert np.all(np.degrees(np.arccos(chosen)) <= 30.0)
    assert np.array_equal(np.argmax(cosines, axis=0) + 1, drawn.nest)


def test_every_nest_has_its_share(drawn):
    # three cones of the same size on an arm that turns every way: about a third each
    assert np.all(np.bincount(drawn.nest)[1:] > 2000 / 6)


def test_nests_flange_and_wrist_stay_above_the_table_also_where_the_approach_begins(drawn):
    for joints in (drawn.joints_rad, drawn.joints_rad - 0.0873):
        chain = nominal_chain(SPACE, joints)
        assert np.min(nest_places(SPACE, chain)[..., 2]) >= TABLE_CLEARANCE_MM
        assert np.min(chain.origin[-3:, :, 2]) >= TABLE_CLEARANCE_MM


def test_a_higher_table_leaves_fewer_configurations():
    high_table = replace(SPACE, table_z_mm=300.0)
    joints = draw_candidates(SPACE, 500, rng()).joints_rad

    feasible, _ = judge(high_table, joints, rng())

    assert 0 < feasible.sum() < 500


def test_a_tool_folded_into_the_robots_own_column_is_no_candidate():
    # upper arm upright, forearm straight down along it: the tool hangs beside the base
    folded = np.radians([[0.0, 0.0, 85.0, 0.0, 80.0, 0.0]])
    chain = nominal_chain(SPACE, folded)
    distances = np.hypot(*np.moveaxis(nest_places(SPACE, chain)[..., :2], -1, 0))
    assert distances.min() < COLUMN_RADIUS_MM  # it is there, so that the rule has something to say

    assert not is_clear(SPACE, chain)[0]


def test_a_beam_through_the_robots_column_sees_nothing():
    stretched = np.radians([[0.0, 60.0, 10.0, 0.0, 0.0, 0.0]])  # arm forwards, low
    seen_from_all_sides = replace(SPACE, nests=tuple(replace(nest, facing=None) for nest in NESTS))
    in_front = replace(seen_from_all_sides, tracker_position_mm=(2600.0, 0.0, 300.0))
    behind = replace(seen_from_all_sides, tracker_position_mm=(-2600.0, 0.0, 100.0))

    assert np.all(cosines_to_tracker(in_front, nominal_chain(SPACE, stretched)) == 1.0)
    assert np.any(np.isneginf(cosines_to_tracker(behind, nominal_chain(SPACE, stretched))))


def test_the_place_of_the_base_is_taken_into_account():
    moved = replace(SPACE, base=FramePlacement(500.0, -200.0, 0.0, 0.0, 0.0, 1.0))
    joints = draw_candidates(SPACE, 300, rng()).joints_rad

    feasible, _ = judge(moved, joints, rng())

    assert 0 < feasible.sum() < 300


def test_reflectors_seen_from_everywhere_share_the_configurations_by_chance():
    seen_from_all_sides = replace(SPACE, nests=tuple(replace(nest, facing=None) for nest in NESTS))

    drawn = draw_candidates(replace(seen_from_all_sides, tracker_position_mm=None), 300, rng())

    assert len(drawn) == 300


def test_a_controller_that_cannot_reach_the_approach_rules_the_edge_out():
    tight = replace(SPACE, joint_limits=SPACE.ranges)

    drawn = draw_candidates(tight, 500, rng())

    low = np.array([limit.lower_rad for limit in SPACE.ranges])
    assert np.all(drawn.joints_rad >= low + 0.0873 - 1e-12)


@pytest.mark.parametrize(
    ("changes", "sentence"),
    [
        ({"nests": ()}, "no tool nest"),
        ({"nests": (Nest(None),)}, "Tool nest 1 has no centre"),
        ({"ranges": SPACE.ranges[:5]}, "5 joint ranges were given for 6 joints"),
        ({"ranges": (JointRange(1.0, 0.0), *SPACE.ranges[1:])}, "end of the ranges of joint 1 is below"),
        ({"tracker_position_mm": None}, "nominal position"),
    ],
)
def test_a_cell_that_contradicts_itself_is_refused_with_one_sentence(changes, sentence):
    with pytest.raises(WorkSpaceError, match=sentence):
        draw_candidates(replace(SPACE, **changes), 5, rng())


def test_a_cell_without_feasible_configurations_says_what_to_look_at():
    buried = replace(SPACE, table_z_mm=5000.0)

    with pytest.raises(TooFewCandidatesError, match="the table height"):
        draw_candidates(buried, 5, rng())


def test_the_same_seed_draws_the_same_candidates():
    first, second = (draw_candidates(SPACE, 50, np.random.default_rng(3)) for _ in range(2))

    assert np.array_equal(first.joints_rad, second.joints_rad)
