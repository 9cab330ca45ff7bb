"""Aims stops as a service does after its pre-calibration: legs and balls come near what was wanted.

The recorder knows the truth: it looks for the joints at which legs have the wanted lengths, or the ball is at
the wanted place, without noise. Whoever asks adds what a pre-calibrated model would miss them by.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import TypeAlias

import numpy as np
import numpy.typing as npt

from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.physics.effects.ports import NestNumbers
from truepose_simulators.physics.rigid import FloatArray
from truepose_simulators.recording.ballbars.tour import PlannedLegs, Tour

BoolArray: TypeAlias = npt.NDArray[np.bool_]
Misses: TypeAlias = Callable[[FloatArray], FloatArray]  # joints of P stops [deg], (P, J) -> (n,) [mm]

_STEP_DEG = 0.01  # of the numerical derivative: lengths bend by less than 1e-4 mm over it
_STEPS = 6
_LARGEST_STEP_DEG = 5.0  # Gauss-Newton near a singular pose would leave its branch
_LEAST_SINGULAR_SHARE = 1e-4
_CLOSE_MM = 0.02
_CLOSE_IN_THE_MEAN_MM = 0.2  # more than six legs cannot all have their lengths


def aim_legs(
    cell: Cell, tour: Tour, legs: PlannedLegs, cups_mm: FloatArray, wanted_mm: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Find joints at which legs have the lengths `wanted_mm` (n,), from cups `cups_mm` (n, 3) [world].

    Returns
    -------
    ndarray, shape (S, J)
        Joints of all stops of the tour [deg]; directions of approach count as they were planned.
    ndarray of bool, shape (n,)
        Legs whose pose came near; the others belong to poses that the arm cannot correct.
    """
    stops, row = np.unique(legs.stop, return_inverse=True)

    def misses(joints_deg: FloatArray) -> FloatArray:
        nests = _nests_mm(cell, tour, stops, joints_deg)[row, legs.tool_point - 1]
        missed: FloatArray = np.linalg.norm(nests - cups_mm, axis=1) - wanted_mm
        return missed

    joints = tour.joints_deg.copy()
    joints[stops] = _corrected(cell, misses, row, tour.joints_deg[stops])
    worst = np.zeros(len(stops))
    np.maximum.at(worst, row, np.abs(misses(joints[stops])))
    n_joints = joints.shape[1]
    allowed = np.where(np.bincount(row) > n_joints, _CLOSE_IN_THE_MEAN_MM, _CLOSE_MM)
    return joints, (worst < allowed)[row]


def aim_balls(cell: Cell, tour: Tour, stops: NestNumbers, wanted_mm: FloatArray) -> FloatArray:
    """Find joints at which tool nest 1 is at `wanted_mm` (k, 3) [world] at `stops` (k,); shape (S, J)."""

    def misses(joints_deg: FloatArray) -> FloatArray:
        missed: FloatArray = (_nests_mm(cell, tour, stops, joints_deg)[:, 0] - wanted_mm).ravel()
        return missed

    joints = tour.joints_deg.copy()
    row = np.repeat(np.arange(len(stops)), 3)
    joints[stops] = _corrected(cell, misses, row, tour.joints_deg[stops])
    return joints


def _corrected(cell: Cell, misses: Misses, row: NestNumbers, joints_deg: FloatArray) -> FloatArray:
    """Make the misses as small as they get, each of them of the stop in `row`; shape (P, J)."""
    lower, upper = np.degrees(cell.plant.arm.limits_rad.T)
    joints = joints_deg.copy()
    for _ in range(_STEPS):
        missed, slopes = misses(joints), _slopes(misses, joints)
        for stop in range(len(joints)):
            mine = row == stop
            step = np.linalg.lstsq(slopes[mine], missed[mine], rcond=_LEAST_SINGULAR_SHARE)[0]
            joints[stop] -= np.clip(step, -_LARGEST_STEP_DEG, _LARGEST_STEP_DEG)
        joints = np.clip(joints, lower, upper)
    return joints


def _slopes(misses: Misses, joints_deg: FloatArray) -> FloatArray:
    """Return how misses change with each joint of their stop [mm/deg], shape (n, J)."""
    steps = _STEP_DEG * np.eye(joints_deg.shape[1])
    return np.stack(
        [(misses(joints_deg + step) - misses(joints_deg - step)) / (2.0 * _STEP_DEG) for step in steps],
        axis=1,
    )


def _nests_mm(cell: Cell, tour: Tour, stops: NestNumbers, joints_deg: FloatArray) -> FloatArray:
    """Return the true nests with the stops at other joints, shape (P, nests, 3)."""
    joints = tour.joints_deg.copy()
    joints[stops] = joints_deg
    return cell.true_positions(replace(tour, joints_deg=joints).conditions(cell, stops, tour.end_s[stops]))
