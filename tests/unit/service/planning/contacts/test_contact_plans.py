"""Plans of closed loops: within the limits, by short last steps, past everything that stands there."""

import functools
from dataclasses import replace

import numpy as np
import pytest

from truepose.domain.contacts import Target, TargetDistance, TargetKind
from truepose.domain.robot import FramePlacement, JointRange
from truepose.exchange.cells.file import cell_given
from truepose.kinematics.chain import Chain
from truepose.planning.contacts.plan import plan_of
from truepose.planning.contacts.plan_request import ContactPlanRequest
from truepose.planning.contacts.poses import draw_goals
from truepose.planning.errors import TooFewCandidatesError, WorkSpaceError
from truepose.planning.workspace.bodies import bodies_of
from truepose.planning.workspace.candidates import cosines_in_sight, is_seen
from truepose.planning.workspace.path_clearance import Ways, path_obstruction
from truepose.planning.workspace.space import nominal_chain, space_to_measure, within

CELL = cell_given("lrmate-tilted")
SPACE = space_to_measure(CELL, None)
SPHERES = tuple(
    Target(number, TargetKind.SPHERE, 16.0, place_mm=(420.0, y_mm, 80.0))
    for number, y_mm in ((1, -120.0), (2, 120.0))
)
PLANE = Target(1, TargetKind.PLANE, place_mm=(430.0, 0.0, 60.0))
DRUM = Target(1, TargetKind.WIRE, 700.0, place_mm=(700.0, -500.0, 0.0))
BALL = Target(1, TargetKind.BALL, place_mm=(430.0, 0.0, 120.0))
PROBE = ContactPlanRequest("probe", SPHERES, 12, nest=2)


@functools.cache
def plan():
    return plan_of(CELL, PROBE)


def chain_of(joints) -> Chain:
    return nominal_chain(SPACE, np.array(joints))


def tips_mm(joints):
    return chain_of(joints).points(np.array(CELL.nests[1].centre_mm))


def test_a_probe_ends_where_its_tip_touches_at_its_zero():
    for stop in plan().stops:
        centre_mm = SPHERES[stop.targets[0] - 1].place_mm
        (tip_mm,) = tips_mm([stop.joints_rad])
        assert np.linalg.norm(tip_mm - centre_mm) == pytest.approx(16.0, abs=1e-6)


def test_a_robot_that_stands_elsewhere_touches_where_the_targets_stand():
    cell = replace(CELL, base_nominal=FramePlacement(40.0, -30.0, 20.0, rz_rad=0.1))

    found = plan_of(cell, replace(PROBE, stops=4))

    chain = nominal_chain(space_to_measure(cell, None), np.array([stop.joints_rad for stop in found.stops]))
    centres = np.array([SPHERES[stop.targets[0] - 1].place_mm for stop in found.stops])
    tips = chain.points(np.array(CELL.nests[1].centre_mm))
    assert np.linalg.norm(tips - centres, axis=1) == pytest.approx(16.0, abs=1e-6)


def test_both_spheres_are_touched_from_many_sides():
    for number in (1, 2):
        own = [stop for stop in plan().stops if stop.targets == (number,)]
        sides = tips_mm([stop.joints_rad for stop in own]) - SPHERES[number - 1].place_mm
        assert len(own) >= 3
        assert np.ptp(sides[:, :2], axis=0).min() > 10.0


def test_every_place_of_every_way_is_within_the_limits():
    for one in (plan(), plan_of(CELL, ContactPlanRequest("sensor", (BALL,), 6, nest=2))):
        places = np.array([place for stop in one.stops for place in stop.way_rad])

        near = [JointRange(one.lower_rad + 0.09, one.upper_rad - 0.09) for one in SPACE.motion_limits]
        assert within(near, places).all()  # targets stand off their place


def test_the_last_steps_go_straight_in_along_the_push_and_none_is_longer_than_half_a_stroke():
    for stop in plan().stops:
        steps = np.diff(tips_mm(stop.way_rad[2:]), axis=0)
        lengths = np.linalg.norm(steps, axis=1)

        assert lengths == pytest.approx([1.25] * 4, abs=1e-6)
        assert steps / lengths[:, None] == pytest.approx(np.tile(stop.push, (4, 1)), abs=1e-6)


def test_all_ways_begin_at_one_place_and_nothing_of_the_tool_comes_near_a_target_on_the_way_off_it():
    share = np.linspace(0.0, 1.0, 101)[:, None]  # finer than the plan looked

    assert len({stop.way_rad[0] for stop in plan().stops}) == 1
    for stop in plan().stops:
        start, end = np.array(stop.way_rad[:2])
        chain = chain_of(start + share * (end - start))
        nests = np.stack([chain.points(np.array(nest.centre_mm)) for nest in CELL.nests])
        for sphere in SPHERES:
            assert np.linalg.norm(nests - sphere.place_mm, axis=-1).min() > 30.0


def test_a_plane_is_touched_about_its_place_and_from_above():
    plan = plan_of(CELL, replace(PROBE, targets=(PLANE,), plane_mm=50.0, stops=6))
    tips = tips_mm([stop.joints_rad for stop in plan.stops])

    assert tips[:, 2] == pytest.approx(60.0, abs=1e-6)
    assert np.abs(tips[:, :2] - PLANE.place_mm[:2]).max() <= 50.0 * np.sqrt(2.0)
    assert all(stop.push[2] < -0.95 for stop in plan.stops)


