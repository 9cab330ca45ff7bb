"""A cause that only orientations show: the artefact's centre lies on the axis of the joint that errs."""

from dataclasses import replace

import numpy as np

from tests.helpers.identification.synthetic import configurations, nominal_campaign
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.diagnosis import Verdict
from truepose.domain.robot import Nest
from truepose.kinematics.chain import forward, nominal_values
from truepose.kinematics.frames import quaternion_from_rotation, rotation_from_vector
from truepose.kinematics.poses import centre, pose_uncertainty
from truepose.messages.catalogue import english

SPATIAL = np.array([[45.0, 0.0, 150.0], [-22.5, 38.971, 150.0], [-22.5, -38.971, 150.0]])
READ, DEFINED = pose_uncertainty(SPATIAL, 0.02), pose_uncertainty(SPATIAL, 0.04)
WAVE_RAD = 3e-3  # five standard uncertainties of an orientation, half of peak to peak


def poses(wave_rad, n=60):
    """What a camera reads of an arm whose joint 6 is off by a wave of two periods a turn."""
    rng = np.random.default_rng(4)
    joints = configurations(n, 3)
    turned = joints.copy()
    turned[:, 5] += wave_rad * np.sin(2.0 * joints[:, 5])
    arm = nominal_campaign(1, nests=tuple(map(tuple, SPATIAL.tolist())))
    chain = forward(nominal_values(arm.robot, turned), np.eye(3), np.zeros(3))
    noise = rotation_from_vector(READ.rotation_rad * rng.normal(size=(n, 3)))
    readings = PointReadings(
        Stops(np.arange(1, n + 1), joints),
        np.full(n, 4),
        chain.points(centre(SPATIAL)) + READ.position_mm * rng.normal(size=(n, 3)),
        np.full(n, READ.position_mm),
        quaternion=quaternion_from_rotation(noise @ chain.end_rotation),
        rotation_uncertainty_rad=np.full(n, READ.rotation_rad),
    )
    shown = Nest(tuple(centre(SPATIAL).tolist()), DEFINED.position_mm)
    return replace(
        arm,
        nests=(*arm.nests, shown),
        calibration=readings,
        tool_rotation_uncertainty_rad=DEFINED.rotation_rad,
    )


def test_a_wave_about_the_axis_of_the_artefact_shows_in_its_orientations():
    """Which joint is said always; that it is a wave is not: what is held out is judged by positions."""
    answer = diagnose(poses(WAVE_RAD))

    told = [*(finding.subject for finding in answer.findings), english(answer.remaining.sentence)]
    assert answer.verdict is not Verdict.CONSISTENT
    assert any("joint 6" in sentence for sentence in told)


def test_of_an_arm_without_a_cause_nothing_is_found_and_what_the_artefact_is_off_by_is_kept():
    answer = diagnose(poses(0.0))

    assert (answer.verdict, answer.findings) == (Verdict.CONSISTENT, ())
    kept = [p.name for p in answer.model.parameters if p.effect == "tool_certificate"]
    assert kept == ["certified_4_x", "certified_4_y", "certified_4_z"]


def test_bad_poses_whose_turns_state_no_uncertainty_are_held_against_a_fit_that_trusts_them():
    campaign = poses(0.0)
    points = replace(campaign.calibration, rotation_uncertainty_rad=None)
    off_mm = points.position_mm.copy()
    off_mm[[7, 21]] += 3.0
    measured = replace(
        campaign, calibration=replace(points, position_mm=off_mm), validation=points.taken(np.arange(30))
    )

    answer = diagnose(measured)

    (bad,) = [finding for finding in answer.findings if finding.effect == "outliers"]
    assert bad.amplitude == 2 / 60
    assert bad.gain.rms_before_mm > bad.gain.rms_after_mm
