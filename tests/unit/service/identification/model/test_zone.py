"""The zone that was measured, and what is outside of it."""

from dataclasses import replace

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.proved import model
from tests.helpers.identification.synthetic import configurations
from truepose.domain.errors import ConfigurationError
from truepose.domain.robot import JointRow
from truepose.identification.model.validity import measured_zone, outside, require_same_robot
from truepose.kinematics.chain import nominal_chain

JOINTS = configurations(60)
ZONE = measured_zone(IRB_120, JOINTS)


def test_what_was_measured_is_not_outside():
    distance, angle = outside(ZONE, IRB_120, JOINTS)

    assert distance == pytest.approx(np.zeros(60), abs=1e-9)
    assert not angle.any()


def test_a_joint_beyond_its_range_is_told_by_how_much():
    beyond = np.array([JOINTS[0], JOINTS[1]])
    beyond[0, 3] = JOINTS[:, 3].max() + 0.25
    beyond[1, 1] = JOINTS[:, 1].min() - 0.1

    _, angle = outside(ZONE, IRB_120, beyond)

    assert angle[0] == pytest.approx([0, 0, 0, 0.25, 0, 0])
    assert angle[1] == pytest.approx([0, 0.1, 0, 0, 0, 0])


def test_the_distance_is_that_from_the_farthest_place_along_a_direction():
    low = np.zeros((1, 6))  # one place: straight ahead, 374 mm before the base and 630 mm above it
    zone = measured_zone(IRB_120, low)
    turned = np.array([[np.pi, 0.0, 0.0, 0.0, 0.0, 0.0]])

    distance, _ = outside(zone, IRB_120, turned)

    here, there = (nominal_chain(IRB_120, q).end_origin[0] for q in (low, turned))
    assert distance == pytest.approx([np.linalg.norm(there - here)])


@pytest.mark.parametrize(
    "row",
    [JointRow(0.0, 271.0, 0.0, 0.0), replace(IRB_120.joints[2], beta_rad=1e-3)],
    ids=["length", "tilt"],
)
def test_a_model_of_another_nominal_table_is_refused_with_its_row(row):
    rows = (*IRB_120.joints[:2], row, *IRB_120.joints[3:])

    require_same_robot(model(), IRB_120)
    with pytest.raises(ConfigurationError, match="Row 3"):
        require_same_robot(model(), replace(IRB_120, joints=rows))
