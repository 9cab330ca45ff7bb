"""Aims poses as a service does after its pre-calibration: legs come near the lengths that were wanted.

The recorder knows the truth; it looks for the joints at which the noise-free legs have the wanted lengths,
each missed by what a pre-calibrated model would miss it by.
"""

from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from simulators.cell import Cell
from simulators.physics.effects.ports import NestNumbers
from simulators.physics.rigid import FloatArray
from simulators.recording.ballbar_tour import PlannedLegs, Tour

BoolArray: TypeAlias = npt.NDArray[np.bool_]

_STEP_DEG = 0.01  # of the numerical derivative: legs bend by less than 1e-4 mm over it
_STEPS = 6
_LARGEST_STEP_DEG = 5.0  # Gauss-Newton near a singular pose would leave its branch
_CLOSE_MM = 0.02


def aim(
    cell: Cell, tour: Tour, legs: PlannedLegs, cups_mm: FloatArray, wanted_mm: FloatArray, approach: str
) -> tuple[Tour, BoolArray]:
    """Correct the joints of all poses.

    Parameters
    ----------
    cell, tour, legs
        The campaign; directions of approach are those of the tour as it was planned.
    cups_mm : ndarray, shape (n, 3)
        True cup of each leg [mm, world].
    wanted_mm : ndarray, shape (n,)
        Length that each leg should have.
    approach : str
        As `plan.directions` takes it, for the tour that comes out.

    Returns
    -------
    Tour
        With the joints found.
    ndarray of bool, shape (n,)
        Legs whose pose came near; the others belong to poses that the arm cannot correct.
    """
    stops = np.unique(legs.stop)
    row = np.searchsorted(stops, legs.stop)  # of each leg among the poses
    joints = tour.joints_deg[stops]
    for _ in range(_STEPS):
        missed, slopes = _linearised(cell, tour, legs, cups_mm, wanted_mm, stops, row, joints)
        for pose in range(len(stops)):
            mine = row == pose
            step = -np.linalg.lstsq(slopes[mine], missed[mine], rcond=1e-4)[0]
            joints[pose] += np.clip(step, -_LARGEST_STEP_DEG, _LARGEST_STEP_DEG)
        joints = _within_limits(cell, joints)
    missed = _lengths_mm(cell, tour, legs, cups_mm, stops, row, joints) - wanted_mm
    worst = np.zeros(len(stops))
    np.maximum.at(worst, row, np.abs(missed))
    return tour.redirected(stops, joints, approach), (worst < _allowed_mm(legs, row))[row]


def _allowed_mm(legs: PlannedLegs, row: NestNumbers) -> FloatArray:
    """Return what each pose may miss (poses,): more than six legs meet their lengths in the mean only."""
    spare = np.bincount(row) > 6
    return np.where(spare, 10.0 * _CLOSE_MM, _CLOSE_MM)


def _linearised(
    cell: Cell,
    tour: Tour,
    legs: PlannedLegs,
    cups_mm: FloatArray,
    wanted_mm: FloatArray,
    stops: NestNumbers,
    row: NestNumbers,
    joints_deg: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Return how far legs are from what is wanted (n,) and how they change [mm/deg], (n, J)."""
    at = _lengths_mm(cell, tour, legs, cups_mm, stops, row, joints_deg)
    slopes = np.empty((len(at), joints_deg.shape[1]))
    for joint in range(joints_deg.shape[1]):
        moved = joints_deg.copy()
        moved[:, joint] += _STEP_DEG
        slopes[:, joint] = (_lengths_mm(cell, tour, legs, cups_mm, stops, row, moved) - at) / _STEP_DEG
    return at - wanted_mm, slopes


def _lengths_mm(
    cell: Cell,
    tour: Tour,
    legs: PlannedLegs,
    cups_mm: FloatArray,
    stops: NestNumbers,
    row: NestNumbers,
    joints_deg: FloatArray,
) -> FloatArray:
    """Return true legs (n,) with the poses at other joints."""
    conditions = cell.conditions(
        np.radians(joints_deg), tour.direction[stops], tour.end_s[stops], np.ones(len(stops))
    )
    nests = cell.true_positions(conditions)[row, legs.tool_point - 1]
    lengths: FloatArray = np.linalg.norm(nests - cups_mm, axis=1)
    return lengths


def _within_limits(cell: Cell, joints_deg: FloatArray) -> FloatArray:
    lower, upper = np.degrees(cell.plant.arm.limits_rad.T)
    clipped: FloatArray = np.clip(joints_deg, lower, upper)
    return clipped
