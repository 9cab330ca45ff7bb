"""Keep-out volumes: what is chosen stays outside, judged by points all over arm, tool and beam."""

from dataclasses import replace

import numpy as np
import pytest

from tests.unit.service.planning.test_candidates import NESTS, SPACE
from tests.unit.service.planning.test_way_room import CELL, OFFSET, STATED, planned, points_by_hand
from truepose.domain.cell import Box, Cylinder, HalfSpace, KeepOuts
from truepose.domain.identification import NotIdentifiable
from truepose.domain.robot import JointRange
from truepose.messages.catalogue import english
from truepose.planning.errors import TooFewCandidatesError, WorkSpaceError
from truepose.planning.prediction.plan import because_of
from truepose.planning.prediction.tracker import promised_session, session_plan
from truepose.planning.tracker.added_stops import WantedStop, addition
from truepose.planning.tracker.plans import plan_validation
from truepose.planning.workspace.bodies import bodies_of, first_obstruction
from truepose.planning.workspace.candidates import cosines_in_sight, draw_candidates, is_seen
from truepose.planning.workspace.capsules import least_mm, signed_mm
from truepose.planning.workspace.path_clearance import path_obstruction, ways_between
from truepose.planning.workspace.space import cosines_to_tracker, nominal_chain

FEW = 400
SLOT = (("left", 90.0), ("right", -90.0))  # the upper arm between them is 140 mm wide
CONVEYOR = Box("conveyor", (250.0, 100.0, 0.0), (700.0, 500.0, 500.0))
POST = Cylinder("post", (300.0, -300.0, 0.0), (300.0, -300.0, 900.0), 30.0)
WALL = HalfSpace("wall", (0.0, 350.0, 0.0), (0.0, -2.0, 0.0))
ALL = KeepOuts((CONVEYOR,), (POST,), (WALL,))


def rng():
    return np.random.default_rng(1)


def inside(points):
    """Whether points (..., 3) are in one of the three volumes, straight from their definitions."""
    x, y, z = np.moveaxis(points, -1, 0)
    box = (x > 250) & (x < 700) & (y > 100) & (y < 500) & (z > 0) & (z < 500)
    post = (np.hypot(x - 300, y + 300) < 30) & (z > 0) & (z < 900)
    return box | post | (y > 350)


def skeleton(joints_rad, looks=9):
    """Points along links and tool of configurations (n, 6), shape (n, k, 3), by products of matrices."""
    frames, nests = points_by_hand(joints_rad)
    elbow, wrist, flange = (frames[k][:, :3, 3] for k in (2, 3, 5))
    shoulder = frames[1][:, :3, 3]
    pieces = [(shoulder, elbow), (elbow, wrist), (wrist, flange), *((flange, nest) for nest in nests)]
    share = np.linspace(0.0, 1.0, looks)[:, None, None]
    return np.concatenate([np.moveaxis(a + share * (b - a), 0, 1) for a, b in pieces], axis=1)


@pytest.mark.parametrize(
    ("volume", "point", "distance"),
    [
        (CONVEYOR, (800.0, 300.0, 200.0), 100.0),
        (CONVEYOR, (730.0, 540.0, 200.0), 50.0),
        (CONVEYOR, (400.0, 130.0, 200.0), -30.0),
        (POST, (300.0, -200.0, 400.0), 70.0),
        (POST, (300.0, -300.0, 950.0), 50.0),
        (POST, (300.0, -310.0, 400.0), -20.0),
        (WALL, (50.0, 300.0, -70.0), 50.0),
        (WALL, (0.0, 400.0, 0.0), -50.0),
    ],
)
def test_distances_are_those_that_one_works_out_by_hand(volume, point, distance):
    assert signed_mm(volume, np.array(point)) == pytest.approx(distance)


@pytest.mark.parametrize("volume", list(ALL), ids=lambda volume: volume.name)
def test_the_least_distance_of_a_segment_is_that_of_its_nearest_point(volume):
    ends = rng().uniform(-600.0, 900.0, (2, 400, 3))
    share = np.linspace(0.0, 1.0, 1001)[:, None, None]
    dense = signed_mm(volume, ends[0] + share * (ends[1] - ends[0])).min(axis=0)

    least = least_mm(volume, ends[:1], ends[1:])[0]

    near = dense < 150.0
    assert near.sum() > 50
    assert least[near] == pytest.approx(dense[near], abs=2.0)  # both look at a thousandth of 2 m
    assert np.all(least[~near] <= dense[~near] + 2.0)
    assert np.all(least[~near] > 0.0)


