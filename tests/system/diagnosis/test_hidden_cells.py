"""Cells without a name, hidden in a simulated arm by mechanics of their own: found, and described rightly."""

import numpy as np
import pytest

from service.diagnosis.diagnose import diagnose
from service.domain.diagnosis import Verdict
from simulators.physics.effects.effect import Deflection
from tests.hidden_causes import recorded


class Creeping:
    """A joint that has a share of its way still before it when it is measured."""

    def __init__(self, joint, share):
        self._joint, self._share = joint - 1, share

    def deflect(self, conditions, _loads):
        way = np.diff(conditions.joints_rad[:, self._joint], prepend=0.0)
        return Deflection.of_joint(conditions, self._joint, -self._share * way)


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
        assert (f"about its {axis} axis" in finding.sentence) == (other == 0.0)


@pytest.mark.parametrize(("joint", "share", "seed"), [(2, 1.5e-4, 11), (4, 5e-4, 12)])
def test_a_joint_that_has_not_settled_is_told_by_its_last_move(joint, share, seed, tmp_path):
    diagnosis = diagnose(recorded(tmp_path, Creeping(joint, share), seed=seed))

    (finding,) = diagnosis.findings
    assert diagnosis.verdict is Verdict.EXPLAINED
    assert (finding.where, finding.over, finding.shape) == (f"joint {joint}", "last move", "line")
    assert finding.confidence == "certain"
    assert finding.amplitude == pytest.approx(share, abs=4.0 * finding.amplitude_standard_uncertainty)


def test_an_arm_that_settles_has_nothing_of_it(tmp_path):
    diagnosis = diagnose(recorded(tmp_path, seed=14))

    assert diagnosis.verdict is Verdict.CONSISTENT
