"""A table of measured points as a circle test: which of its rows are of which joint, and from which side.

The others stand where they stand most often in the table. A row in which no joint is away from there belongs
to the joint that moved before it. Where that leaves more rows over than it does to go through them in order,
the others may stand elsewhere for each joint: a sweep is then a run of rows in which one joint alone moved.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import PointReadings

_FEWEST: Final = 4  # rows of a run; fewer determine no circle
SAME_ANGLE_RAD: Final = float(np.radians(0.05))  # reported angles are rounded to 0.01 deg, and jitter by it


@dataclass(frozen=True, slots=True)
class Sweep:
    """Readings of one nest while one joint turned, m of the table's rows in the order of measuring."""

    joint: int  # 1-based
    nest: int
    rows: IntArray  # (m,)
    angle_rad: FloatArray  # (m,) of that joint
    direction: IntArray  # (m,) sign of its last motion, 0 unknown


def find_sweeps(points: PointReadings) -> tuple[Sweep, ...]:
    """Return the sweeps of a table, by joint and nest.

    Parameters
    ----------
    points : PointReadings
        n >= 1 rows; where all times are known they give the order, else the rows do. Where the table does
        not say the direction of a joint's last motion, the row before does.

    Returns
    -------
    tuple of Sweep

    Raises
    ------
    ConfigurationError
        There are no rows in which one joint alone is away from where it stands most often.
    """
    order = _in_order(points)
    moved = _moved(points.stops.joints_rad)
    runs = _runs(points.stops.joints_rad[order]) if (moved.sum(axis=1) > 1).any() else []
    if sum(len(rows) for _, rows in runs) > np.count_nonzero(moved.sum(axis=1) <= 1):
        found = tuple(sweep for joint, rows in runs for sweep in _of_run(points, joint, order[rows]))
    else:
        found = tuple(
            sweep
            for nest in np.unique(points.nest).tolist()
            for sweep in _of_nest(points, nest, moved, order[points.nest[order] == nest])
        )
    if not found:
        raise ConfigurationError(
            "The table holds no readings in which one joint moved while all others stood: a circle test "
            "turns one joint at a time."
        )
    return tuple(sorted(found, key=lambda sweep: (sweep.joint, sweep.nest)))


def _runs(joints_rad: FloatArray) -> list[tuple[int, IntArray]]:
    """Return the joint (1-based) and the rows of every run in which that joint alone moved."""
    found, first, turned = [], 0, -1
    for row, joints in enumerate(np.vstack([joints_rad, np.full(joints_rad.shape[1], np.inf)])):
        moved = np.flatnonzero(np.abs(joints - joints_rad[first]) > SAME_ANGLE_RAD)
        if len(moved) == 0 or (len(moved) == 1 and turned in {-1, moved[0]}):
            turned = int(moved[0]) if len(moved) else turned
            continue
        if turned >= 0 and row - first >= _FEWEST:
            found.append((turned + 1, np.arange(first, row)))
        first, turned = min(row, len(joints_rad) - 1), -1
    return found


def _of_run(points: PointReadings, joint: int, rows: IntArray) -> Iterator[Sweep]:
    for nest in np.unique(points.nest[rows]).tolist():
        yield _sweep(points, joint, nest, rows[points.nest[rows] == nest])


def _of_nest(points: PointReadings, nest: int, moved: BoolArray, rows: IntArray) -> Iterator[Sweep]:
    rows = rows[moved[rows].sum(axis=1) <= 1]
    joint = _adopted(np.where(moved[rows].any(axis=1), moved[rows].argmax(axis=1) + 1, 0))
    for number in np.unique(joint[joint > 0]).tolist():
        yield _sweep(points, number, nest, rows[joint == number])


def _sweep(points: PointReadings, joint: int, nest: int, rows: IntArray) -> Sweep:
    angle = points.stops.joints_rad[rows, joint - 1]
    told = points.stops.direction
    known = np.zeros(len(rows), dtype=np.int64) if told is None else told[rows, joint - 1]
    return Sweep(joint, nest, rows, angle, np.where(known != 0, known, _direction(angle)))


def _in_order(points: PointReadings) -> IntArray:
    time_s = points.stops.time_s
    if time_s is None or not np.isfinite(time_s).all():
        return np.arange(len(points))
    return np.argsort(time_s, kind="stable")


def _moved(joints_rad: FloatArray) -> BoolArray:
    """Whether each joint is away from where it stands most often, shape (n, J)."""
    rest = np.array([_most_often(column) for column in joints_rad.T])
    return np.asarray(np.abs(joints_rad - rest) > SAME_ANGLE_RAD)


def _most_often(angles: FloatArray) -> float:
    ascending = np.sort(angles)
    below = np.searchsorted(ascending, ascending - SAME_ANGLE_RAD)
    above = np.searchsorted(ascending, ascending + SAME_ANGLE_RAD, side="right")
    return float(ascending[np.argmax(above - below)])


def _adopted(joint: IntArray) -> IntArray:
    """Return the joint of every row, shape (m,): that of the row before where none is moved, else after."""
    known = np.flatnonzero(joint)
    if not len(known):
        return joint
    before = np.searchsorted(known, np.arange(len(joint)), side="right") - 1
    return np.asarray(joint[known[np.maximum(before, 0)]])


def _direction(angle: FloatArray) -> IntArray:
    """Return the sign of the last motion that the order of the angles tells, shape (m,); 0 at the first."""
    step = np.diff(angle, prepend=angle[:1])
    sign = np.where(np.abs(step) > SAME_ANGLE_RAD, np.sign(step), 0.0).astype(np.int64)
    last = np.maximum.accumulate(np.where(sign != 0, np.arange(len(sign)), 0))
    return np.asarray(sign[last])
