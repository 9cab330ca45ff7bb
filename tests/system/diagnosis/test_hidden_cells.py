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