def test_what_is_drawn_keeps_outside_with_arm_and_tool_at_the_stop_and_its_approach():
    free = draw_candidates(SPACE, FEW, rng()).joints_rad
    kept = draw_candidates(replace(SPACE, keep_outs=ALL), FEW, rng()).joints_rad

    assert inside(skeleton(free)).any()  # the volumes do stand in the way
    assert not inside(skeleton(kept)).any()
    assert not inside(skeleton(kept + SPACE.approach_offset_rad)).any()


def test_without_volumes_nothing_changes():
    drawn = [draw_candidates(s, FEW, rng()) for s in (SPACE, replace(SPACE, keep_outs=KeepOuts()))]

    assert np.array_equal(drawn[0].joints_rad, drawn[1].joints_rad)


def test_a_volume_between_tracker_and_reflector_hides_it_and_one_beside_the_beam_does_not():
    chain = nominal_chain(SPACE, draw_candidates(SPACE, FEW, rng()).joints_rad)
    screen = Box("screen", (1200.0, -2000.0, -500.0), (1250.0, 2000.0, 2000.0))
    beside = Box("beside", (1200.0, 1500.0, -500.0), (1250.0, 2000.0, 2000.0))

    def seen(volume):
        space = replace(SPACE, keep_outs=KeepOuts((volume,)))
        return is_seen(space, cosines_in_sight(space, chain)).any(axis=0)

    assert not seen(screen).any()
    assert seen(beside).all()


def test_a_flat_artefact_is_planned_for_within_its_own_cone():
    flat = replace(SPACE, seen_within_rad=np.radians(15.0))

    drawn = draw_candidates(flat, 100, rng())

    cosines = cosines_to_tracker(SPACE, nominal_chain(SPACE, drawn.joints_rad))
    facing = cosines[drawn.nest - 1, np.arange(100)]
    assert np.all(np.degrees(np.arccos(facing)) <= 15.0)


def test_a_forearm_between_tracker_and_reflector_hides_it():
    everywhere = replace(SPACE, nests=tuple(replace(nest, facing=None) for nest in NESTS))
    level = nominal_chain(everywhere, np.zeros((1, 6)))  # forearm forwards, 630 mm high
    at_its_end = replace(everywhere, tracker_position_mm=(3000.0, 0.0, 600.0))
    behind_and_above = replace(everywhere, tracker_position_mm=(-2000.0, 0.0, 640.0))

    assert is_seen(SPACE, cosines_in_sight(at_its_end, level)).all()
    assert is_seen(SPACE, cosines_to_tracker(behind_and_above, level)).any()  # above the column
    assert not is_seen(SPACE, cosines_in_sight(behind_and_above, level)).all()


def test_no_way_of_a_plan_leads_through_a_volume_and_each_stop_is_approached_from_below():
    plan = promised_session(replace(SPACE, keep_outs=ALL), 15, n_candidates=2 * FEW)
    stops = session_plan(plan).stops

    ways = ways_between(stops, SPACE.approach_offset_rad)

    share = np.linspace(0.0, 1.0, 120)[:, None, None]
    along = ways.start_rad + share * (ways.end_rad - ways.start_rad)
    assert not inside(skeleton(along.reshape(-1, 6))).any()
    to_stops = [row for row, name in enumerate(ways.names) if english(name).startswith("from the approach")]
    assert len(to_stops) == 15
    assert (ways.end_rad - ways.start_rad)[to_stops] == pytest.approx(np.full((15, 6), 0.0873))


def test_the_order_of_a_plan_is_shorter_than_chance():
    joints = promised_session(SPACE, 30, n_candidates=FEW).joints_rad

    def length(order):
        return np.abs(np.diff(joints[order], axis=0)).max(axis=1).sum()

    by_chance = np.mean([length(np.random.default_rng(k).permutation(30)) for k in range(20)])
    assert length(np.arange(30)) < 0.8 * by_chance


