"""A table of measured points as a test: which of its rows are cycles, of which poses.

A pose is a configuration that was visited again and again: one of those visited at least half as often as the
one visited most. P1 is the one in the middle, and the others have their numbers from the order in which the
standard visits them: P5 P4 P3 P2 P1, or P4 P2 P1 where there are three. Other rows belong to no cycle.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.campaign import PointReadings
from truepose.identification.model.stops import sites
from truepose.judgement.iso9283.directions import POSES as OF_DIRECTIONS

_OFTEN: Final = 0.5
_NUMBERS: Final = {5: (5, 4, 3, 2, 1), len(OF_DIRECTIONS): tuple(reversed(OF_DIRECTIONS)), 1: (1,)}


@dataclass(frozen=True, slots=True)
class Cycles:
    """The rows of a table that are cycles, m of n."""

    rows: IntArray  # (m,) in the order of the cycles
    pose: IntArray  # (m,)
    cycle: IntArray  # (m,) from 1
    others: BoolArray  # (n,) rows of configurations that are no poses
    nest: int  # whose positions are taken

    @property
    def poses(self) -> tuple[int, ...]:
        """Numbers of the poses, ascending."""
        return tuple(int(number) for number in np.unique(self.pose))


def find_cycles(points: PointReadings) -> Cycles:
    """Return the cycles of a table.

    Parameters
    ----------
    points : PointReadings
        n >= 1 rows; a revisit says in `repeat_of` what it repeats, or has the number of the configuration.
        Where all times are known they give the order, else the rows do. Of several nests the one with
        most rows is taken.

    Returns
    -------
    Cycles

    Raises
    ------
    ConfigurationError
        There are not five poses, three or one.
    """
    place = sites(points.stops)
    nest = int(np.bincount(points.nest).argmax())
    rows = _in_order(points, np.flatnonzero(points.nest == nest))
    visited, count = np.unique(place[rows], return_counts=True)
    often = visited[(count >= 2) & (count >= _OFTEN * count.max())]
    kept = rows[np.isin(place[rows], often)]
    number_of = _numbered(points, place, often, kept)
    pose = np.array([number_of[site] for site in place[kept].tolist()], dtype=np.int64)
    return Cycles(kept, pose, _cycle_of(pose), ~np.isin(place, often), nest)


def _in_order(points: PointReadings, rows: IntArray) -> IntArray:
    time_s = points.stops.time_s
    if time_s is None or not np.isfinite(time_s[rows]).all():
        return rows
    return rows[np.argsort(time_s[rows], kind="stable")]


def _numbered(points: PointReadings, place: IntArray, poses: IntArray, rows: IntArray) -> dict[int, int]:
    """Return the number of each pose by how many visits usually lie between the middle one and it."""
    numbers = _NUMBERS.get(len(poses))
    if numbers is None:
        raise ConfigurationError(_refused(len(poses)))
    middles = np.array([points.position_mm[rows[place[rows] == site]].mean(axis=0) for site in poses])
    middle = poses[np.argmin(np.linalg.norm(middles - middles.mean(axis=0), axis=1))]
    steps = _steps_since(place[rows] == middle)
    usual = [float(np.median(steps[place[rows] == site])) for site in poses]
    return dict(zip(poses[np.argsort(usual)].tolist(), numbers, strict=True))


def _steps_since(marked: BoolArray) -> IntArray:
    """Return how many rows ago the last marked one was, or else the beginning, shape (n,); at least 1."""
    row = np.arange(len(marked))
    marks = np.concatenate([[-1], np.flatnonzero(marked)])
    return np.asarray(row - marks[np.searchsorted(marks, row) - 1])


def _cycle_of(pose: IntArray) -> IntArray:
    """Return the number of the cycle of each visit: a new one begins where the poses no longer descend."""
    begins = np.diff(pose, prepend=pose[:1]) >= 0
    return np.asarray(np.cumsum(begins))


def _refused(n: int) -> str:
    said = {0: "no pose that was", 1: "one pose that was"}.get(n, f"{n} poses that were")
    return (
        f"The table holds {said} visited again and again: ISO 9283 takes five (AP, RP, AD, RD), three from "
        "three directions (vAP), or one in groups over eight hours (drift). Say in repeat_of which visits "
        "are of the same pose."
    )
