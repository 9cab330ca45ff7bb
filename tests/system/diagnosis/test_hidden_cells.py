"""Cells without a name, hidden in a simulated arm by mechanics of their own: found, and described rightly."""

import re
from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.diagnosis.hidden_causes import recorded
from truepose.diagnosis.diagnose import diagnose
from truepose.domain.results.diagnosis import Verdict
from truepose.words.catalogue import english
from truepose_simulators.physics.effects.effect import Deflection
from truepose_simulators.physics.rigid import move


class Creeping:
    """A joint that has a share of its way still before it when it is measured."""

    def __init__(self, joint, share):
        self._joint, self._share = joint - 1, share

    def deflect(self, conditions, _loads):
        way = np.diff(conditions.joints_rad[:, self._joint], prepend=0.0)
        return Deflection.of_joint(conditions, self._joint, -self._share * way)


class Line:
    """A wave of a joint's own angle, of any order."""

    def __init__(self, joint, order, amplitude_deg):
        self._joint, self._order, self._amplitude_deg = joint - 1, order, amplitude_deg

    def deflect(self, conditions, _loads):
        wave = np.sin(self._order * conditions.joints_rad[:, self._joint] + 0.5)
        return Deflection.of_joint(conditions, self._joint, np.radians(self._amplitude_deg) * wave)


@pytest.mark.parametrize(
    ("joint", "order", "readings", "seed"),
    [(2, 7.4, 150, 1), (2, 7.4, 150, 21), (4, 12.34, 100, 3), (6, 16.67, 100, 6), (1, 21.5, 150, 5)],
)
def test_a_line_between_whole_orders_is_told_with_its_order(joint, order, readings, seed, tmp_path):
    """Joint 6 leaves so many waves beside it that they are first a curve."""
    campaign = recorded(tmp_path, Line(joint, order, 0.02), seed=seed, configurations=readings)

    diagnosis = diagnose(campaign)

    (finding,) = diagnosis.findings
    told = finding.details[0]
    assert (finding.effect, finding.subject) == ("joint_harmonics", f"joint {joint}")
    assert (told.name, finding.confidence) == ("order", "certain")
    assert 0.0 < told.standard_uncertainty < 0.06
    assert told.value == pytest.approx(order, abs=3.0 * told.standard_uncertainty)
    assert f"a wave of {told.value:.2f} periods per turn" in english(finding.sentence)
    assert finding.amplitude == pytest.approx(0.02, abs=4.0 * finding.amplitude_standard_uncertainty)


@pytest.mark.parametrize(("joint", "order", "readings", "seed"), [(2, 7, 150, 2), (3, 11, 100, 7)])
def test_a_wave_of_a_whole_order_stays_one(joint, order, readings, seed, tmp_path):
    campaign = recorded(tmp_path, Line(joint, order, 0.02), seed=seed, configurations=readings)

    (finding,) = diagnose(campaign).findings

    assert (finding.details[0].value, finding.details[0].standard_uncertainty) == (order, 0.0)


class SoftFlange:
    """The tool tilts about axes of the last frame by the moment of its weight about the flange."""

    def __init__(self, *compliance_rad_per_n_mm):
        self._compliance = np.array([*compliance_rad_per_n_mm, 0.0])

    def deflect(self, conditions, loads):
        if loads.bodies is None:
            return Deflection()
        flange = loads.bodies.last_frame
        tool = loads.masses[-1]
        arm = np.einsum("nij,ni->nj", flange[:, :3, :3], tool.centre_mm - flange[:, :3, 3])
        weight = np.einsum("nij,i->nj", flange[:, :3, :3], tool.mass_kg * np.array(loads.gravity_m_s2))
        tilt = self._compliance * np.cross(arm, weight)
        return Deflection.of_body(conditions, -1, np.hstack([np.zeros_like(tilt), tilt]))


class Hose:
    """A hose under tension between a clip on the base and one on an arm's body, stated as all joints read 0.

    Its pull winds up the gears of the joints between the two.
    """

    _GEARS_RAD_PER_N_MM = (2e-8, 3.2e-8, 1.3e-7, 6.05e-7, 4.19e-7, 6.47e-7)

    def __init__(self, pull_n, body, clip_mm, clip_on_base_mm):
        self._pull_n, self._body = pull_n, body
        self._clips = np.array(clip_mm), np.array(clip_on_base_mm)

    def deflect(self, conditions, loads):
        if loads.bodies is None:
            return Deflection()
        bodies = loads.bodies
        clip, start = (
            move(bodies.placements[:, body], place)
            for body, place in zip((self._body, 0), self._clips, strict=True)
        )
        force = self._pull_n * (start - clip) / np.linalg.norm(start - clip, axis=1)[:, None]
        angles = np.zeros_like(conditions.joints_rad)
        for joint in range(self._body):
            moment = np.cross(clip - bodies.axis_points_mm[:, joint], force)
            torque = np.einsum("ni,ni->n", bodies.axis_directions[:, joint], moment)
            angles[:, joint] = self._GEARS_RAD_PER_N_MM[joint] * torque
        return Deflection(angles_rad=angles)


