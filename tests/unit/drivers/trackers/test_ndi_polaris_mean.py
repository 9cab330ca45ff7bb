"""The mean of poses: of turns about one axis it is known in closed form."""

import math

import pytest

from truepose_drivers.ndi_polaris.mean import mean_pose
from truepose_drivers.ndi_polaris.protocol import ToolPose


def turned(angle_rad, *, side=1.0, x=0.0):
    half = 0.5 * angle_rad
    return ToolPose((side * math.cos(half), 0.0, 0.0, side * math.sin(half)), (x, 2.0, -3.0), 0.1)


def test_mean_and_scatter_of_small_turns():
    mean = mean_pose([turned(1.0, x=1.0), turned(1.002, side=-1.0, x=2.0), turned(1.001, x=3.0)])

    assert mean.quaternion == pytest.approx((math.cos(0.5005), 0.0, 0.0, math.sin(0.5005)), abs=1e-12)
    assert mean.position_mm == (2.0, 2.0, -3.0)
    assert mean.deviation_mm == (1.0, 0.0, 0.0)
    assert mean.deviation_rad == pytest.approx(0.001, rel=1e-6)  # chord and arc differ by a part in 1e7
    assert mean.error_mm == pytest.approx(0.1)


def test_scatter_far_below_a_doubles_cosine_is_seen():
    mean = mean_pose([turned(2.0), turned(2.0 + 2e-9)])

    assert mean.deviation_rad == pytest.approx(math.sqrt(2.0) * 1e-9, rel=1e-6)


def test_one_frame_has_no_scatter_and_a_quaternion_of_one_sign():
    mean = mean_pose([turned(3.0, side=-1.001)])

    assert mean.quaternion == pytest.approx((math.cos(1.5), 0.0, 0.0, math.sin(1.5)), abs=1e-15)
    assert all(map(math.isnan, (*mean.deviation_mm, mean.deviation_rad)))
