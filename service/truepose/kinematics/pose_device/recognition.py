"""Which of the poses that the lengths allow is the one that the robot was commanded to."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.kinematics.pose_device.poses import Pose

# Per coordinate of a nest. The nominal robot of the thesis is off by 1.7 mm in space (rms, chapter 4), 1 mm
# per coordinate; twice that, so that its worst 5.2 mm still counts as the robot's own error.
_ARM_U_MM = 2.0
_FAR = 33.7  # 99.99 % quantile of chi-squared with 9 degrees of freedom, one for each nest coordinate
_LOG_ODDS = float(np.log(1000.0))  # by which the nearest must be more likely than the next


@dataclass(frozen=True, slots=True)
class RecognisedAssembly:
    """The assembly mode in which the legs were measured."""

    index: int  # in the sequence of poses that were compared
    distance_mm: float  # of its nests from the commanded ones, rms
    margin_mm: float  # by which the next pose is farther; infinite where there is no other


def recognise_assembly(
    commanded: Pose, candidates: Sequence[Pose], nests_mm: FloatArray, *, arm_u_mm: float = _ARM_U_MM
) -> RecognisedAssembly | None:
    """Return the pose that the commanded one stands for; None where none is near, or two are.

    Parameters
    ----------
    commanded : Pose
        By the nominal model, in the frame of the cups.
    candidates : sequence of Pose
        E.g. the four solutions of a design, in any order; those that are not finite are never chosen.
    nests_mm : ndarray, shape (3, 3)
        In the last frame.
    arm_u_mm : float
        Standard uncertainty of the commanded place of a nest, per coordinate.
    """
    square = np.array([square_mm2(commanded, one, nests_mm) for one in candidates])
    order = np.argsort(np.where(np.isnan(square), np.inf, square), kind="stable")
    if not order.size or not square[order[0]] <= _FAR * arm_u_mm**2:
        return None
    nearest = float(square[order[0]])
    following = float(square[order[1]]) if order.size > 1 else np.nan
    following = np.inf if np.isnan(following) else following
    if following - nearest < 2.0 * _LOG_ODDS * arm_u_mm**2:
        return None
    distance, beyond = np.sqrt(nearest / 3.0), np.sqrt(following / 3.0)
    return RecognisedAssembly(int(order[0]), float(distance), float(beyond - distance))


def is_clearly_nearer(
    nearest: Pose, following: Pose, commanded: Pose, nests_mm: FloatArray, *, arm_u_mm: float = _ARM_U_MM
) -> bool:
    """Say whether the first pose is a thousand times likelier than the second to be the commanded one."""
    gained = square_mm2(following, commanded, nests_mm) - square_mm2(nearest, commanded, nests_mm)
    return gained >= 2.0 * _LOG_ODDS * arm_u_mm**2


def square_mm2(first: Pose, second: Pose, nests_mm: FloatArray) -> float:
    """Return the sum of the squared distances of the three nests between two poses."""
    return float(((first.points(nests_mm) - second.points(nests_mm)) ** 2).sum())