def joints_named(text):
    return {int(number) for number in re.findall(r"\d+", text)}


@pytest.mark.parametrize(
    ("pull_n", "body", "clip_mm", "seed"),
    [
        (30.0, 3, (0.0, 80.0, 680.0), 12),
        (30.0, 4, (250.0, 80.0, 680.0), 11),
        (30.0, 5, (302.0, 80.0, 680.0), 15),
    ],
)
def test_a_hose_is_told_by_the_joints_that_it_pulls_and_never_given_a_sure_name(
    pull_n, body, clip_mm, seed, tmp_path
):
    """No cell is a hose: what it does follows the angles between its clips, and so says the answer."""
    hose = Hose(pull_n, body, clip_mm, (-100.0, 0.0, 300.0))

    diagnosis = diagnose(recorded(tmp_path, hose, seed=seed))

    first = diagnosis.findings[0]
    assert "angle" in first.over
    assert joints_named(first.where) | joints_named(first.over) <= set(range(1, body + 1))
    sure = [one for one in diagnosis.findings if one.confidence == "certain"]
    assert {one.effect for one in sure} <= {"unnamed"}
    assert all(joints_named(one.where) <= set(range(1, body + 1)) for one in sure)
    assert diagnosis.after.mean_mm < 0.8 * diagnosis.before.mean_mm


def test_a_hose_on_the_tool_passes_for_a_load_and_is_not_sure(tmp_path):
    hose = Hose(30.0, 6, (374.0, 80.0, 680.0), (-100.0, 0.0, 300.0))

    diagnosis = diagnose(recorded(tmp_path, hose, seed=16))

    assert diagnosis.verdict is Verdict.PARTLY_EXPLAINED
    assert {one.confidence for one in diagnosis.findings} == {"likely"}


@pytest.mark.parametrize(
    ("about_x", "about_y", "seed"), [(1.5e-7, 1.5e-7, 11), (2e-7, 0.0, 12), (0.0, 2e-7, 13)]
)
def test_a_flange_that_gives_under_the_tool_is_told_by_its_load(about_x, about_y, seed, tmp_path):
    diagnosis = diagnose(recorded(tmp_path, SoftFlange(about_x, about_y), seed=seed))

    (finding,) = diagnosis.findings
    wanted = max(about_x, about_y)
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert (finding.where, finding.over, finding.shape) == ("flange", "load", "line")
    assert finding.amplitude == pytest.approx(wanted, abs=4.0 * finding.amplitude_standard_uncertainty)
    for axis, other in (("x", about_y), ("y", about_x)):
        assert (f"about its {axis} axis" in english(finding.sentence)) == (other == 0.0)


@pytest.mark.parametrize(("joint", "share", "seed"), [(2, 1.5e-4, 11), (4, 5e-4, 12)])
def test_a_joint_that_has_not_settled_is_told_by_its_last_move(joint, share, seed, tmp_path):
    diagnosis = diagnose(recorded(tmp_path, Creeping(joint, share), seed=seed))

    (finding,) = diagnosis.findings
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert (finding.where, finding.over, finding.shape) == (f"joint {joint}", "last move", "line")
    assert finding.confidence == "certain"
    assert finding.amplitude == pytest.approx(share, abs=4.0 * finding.amplitude_standard_uncertainty)


def written_with(decimals, points):
    """Readings beside joint angles that were written down in degrees with so many decimals."""
    joints_rad = np.radians(np.round(np.degrees(points.stops.joints_rad), decimals))
    return replace(points, stops=replace(points.stops, joints_rad=joints_rad))


@pytest.mark.parametrize(("decimals", "seed"), [(1, 12), (2, 702)])
def test_angles_with_few_digits_are_told_to_be_the_noise(decimals, seed, tmp_path):
    exact = recorded(tmp_path, seed=seed)
    campaign = replace(
        exact,
        calibration=written_with(decimals, exact.calibration),
        validation=written_with(decimals, exact.validation),
    )

    diagnosis = diagnose(campaign)

    assert diagnosis.verdict is Verdict.CONSISTENT
    assert f"the joint angles are given in steps of {0.1**decimals:g} deg" in english(diagnosis.message)
    assert english(diagnosis.message).endswith("Give them with all their digits.")


def test_an_arm_that_settles_has_nothing_of_it(tmp_path):
    diagnosis = diagnose(recorded(tmp_path, seed=14))

    assert diagnosis.verdict is Verdict.CONSISTENT
