"""Mechanics that have no name in the library, and what must be told of each."""

import numpy as np
import pytest

from truepose.domain.diagnosis import Verdict
from truepose.messages.catalogue import english
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


class SoftFlange:
    """The tool tilts about axes of the flange frame by the moment of its weight about the flange."""

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


def assert_line_told(diagnosis, joint, order):
    """A wave of 0.02 deg is told with its order, which is between two whole ones."""
    (finding,) = diagnosis.findings
    told = finding.details[0]
    assert (finding.effect, finding.subject) == ("joint_harmonics", f"joint {joint}")
    assert (told.name, finding.confidence) == ("order", "certain")
    assert 0.0 < told.standard_uncertainty < 0.06
    assert told.value == pytest.approx(order, abs=3.0 * told.standard_uncertainty)
    assert f"a periodic error of {told.value:.2f} periods per turn" in english(finding.sentence)
    assert finding.amplitude == pytest.approx(0.02, abs=4.0 * finding.amplitude_standard_uncertainty)


def assert_flange_told(diagnosis, about_x, about_y):
    """A tilt under the load is told with its axis."""
    (finding,) = diagnosis.findings
    wanted = max(about_x, about_y)
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert (finding.where, finding.over, finding.shape) == ("flange", "load", "line")
    assert finding.amplitude == pytest.approx(wanted, abs=4.0 * finding.amplitude_standard_uncertainty)
    for axis, other in (("x", about_y), ("y", about_x)):
        assert (f"about its {axis} axis" in english(finding.sentence)) == (other == 0.0)


def assert_last_move_told(diagnosis, joint, share):
    """The way that a joint still has before it is told as a share of its last move."""
    (finding,) = diagnosis.findings
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert (finding.where, finding.over, finding.shape) == (f"joint {joint}", "last move", "line")
    assert finding.confidence == "certain"
    assert finding.amplitude == pytest.approx(share, abs=4.0 * finding.amplitude_standard_uncertainty)
