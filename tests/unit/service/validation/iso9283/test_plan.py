"""The five poses of the standard, and the cycles in which a robot visits them."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRange
from truepose.kinematics.chain import nominal_chain
from truepose.kinematics.inverse import BRANCH_NAMES
from truepose.validation.iso9283.plan import Cube, plan_poses

_CUBE = Cube((370.0, 0.0, 400.0), 200.0)
_DOWN = np.diag([1.0, -1.0, -1.0])  # the flange looks at the floor
_NEST = (10.0, 20.0, 100.0)


def places(cube):
    return np.array([pose.position_mm for pose in cube.poses])


@pytest.mark.parametrize("plane", ["x+", "x-", "y+", "y-"])
def test_the_poses_lie_on_the_diagonals_of_the_plane(plane):
    found = places(replace(_CUBE, plane=plane))
    diagonal = 200.0 * np.sqrt(3.0)

    assert found[0] == pytest.approx(_CUBE.centre_mm)
    assert found[1:].mean(axis=0) == pytest.approx(_CUBE.centre_mm)
    # the middle of the cube halves its diagonal, and a tenth of it is left to the corner
    assert np.linalg.norm(found[1:] - found[0], axis=1) == pytest.approx(0.4 * diagonal)
    assert np.linalg.matrix_rank(found[1:] - found[0], tol=1e-9) == 2
    for one, other in ((1, 3), (2, 4)):
        assert np.linalg.norm(found[one] - found[other]) == pytest.approx(0.8 * diagonal)


@pytest.mark.parametrize(
    ("plane", "level", "rising"), [("y+", 1, 0), ("y-", 1, 0), ("x+", 0, 1), ("x-", 0, 1)]
)
def test_the_plane_is_as_it_is_named(plane, level, rising):
    away = places(replace(_CUBE, plane=plane))[1:] - _CUBE.centre_mm

    assert away[0][level] == pytest.approx(-away[1][level])
    assert away[0][[rising, 2]] == pytest.approx(away[1][[rising, 2]])
    slope = 1.0 if plane[1] == "+" else -1.0
    assert away[:, 2] == pytest.approx(slope * away[:, rising])


def test_the_robot_stands_in_the_poses_without_changing_its_branch():
    plan = plan_poses(IRB_120, _CUBE, _DOWN, _NEST)
    chain = nominal_chain(IRB_120, plan.joints_rad)

    assert chain.points(np.tile(_NEST, (5, 1))) == pytest.approx(places(_CUBE), abs=1e-9)
    assert chain.end_rotation == pytest.approx(np.tile(_DOWN, (5, 1, 1)), abs=1e-12)
    assert BRANCH_NAMES[plan.branch] == "front/up/no flip"


def test_joint_limits_choose_the_branch():
    one_sided = tuple(JointRange(-np.pi, 0.0 if joint == 4 else np.pi) for joint in range(6))

    plan = plan_poses(replace(IRB_120, joint_limits=one_sided), _CUBE, _DOWN, _NEST)

    assert BRANCH_NAMES[plan.branch].endswith("/flip")
    assert (plan.joints_rad[:, 4] <= 0.0).all()


def test_thirty_cycles_run_from_p5_to_p1():
    plan = plan_poses(IRB_120, _CUBE, _DOWN, _NEST)

    session = plan.session(nest=2)

    stops = session.stops
    assert len(stops) == 150
    assert [stop.config for stop in stops] == list(range(1, 151))
    assert {stop.nest for stop in stops} == {2}
    assert [stop.repeat_of for stop in stops[:6]] == [None, None, None, None, None, 1]
    for number, stop in zip([5, 4, 3, 2, 1] * 30, stops, strict=True):
        assert stop.joints_rad == pytest.approx(plan.joints_rad[number - 1])
    first = {stop.config: stop for stop in stops[:5]}
    assert all(stop.joints_rad == first[stop.repeat_of].joints_rad for stop in stops[5:])
    assert all(one.joints_rad != other.joints_rad for one, other in pairwise(stops))
    assert session.approach_offset_rad is None


def test_the_first_cycle_comes_to_p5_from_p1_as_all_others_do():
    session = plan_poses(IRB_120, _CUBE, _DOWN, _NEST).session(nest=2, cycles=2)

    places = [place for stop in session.stops for place in stop.places(session.approach_offset_rad)]

    p1 = session.stops[4].joints_rad
    assert places[0] == ("approach", p1)
    assert [what for what, _ in places[1:]] == ["stop"] * 10  # nothing else comes between two poses


@pytest.mark.parametrize(
    ("cube", "sentence"),
    [
        (Cube((370.0, 0.0, 400.0), 900.0), r"P2, P3 are out of the robot's reach"),
        (Cube((2000.0, 0.0, 400.0), 200.0), r"P1, P2, P3, P4, P5 are out of the robot's reach"),
    ],
)
def test_a_cube_that_is_too_large_is_refused(cube, sentence):
    with pytest.raises(ConfigurationError, match=sentence):
        plan_poses(IRB_120, cube, _DOWN, _NEST)


@pytest.mark.parametrize("edge_mm", [0.0, -200.0, float("nan"), float("inf")])
def test_a_cube_without_edges_is_refused(edge_mm):
    with pytest.raises(ConfigurationError, match="cube edge must be greater than 0 mm"):
        Cube((370.0, 0.0, 400.0), edge_mm)


@pytest.mark.parametrize("off", [float("nan"), float("inf")])
def test_a_cube_that_is_nowhere_is_refused(off):
    with pytest.raises(ConfigurationError, match="cube centre must be given as three numbers"):
        Cube((370.0, off, 400.0), 200.0)
