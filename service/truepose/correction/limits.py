"""Joint limits of the controller, as far as they are known."""

from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.robot import JointRange
from truepose.kinematics.inverse import brought_within

# Corrections turn joints by tenths of a degree; near a singularity they would turn one by any angle.
FAR_RAD: Final = float(np.deg2rad(5.0))


def turned_within(
    limits: tuple[JointRange, ...] | None, joints_rad: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Turn joints (n, J) by whole turns into their limits, and say which rows are within; all if unknown."""
    if limits is None:
        return joints_rad, np.ones(len(joints_rad), dtype=bool)
    return brought_within(joints_rad, limits)


def beyond(limits: tuple[JointRange, ...] | None, joints_rad: FloatArray) -> FloatArray:
    """Return by how much each joint is beyond its limits, shape (n, J) [rad]; NaN where they are unknown."""
    if limits is None:
        return np.full_like(joints_rad, np.nan)
    low, high = (np.array(ends) for ends in zip(*((r.lower_rad, r.upper_rad) for r in limits), strict=True))
    return np.asarray(np.maximum(np.maximum(low - joints_rad, joints_rad - high), 0.0))
