"""The mean of poses that hardly differ, and their scatter."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from truepose_drivers.api import Quaternion, Vector
from truepose_drivers.ndi_polaris.protocol import ToolPose


@dataclass(frozen=True, slots=True)
class MeanPose:
    """Mean and scatter of frames; the scatter of a single frame is NaN."""

    quaternion: Quaternion  # unit, first component not negative
    position_mm: Vector
    deviation_mm: Vector  # of one frame, per coordinate
    deviation_rad: float  # of one frame: root mean square turn away from the mean
    error_mm: float  # root mean square of what the instrument states


def mean_pose(poses: Sequence[ToolPose]) -> MeanPose:
    """Return the mean of at least one pose.

    The mean quaternion is the normalised sum of quaternions on the same half of the sphere, which for small
    scatter is the mean rotation to second order (Gramkow, J. Math. Imaging and Vision 15, 2001).
    """
    quaternion = _mean_quaternion([pose.quaternion for pose in poses])
    columns = list(zip(*(pose.position_mm for pose in poses), strict=True))
    x, y, z = (math.fsum(column) / len(poses) for column in columns)
    sx, sy, sz = (
        _deviation([value - mean for value in column])
        for column, mean in zip(columns, (x, y, z), strict=True)
    )
    return MeanPose(
        quaternion,
        (x, y, z),
        (sx, sy, sz),
        _deviation([_turn_rad(pose.quaternion, quaternion) for pose in poses]),
        math.sqrt(math.fsum(pose.error_mm**2 for pose in poses) / len(poses)),
    )


def _mean_quaternion(quaternions: Sequence[Quaternion]) -> Quaternion:
    first = quaternions[0]
    sums = [0.0] * 4
    for quaternion in quaternions:
        # q and -q are one orientation; summed as they come they would cancel each other.
        side = math.copysign(1.0, _dot(quaternion, first))
        sums = [total + side * part for total, part in zip(sums, quaternion, strict=True)]
    length = math.copysign(math.hypot(*sums), sums[0])
    q0, qx, qy, qz = (part / length for part in sums)
    return q0, qx, qy, qz


def _turn_rad(one: Quaternion, other: Quaternion) -> float:
    """Angle between two orientations; from the chord, which is exact where the cosine is not."""
    length = math.hypot(*one)
    side = math.copysign(length, _dot(one, other))
    chord = math.hypot(*(a / side - b for a, b in zip(one, other, strict=True)))
    # |a - b| = 2 sin(turn / 4) for unit quaternions; rounding may take half the chord beyond 1.
    return 4.0 * math.asin(min(1.0, chord / 2.0))


def _dot(one: Quaternion, other: Quaternion) -> float:
    return math.fsum(a * b for a, b in zip(one, other, strict=True))


def _deviation(from_mean: Sequence[float]) -> float:
    if len(from_mean) < 2:
        return math.nan
    return math.sqrt(math.fsum(value * value for value in from_mean) / (len(from_mean) - 1))