def test_a_stop_inside_a_volume_is_named_with_body_and_volume():
    cell = replace(STATED, limits=replace(STATED.limits, keep_outs=ALL))
    reaching = planned([-10, 30, 0, 0, 0, 0], [40, 30, 0, 0, 0, 0])

    refused = first_obstruction(bodies_of(cell), reaching, None)

    assert first_obstruction(bodies_of(STATED), reaching, None) is None
    assert english(refused).startswith("Configuration 2 is not possible")
    assert english(refused).endswith("inside the keep-out volume conveyor.")


def test_a_way_through_a_volume_is_refused_though_nobody_states_the_floor():
    unstated = replace(CELL, limits=replace(CELL.limits, keep_outs=KeepOuts((CONVEYOR,))))
    ways = ways_between(planned([-10, 30, 0, 0, 0, 0], [90, 30, 0, 0, 0, 0]), None)

    assert "inside the keep-out volume conveyor" in english(path_obstruction(bodies_of(unstated), ways))
    assert path_obstruction(bodies_of(STATED), ways) is None


def test_an_added_stop_in_a_volume_is_left_out_with_the_volumes_names():
    cell = replace(STATED, tracker_position_mm=SPACE.tracker_position_mm)
    cell = replace(cell, limits=replace(cell.limits, keep_outs=KeepOuts((CONVEYOR,))))
    plan = replace(session_plan(promised_session(SPACE, 3, n_candidates=FEW)), approach_offset_rad=OFFSET)
    wanted = [WantedStop(tuple(np.radians([40.0, 30.0, 0.0, 0.0, 0.0, 0.0])), None)]

    with pytest.raises(WorkSpaceError, match=r"keep-out volume \(conveyor\)"):
        addition(cell, plan, wanted)


def test_volumes_that_leave_nothing_are_named():
    cage = KeepOuts((Box("cage", (-900.0, -900.0, 0.0), (900.0, 900.0, 1200.0)),))

    with pytest.raises(TooFewCandidatesError, match="keep-out volumes as well: cage"):
        draw_candidates(replace(SPACE, keep_outs=cage), 5, rng())


def test_what_stays_open_because_of_a_volume_is_named_with_it():
    slot = [Box(f"{side} plate", (100.0, y - 9.7, 350.0), (200.0, y + 9.7, 700.0)) for side, y in SLOT]
    shelf = Box("far shelf", (0.0, 1500.0, 0.0), (200.0, 1600.0, 700.0))
    degrees = ((-2.0, 2.0), (40.0, 70.0), (-40.0, 20.0))
    ranges = (*(JointRange(*np.radians(ends)) for ends in degrees), *SPACE.ranges[3:])
    narrow = replace(SPACE, ranges=ranges, approach_offset_rad=None)

    between = promised_session(replace(narrow, keep_outs=KeepOuts((*slot, shelf))), 30, n_candidates=60)

    assert promised_session(narrow, 30, n_candidates=60).left_open == ()
    assert ("base_x", "a_2") in [group.parameters for group in between.left_open]
    for group in between.left_open:
        assert english(group.reason) == (
            "joint 1 never moved: the parameters of the links before and after this joint cannot be "
            "separated; removing any one of the keep-out volumes left plate, right plate would resolve this"
        )


def test_a_volume_that_leaves_something_open_alone_is_named_alone():
    group = NotIdentifiable(("theta_4",), "a reason")

    def open_without(keep_outs):
        return frozenset({"theta_4"} if "wall" in keep_outs.names else {})

    (blamed,) = because_of(ALL, (group,), open_without)

    assert english(blamed.reason) == "a reason; removing the keep-out volume wall would resolve this"


def test_what_would_stay_open_without_any_volume_is_not_put_down_to_them():
    group = NotIdentifiable(("theta_4",), "a reason")

    assert because_of(ALL, (group,), lambda _: frozenset({"theta_4"})) == (group,)


def test_sessions_find_their_ways_round_a_post_in_the_midst_of_the_work_space():
    space = replace(SPACE, keep_outs=ALL)

    stops = plan_validation(space, 15, seed=2).stops

    ways = ways_between(stops, space.approach_offset_rad)
    share = np.linspace(0.0, 1.0, 120)[:, None, None]
    along = ways.start_rad + share * (ways.end_rad - ways.start_rad)
    assert not inside(skeleton(along.reshape(-1, 6))).any()
