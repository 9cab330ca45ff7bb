"""The arm of a picture: it ends where the tool is, whatever draws it."""

import numpy as np
import pytest

from tests.helpers.domain.robots import IRB_120
from truepose.domain.robot import FramePlacement
from truepose.reports.plan_3d import arm_pieces

_BASE = FramePlacement(100.0, -50.0, 30.0, 0.0, 0.0, np.pi / 2)
_NEST = np.array([[0.0, 0.0, 125.0]])
_ZERO = np.zeros((1, 6))


def test_the_tool_of_a_stretched_arm_is_where_its_makers_drawing_says():
    (pieces,) = arm_pieces(IRB_120, _BASE, _NEST, _ZERO)

    # 302 mm forearm and 72 + 125 mm in front of the elbow, 290 + 270 + 70 mm up; the base is turned to y.
    assert pieces[-1, 3:6] == pytest.approx([100.0, -50.0 + 302.0 + 72.0 + 125.0, 30.0 + 630.0], abs=1e-9)


def test_each_piece_begins_where_another_ends():
    joints = np.random.default_rng(1).uniform(-1.0, 1.0, (5, 6))

    for pieces in arm_pieces(IRB_120, _BASE, _NEST, joints):
        ends = [np.array([100.0, -50.0, 30.0]), *pieces[:-1, 3:6]]
        assert all(min(np.linalg.norm(start - end) for end in ends) < 1e-6 for start in pieces[:, :3])


def test_an_arm_without_known_nests_ends_at_its_flange():
    (bare,) = arm_pieces(IRB_120, _BASE, np.zeros((0, 3)), _ZERO)
    (with_tool,) = arm_pieces(IRB_120, _BASE, _NEST, _ZERO)

    assert bare == pytest.approx(with_tool[:-1])