def test_wires_hang_within_their_stroke_and_have_no_way():
    plan = plan_of(CELL, ContactPlanRequest("wires", (DRUM,), 6, nest=2, stroke_mm=300.0, margin_mm=20.0))
    drawn_mm = np.linalg.norm(tips_mm([stop.joints_rad for stop in plan.stops]) - DRUM.place_mm, axis=1)

    assert np.abs(drawn_mm - 700.0).max() <= 280.0
    assert all(len(stop.way_rad) == 1 for stop in plan.stops)


def test_wires_hang_where_no_tracker_sees_the_tool_as_well():
    plan = plan_of(CELL, ContactPlanRequest("wires", (DRUM,), 30, nest=2, stroke_mm=300.0, margin_mm=20.0))

    chain = chain_of([stop.joints_rad for stop in plan.stops])
    seen = is_seen(SPACE, cosines_in_sight(SPACE, chain)).any(axis=0)
    assert seen.sum() < 15


def test_on_the_way_from_wire_stop_to_wire_stop_nothing_touches():
    cell = replace(CELL, limits=replace(CELL.limits, floor_z_mm=0.0))
    wires = ContactPlanRequest("wires", (DRUM,), 20, nest=2, stroke_mm=300.0, margin_mm=20.0, seed=2)

    plan = plan_of(cell, wires)

    stops = np.array([stop.joints_rad for stop in plan.stops])
    ways = Ways(tuple(map(str, range(19))), stops[:-1], stops[1:])
    assert path_obstruction(bodies_of(cell), ways) is None


def test_the_same_seed_plans_the_same_stops_and_another_one_others():
    assert plan_of(CELL, PROBE) == plan()
    assert plan_of(CELL, replace(PROBE, seed=1)).stops != plan().stops


@pytest.mark.parametrize(
    ("changes", "error", "sentence"),
    [
        ({"targets": (replace(PLANE, place_mm=None),)}, WorkSpaceError, "Target 1 has no position"),
        ({"targets": (replace(SPHERES[0], zero_mm=None),)}, WorkSpaceError, "no zero_mm"),
        ({"nest": 4}, WorkSpaceError, "no tool nest 4"),
        ({"targets": (SPHERES[0], replace(DRUM, number=2))}, WorkSpaceError, "Target 2 is a wire"),
        ({"loop": "sensor", "targets": (BALL, replace(BALL, number=2))}, WorkSpaceError, "one ball"),
        ({"axis": (0.0, 0.0, 0.0)}, WorkSpaceError, "tool axis must not be a zero vector"),
        ({"targets": (replace(PLANE, normal=(0.0, 0.0, 0.0)),)}, WorkSpaceError, "normal of target 1"),
        ({"margin_mm": 2.5}, WorkSpaceError, "half the stroke"),
        ({"clearance_mm": 5.0}, WorkSpaceError, "clearance must be greater than the stroke"),
        ({"targets": ()}, WorkSpaceError, "no target"),
        ({"distances": (TargetDistance((1, 3), 240.0, 0.002),)}, WorkSpaceError, "two different targets"),
        (
            {"targets": (replace(PLANE, place_mm=(2000.0, 0.0, 60.0)),)},
            TooFewCandidatesError,
            "Move the targets",
        ),
    ],
)
def test_what_cannot_be_planned_is_told(changes, error, sentence):
    with pytest.raises(error, match=sentence):
        plan_of(CELL, replace(PROBE, **changes))


def test_gauges_that_read_against_each_other_leave_no_way_in():
    against = tuple(
        Target(number, TargetKind.GAUGE, place_mm=(420.0, 0.0, 240.0), normal=normal)
        for number, normal in ((1, (1.0, 0.0, 0.0)), (2, (-1.0, 0.0, 0.0)))
    )

    with pytest.raises(
        WorkSpaceError, match="normals of the targets that are read together cancel each other"
    ):
        plan_of(CELL, ContactPlanRequest("gauges", against, 6, nest=2))


def test_nothing_touches_a_sphere_at_its_centre():
    with pytest.raises(WorkSpaceError, match="zero_mm of target 1 must be greater than 0"):
        plan_of(CELL, replace(PROBE, targets=(replace(SPHERES[0], zero_mm=0.0),)))


def test_goals_are_drawn_among_any_number_of_targets():
    many = tuple(replace(SPHERES[0], number=number) for number in range(1, 81))

    goals = draw_goals(replace(PROBE, targets=many), 400, np.random.default_rng(1))

    assert np.unique(goals.group).max() > 64
    assert goals.tip_mm.shape == (400, 3)


def test_where_all_draws_bring_fewer_than_are_wished_for_what_was_found_is_chosen_from():
    from_below = tuple(replace(sphere, normal=(0.0, 0.0, -1.0)) for sphere in SPHERES)

    assert len(plan_of(CELL, ContactPlanRequest("probe", from_below, 4, nest=2)).stops) == 4
