"""Plans of a sphere test: a bar's length from the ball, spread out, approached from one side, or refused."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from tests.helpers.ballbar.cells import IRB_120, ballbar_cell, frame
from tests.helpers.identification.models import model_of, parameters_of
from truepose.domain.ballbar import SpherePlanRequest
from truepose.domain.campaign import Stops
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import NestCentre
from truepose.domain.robot import JointRange
from truepose.identification.model.prediction import predict
from truepose.planning.ballbar import sphere
from truepose.planning.ballbar.bodies import base_fixture, chain_of
from truepose.planning.ballbar.motion_clearance import Surroundings, between, is_clear_along
from truepose.planning.ballbar.paths import tour
from truepose.planning.ballbar.sphere import plan_sphere
from truepose.planning.errors import TooFewCandidatesError, WorkSpaceError

_CELL = ballbar_cell(IRB_120)
_BALL = base_fixture(1, frame(350, -150, 150, 0, -30, 60))


@pytest.fixture(scope="module")
def plan():
    return plan_sphere(_CELL, _BALL, SpherePlanRequest(stops=12))


def stops_of(plan, nest):
    (place,) = plan.placements
    return np.array([pose.joints_rad for pose in place.poses if pose.legs == ((1, nest),)])


@pytest.mark.parametrize("nest", [1, 2])
def test_every_stop_has_its_nest_a_bars_length_from_the_ball(plan, nest):
    places = chain_of(_CELL, stops_of(plan, nest)).points(_CELL.nests_mm[nest - 1])
    towards = (places - _BALL.cups_mm[0]) / 300.0

    assert len(places) == 12
    assert np.linalg.norm(towards, axis=1) == pytest.approx(1.0, abs=1e-9)
    # Spread over a half sphere they see the ball from every side: 0.58 were they on a whole one.
    assert np.sqrt(np.linalg.eigvalsh(towards.T @ towards / len(towards))[0]) > 0.3


def test_one_nest_is_done_before_the_next(plan):
    assert [pose.legs[0][1] for pose in plan.placements[0].poses] == [1] * 12 + [2] * 12
    assert (plan.test, [setup.base_point for setup in plan.placements[0].setups]) == ("sphere", [1])


def test_every_stop_is_approached_from_lower_angles_and_left_the_same_way(plan):
    poses = plan.placements[0].poses

    for pose in poses:
        assert np.subtract(pose.joints_rad, pose.via_rad[-1]) == pytest.approx(np.radians(5.0))
    for before, pose in pairwise(poses):
        assert pose.via_rad[0] == before.via_rad[-1]


def test_every_way_is_clear(plan):
    (place,) = plan.placements
    here = place.away.joints_rad

    for pose in place.poses:
        for there in (*pose.via_rad, pose.joints_rad):
            assert is_clear_along(Surroundings(_CELL, _BALL), between(np.array(here), np.array(there)))
            here = there


def test_the_same_seed_gives_the_same_plan(plan):
    assert plan_sphere(_CELL, _BALL, SpherePlanRequest(stops=12)) == plan
    assert plan_sphere(_CELL, _BALL, SpherePlanRequest(stops=12), seed=1) != plan


def test_a_model_that_commands_has_the_nests_on_its_own_sphere():
    nests = tuple(NestCentre(k, tuple(centre)) for k, centre in enumerate(_CELL.nests_mm.tolist(), start=1))
    longer = parameters_of("geometry", [("a_3", 0.8, "mm"), ("theta_5", 3e-3, "rad")])
    model = model_of(_CELL.robot, *longer, nests=nests)

    plan = plan_sphere(_CELL, _BALL, SpherePlanRequest((2,), 10, model, model_id=7))

    def place(joints, nest):
        ups = np.ones(joints.shape, dtype=int)
        return predict(
            model, Stops(np.arange(len(joints)), joints, direction=ups), np.full(len(joints), nest)
        )[0]

    ball = place(np.array([plan.placements[0].setups[0].joints_rad]), 1)
    length = np.linalg.norm(place(stops_of(plan, 2), 2) - ball, axis=1)
    assert length == pytest.approx(300.0, abs=1e-6)
    assert plan.model_id == 7


def test_a_model_of_another_robot_commands_nothing():
    """It would send the arm to where nobody looked whether there is room."""
    nests = tuple(NestCentre(k, tuple(centre)) for k, centre in enumerate(_CELL.nests_mm.tolist(), start=1))
    first, *others = _CELL.robot.joints
    taller = replace(_CELL.robot, joints=(replace(first, d_mm=first.d_mm + 40.0), *others))

    with pytest.raises(ConfigurationError, match="the model is of a different robot"):
        plan_sphere(_CELL, _BALL, SpherePlanRequest((2,), 10, model_of(taller, nests=nests), model_id=7))


@pytest.mark.parametrize("nests", [(), (1, 1), (4,)])
def test_nests_that_are_none_are_refused(nests):
    with pytest.raises(ConfigurationError, match="tool nests of a sphere test from 1 to 3, each only once"):
        plan_sphere(_CELL, _BALL, SpherePlanRequest(nests))


def test_a_nest_to_whose_stops_no_way_leads_is_said_however_many_the_others_have(monkeypatch):
    def without_the_second_nest(around, before, groups, here, rng):
        own, lost = groups
        found = tour(around, before, [own], here, rng)
        return replace(found, missed=(*found.missed, *lost))

    monkeypatch.setattr(sphere, "tour", without_the_second_nest)

    with pytest.raises(
        TooFewCandidatesError, match="No collision-free path to enough configurations of nest 2"
    ):
        plan_sphere(_CELL, _BALL, SpherePlanRequest(stops=12))


def test_a_ball_out_of_reach_is_said():
    with pytest.raises(WorkSpaceError, match="cannot hold the setting ball at base point 1"):
        plan_sphere(_CELL, base_fixture(1, frame(1500, 0, 150)), SpherePlanRequest())


def test_a_sphere_that_cannot_be_reached_is_said():
    """The joints may move a little about the place where the ball is held."""
    held = plan_sphere(_CELL, _BALL, SpherePlanRequest((1,), 6)).placements[0].setups[0].joints_rad
    narrow = tuple(JointRange(q - 0.3, q + 0.3) for q in held)

    with pytest.raises(TooFewCandidatesError, match="in only 0 configurations; 6 are needed"):
        plan_sphere(replace(_CELL, ranges=narrow), _BALL, SpherePlanRequest((1,), 6))
