"""Plans of closed loops: stops where the tool meets its targets, and what they promise."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from truepose.domain.campaign import TargetDistances
from truepose.domain.contacts import Target, TargetKind
from truepose.domain.errors import ConfigurationError
from truepose.exchange.cells.file import cell_given
from truepose.planning.contacts.loop_configurations import LoopPlanRequest, draw_stands
from truepose.planning.contacts.loop_prediction import promised_loop
from truepose.planning.errors import TooFewCandidatesError, WorkSpaceError
from truepose.planning.prediction.robots_and_cells import of_cell
from truepose.planning.workspace.space import nominal_chain

SPACE = of_cell(cell_given("lrmate-tilted")).space
SPHERES = (
    Target(1, TargetKind.SPHERE, 15.7, 0.001, 0.0005, (330.0, -250.0, 140.0)),
    Target(2, TargetKind.SPHERE, 15.7, 0.001, 0.0005, (450.0, 230.0, 260.0)),
)
BAR = TargetDistances(np.array([1]), np.array([2]), np.array([509.0]), np.array([0.001]))
GAUGES = tuple(
    Target(k + 1, TargetKind.GAUGE, place_mm=(420.0, -60.0, 240.0), normal=tuple(axis))
    for k, axis in enumerate(np.eye(3).tolist())
)
WIRES = tuple(
    Target(k, TargetKind.WIRE, place_mm=place)
    for k, place in enumerate(((900.0, -700.0, 30.0), (900.0, 700.0, 30.0)), start=1)
)
BALL = (Target(1, TargetKind.BALL, place_mm=(430.0, 0.0, 260.0)),)


def plane(normal, kind=TargetKind.PLANE):
    return (Target(1, kind, form_mm=0.002, place_mm=(450.0, 0.0, 250.0), normal=normal),)


TILTED = plane((-0.5, 0.3, 0.8))
WISHES = {
    "spheres": LoopPlanRequest(SPHERES, (2,), 0.001, BAR),
    "gauges": LoopPlanRequest(GAUGES, (1, 2), 0.001),
    "wires": LoopPlanRequest(WIRES, (2,), 0.02),
    "ball": LoopPlanRequest(BALL, (2,), 0.01),
    "plane": LoopPlanRequest(TILTED, (1, 2, 3), 0.001),
    "face": LoopPlanRequest(plane((-0.5, 0.3, 0.8), TargetKind.FACE), (2,), 0.005),
}


@cache
def stands_of(name):
    return draw_stands(SPACE, WISHES[name], 24, np.random.default_rng(1))


@cache
def plan_of(name, n=40):
    return promised_loop(SPACE, WISHES[name], n)


def places(stands):
    centres = np.array([nest.centre_mm for nest in SPACE.nests])
    chain = nominal_chain(SPACE, stands.joints_rad)
    return chain.end_origin + np.einsum("nij,nj->ni", chain.end_rotation, centres[stands.nest - 1]), chain


def test_a_probe_stands_on_its_sphere_and_comes_from_outside():
    stands = stands_of("spheres")
    where, chain = places(stands)

    centres = np.array([target.place_mm for target in SPHERES])[stands.group]
    outward = where - centres
    assert np.linalg.norm(outward, axis=1) == pytest.approx(15.7, abs=1e-5)
    assert (outward[:, 2] >= 0.0).all()
    assert ((chain.end_rotation[:, :, 2] * outward).sum(axis=1) < 0.0).all()
    assert np.bincount(stands.group).tolist() == [12, 12]


def test_a_probe_stands_on_its_plane():
    where, _ = places(stands_of("plane"))

    normal = np.array(TILTED[0].normal) / np.linalg.norm(TILTED[0].normal)
    assert (where - TILTED[0].place_mm) @ normal == pytest.approx(np.zeros(24), abs=1e-5)
    assert np.bincount(stands_of("plane").nest).tolist() == [0, 8, 8, 8]


@pytest.mark.parametrize(("name", "target"), [("gauges", GAUGES[0]), ("ball", BALL[0])])
def test_gauges_and_sensors_stay_within_their_travel(name, target):
    where, _ = places(stands_of(name))

    assert np.abs(where - target.place_mm).max() <= 2.0 + 1e-6


def test_a_gauge_is_pushed_the_way_in_which_its_readings_grow():
    _, chain = places(stands_of("gauges"))

    mean = np.ones(3) / np.sqrt(3.0)
    assert (chain.end_rotation[:, :, 2] @ mean > np.cos(np.radians(75.0))).all()


def test_a_sensor_looks_at_its_face_from_a_distance():
    where, chain = places(stands_of("face"))

    normal = np.array(TILTED[0].normal) / np.linalg.norm(TILTED[0].normal)
    assert np.abs((where - TILTED[0].place_mm) @ normal - 40.0).max() <= 2.0 + 1e-6
    assert (chain.end_rotation[:, :, 2] @ -normal > np.cos(np.radians(25.0))).all()


def test_all_gauges_at_one_place_and_all_wires_are_read_at_one_stop():
    assert plan_of("gauges").targets[0] == (1, 2, 3)
    assert plan_of("wires").targets[0] == (1, 2)
    assert set(plan_of("spheres").targets) == {(1,), (2,)}


def test_stops_of_a_target_follow_one_another():
    numbers = [numbers[0] for numbers in plan_of("spheres").targets]

    assert numbers == sorted(numbers)


def test_more_stops_promise_more():
    curve = plan_of("wires").curve

    means = [point.mean_mm for point in curve]
    assert all(after <= before for before, after in pairwise(means))
    assert curve[-1].mean_mm < 0.03
    assert plan_of("wires").left_open == ()


def test_a_certified_distance_tells_what_an_uncertified_tool_does_not():
    unknown = tuple(replace(nest, standard_uncertainty_mm=0.1) for nest in SPACE.nests)
    space = replace(SPACE, nests=unknown)
    spheres = tuple(replace(target, zero_uncertainty_mm=0.05) for target in SPHERES)

    without, with_bar = (
        promised_loop(space, LoopPlanRequest(spheres, (2,), 0.001, bar), 60).promised.mean_mm
        for bar in (None, BAR)
    )

    assert with_bar < 0.7 * without


def test_a_level_plane_leaves_open_what_a_tilted_one_tells():
    level = promised_loop(SPACE, LoopPlanRequest(plane((0.0, 0.0, 1.0)), (1, 2, 3), 0.001), 60)

    assert {"a_2", "d_2"} <= {name for entry in level.left_open for name in entry.parameters}
    assert plan_of("plane", 60).left_open == ()
    assert level.promised.mean_mm > 10.0 * plan_of("plane", 60).promised.mean_mm


def test_a_target_out_of_reach_is_named():
    far = (replace(BALL[0], place_mm=(3000.0, 0.0, 500.0)),)

    with pytest.raises(TooFewCandidatesError, match="reaches target 1 in 0 of"):
        promised_loop(SPACE, LoopPlanRequest(far, (2,), 0.01), 20)


def test_a_target_without_a_place_is_refused():
    with pytest.raises(ConfigurationError, match="Target 2 has no position"):
        LoopPlanRequest((BALL[0], Target(2, TargetKind.BALL)), (1,), 0.01)


def test_a_loop_without_targets_is_refused():
    with pytest.raises(ConfigurationError, match="at least one target"):
        LoopPlanRequest((), (1,), 0.001)


@pytest.mark.parametrize("nests", [(), (4,)])
def test_a_loop_is_read_at_nests_that_the_tool_has(nests):
    with pytest.raises(ConfigurationError, match=r"at least one tool nest. Choose from 1 to 3"):
        promised_loop(SPACE, LoopPlanRequest(SPHERES, nests, 0.001), 6)


def test_gauges_at_one_place_that_read_against_each_other_leave_no_way_in():
    against = replace(GAUGES[0], number=2, normal=(-1.0, 0.0, 0.0))

    with pytest.raises(
        WorkSpaceError, match="normals of the targets that are read together cancel each other"
    ):
        promised_loop(SPACE, LoopPlanRequest((GAUGES[0], against), (1,), 0.001), 6)


def test_a_certified_distance_of_spheres_at_one_place_shows_no_direction():
    together = (SPHERES[0], replace(SPHERES[1], place_mm=SPHERES[0].place_mm))

    plan = promised_loop(SPACE, LoopPlanRequest(together, (2,), 0.001, BAR), 12)

    assert 0.0 < plan.promised.mean_mm < plan.promised.worst_mm


@pytest.mark.parametrize("reading_mm", [1e-9, 0.0])
def test_an_exact_arm_with_exact_wires_learns_from_every_stop(reading_mm):
    exact = replace(SPACE, robot=replace(SPACE.robot, repeatability_mm=0.0))

    plan = promised_loop(exact, LoopPlanRequest(WIRES, (2,), reading_mm), 3)

    means = [point.mean_mm for point in plan.curve]
    assert all(more < 0.9 * fewer for fewer, more in pairwise(means[:3]))


def test_a_tool_without_a_nest_touches_nothing():
    with pytest.raises(WorkSpaceError, match="no tool nest"):
        promised_loop(replace(SPACE, nests=()), LoopPlanRequest(SPHERES, (), 0.001), 6)
