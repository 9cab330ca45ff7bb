"""Poses of a certified artefact: what its definition is off by stays out of the arm."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.identification.synthetic import NESTS, configurations, nominal_campaign
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.robot import Nest
from truepose.identification import identify, predict
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import quaternion_from_rotation, rotation_from_vector
from truepose.kinematics.poses import centre, pose_uncertainty

ARTEFACT = np.array(NESTS)
# Readings are far finer than the definition, so that it is they that tell.
READ, DEFINED = pose_uncertainty(ARTEFACT, 0.004), pose_uncertainty(ARTEFACT, 0.04)
SHOWN = (*nominal_campaign(1).nests, Nest(tuple(centre(ARTEFACT).tolist()), DEFINED.position_mm))
# Away from axis 6, and across it: what lies about it or along it no pose tells from the arm.
OFF_MM, OFF_RAD = np.array([0.037, 0.0154, 0.0]), np.array([4e-4, -5e-4, 0.0])
EXACT = 0.01  # mm: springs of none where the priors believe in typical ones; a quarter of a nest's noise


def poses(off_mm=OFF_MM, off_rad=OFF_RAD, n=36):
    """What a camera reads of an arm without errors whose artefact is not where it is defined."""
    joints = configurations(n, 3)
    arm = nominal_campaign(1)
    chain = forward(nominal_values(arm.robot, joints), np.eye(3), np.zeros(3))
    readings = PointReadings(
        Stops(np.arange(1, n + 1), joints),
        np.full(n, 4),
        chain.points(centre(ARTEFACT) + off_mm),
        np.full(n, READ.position_mm),
        quaternion=quaternion_from_rotation(chain.end_rotation @ rotation_from_vector(off_rad)),
        rotation_uncertainty_rad=np.full(n, READ.rotation_rad),
    )
    return replace(arm, nests=SHOWN, calibration=readings, tool_rotation_uncertainty_rad=DEFINED.rotation_rad)


def off_at_the_nests_mm(model):
    """The largest error of predicted nests, at other configurations."""
    joints = np.repeat(configurations(50, 9), 3, axis=0)
    nest = np.tile([1, 2, 3], 50)
    arm = nominal_campaign(1)
    true = forward(nominal_values(arm.robot, joints), np.eye(3), np.zeros(3)).points(ARTEFACT[nest - 1])
    predicted, _ = predict(model, Stops(np.arange(150), joints), nest)
    return float(np.linalg.norm(predicted - true, axis=1).max())


def held(campaign):
    """The same, the definition taken for exact."""
    exact = tuple(replace(nest, standard_uncertainty_mm=0.0) for nest in campaign.nests)
    return replace(campaign, nests=exact, tool_rotation_uncertainty_rad=1e-9)


def test_the_nests_are_predicted_where_they_are_although_the_camera_sees_them_beside():
    answer = identify(poses())

    found = {parameter.name: parameter.value for parameter in answer.parameters}
    for name, off in (("certified_4_x", OFF_MM[0]), ("tool_ry", OFF_RAD[1])):
        assert found[name] == pytest.approx(off, rel=0.1)
    assert off_at_the_nests_mm(answer.model) < 0.01 < off_at_the_nests_mm(identify(held(poses())).model)


def test_what_lies_along_and_about_the_last_axis_no_pose_tells_from_the_arm():
    """A tenth is told by the widths of the priors; the rest is the arm's, and its uncertainty says so."""
    off_mm = 0.03

    answer = identify(poses(np.array([0.0, 0.0, off_mm]), np.zeros(3)))

    stated = next(parameter for parameter in answer.parameters if parameter.name == "d_6")
    assert off_at_the_nests_mm(answer.model) == pytest.approx(off_mm, rel=0.1)
    assert stated.standard_uncertainty > 0.9 * DEFINED.position_mm


def test_an_artefact_that_is_as_defined_moves_nothing():
    answer = identify(poses(np.zeros(3), np.zeros(3)))

    assert off_at_the_nests_mm(answer.model) < EXACT
    assert max(abs(p.value) for p in answer.parameters if p.effect == "tool_certificate") < EXACT


def test_positions_alone_leave_the_turn_of_the_artefact_out_of_it():
    campaign = poses(np.zeros(3), np.zeros(3))
    alone = replace(campaign.calibration, quaternion=None, rotation_uncertainty_rad=None)

    answer = identify(replace(campaign, calibration=alone))

    assert not [p for p in answer.parameters if p.name.startswith("tool_r")]
    assert off_at_the_nests_mm(answer.model) < EXACT


def test_orientations_of_an_artefact_that_nobody_certified_turn_with_the_data():
    """As before there were certificates: any turn between artefact and flange is found, none believed."""
    turned = replace(poses(np.zeros(3), np.array([0.3, -0.2, 0.5])), tool_rotation_uncertainty_rad=None)

    answer = identify(turned)

    assert off_at_the_nests_mm(answer.model) < 0.01
    assert not [p for p in answer.parameters if p.effect == "tool_certificate"]


def test_what_orientations_tell_makes_predictions_surer():
    campaign = poses()
    alone = replace(campaign.calibration, quaternion=None, rotation_uncertainty_rad=None)
    stops, nest = Stops(np.arange(20), configurations(20, 5)), np.full(20, 2)

    both, less = (identify(each).model for each in (campaign, replace(campaign, calibration=alone)))

    assert predict(both, stops, nest)[1].mean() < 0.95 * predict(less, stops, nest)[1].mean()


def test_orientations_that_tell_nothing_change_nothing():
    campaign = poses()
    blind = replace(campaign.calibration, rotation_uncertainty_rad=np.full(36, 3.0))
    alone = replace(campaign.calibration, quaternion=None, rotation_uncertainty_rad=None)

    with_them, without = (
        {p.name: p.value for p in identify(replace(campaign, calibration=each)).parameters}
        for each in (blind, alone)
    )

    assert [with_them[name] for name in without] == pytest.approx(list(without.values()), rel=1e-3, abs=1e-7)
