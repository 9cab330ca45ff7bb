"""The figures of ISO 9283 from a table of measured points, against the nominal and the identified model.

Which rows of a table are cycles, and of which poses: a pose is a configuration that was visited again and
again: one of those visited at least half as often as the one visited most. P1 is the one in the middle, and
the others have their numbers from the order in which the standard visits them: P5 P4 P3 P2 P1, or P4 P2 P1
where there are three. Other rows belong to no cycle.

Poses are commanded where a model puts them: the nominal one, as the controller of an uncorrected robot does,
or the identified one, by which a corrected robot is commanded.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Final, Literal

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.campaign import PointReadings, Readings, Stops, sites
from truepose.domain.errors import ConfigurationError
from truepose.domain.identification import Model, NominalAndIdentified
from truepose.identification.observations.blocks import BlockResult
from truepose.identification.verdict.judge import judge
from truepose.kinematics.frames import rotation_from_quaternion, vector_from_rotation
from truepose.validation.iso9283.drift import Drift, Group, drift
from truepose.validation.iso9283.performance import (
    DIRECTION_POSES,
    DIRECTIONS,
    direction_performance,
    distance_performance,
    pose_performance,
)
from truepose.validation.iso9283.visits import Characteristic, CommandedPose, Performance, Visits, barycentre

_OFTEN: Final = 0.5
_NUMBERS: Final = {5: (5, 4, 3, 2, 1), len(DIRECTION_POSES): tuple(reversed(DIRECTION_POSES)), 1: (1,)}


@dataclass(frozen=True, slots=True)
class Cycles:
    """The rows of a table that are cycles, m of n.

    Attributes
    ----------
    rows : ndarray of int, shape (m,)
        In the order of the cycles.
    pose : ndarray of int, shape (m,)
    cycle : ndarray of int, shape (m,)
        From 1.
    others : ndarray of bool, shape (n,)
        Rows of configurations that are no poses.
    nest : int
        Whose positions are taken.
    """

    rows: IntArray
    pose: IntArray
    cycle: IntArray
    others: BoolArray
    nest: int

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
    # Half as often as the pose visited most: a lost visit costs none its place, and a configuration that a
    # campaign repeats a few times for its spread is no pose.
    often = visited[(count >= 2) & (count >= _OFTEN * count.max())]
    kept = rows[np.isin(place[rows], often)]
    number_of = _numbered(points, place, often, kept)
    pose = np.array([number_of[site] for site in place[kept].tolist()], dtype=np.int64)
    return Cycles(kept, pose, _cycle_of(pose), ~np.isin(place, often), nest)


def _in_order(points: PointReadings, rows: IntArray) -> IntArray:
    """Return rows by time where all times are known, else as they stand."""
    time_s = points.stops.time_s
    if time_s is None or not np.isfinite(time_s[rows]).all():
        return rows
    return rows[np.argsort(time_s[rows], kind="stable")]


def _numbered(points: PointReadings, place: IntArray, poses: IntArray, rows: IntArray) -> dict[int, int]:
    """Return the number of each pose by how many visits usually lie between the middle one and it."""
    numbers = _NUMBERS.get(len(poses))
    if numbers is None:
        raise ConfigurationError(_refused(len(poses)))
    # From the readings, not from a model: the numbers of the poses must not depend on which model commands.
    middles = np.array([points.position_mm[rows[place[rows] == site]].mean(axis=0) for site in poses])
    middle = poses[np.argmin(np.linalg.norm(middles - middles.mean(axis=0), axis=1))]
    steps = _steps_since(place[rows] == middle)
    # The median over all cycles: a lost visit shifts the count of one cycle only.
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
    """Return the sentence that says what the standard takes."""
    said = {0: "no repeatedly measured pose", 1: "one repeatedly measured pose"}.get(
        n, f"{n} repeatedly measured poses"
    )
    return (
        f"The table has {said}. ISO 9283 requires five poses (AP, RP, AD, RD), three poses approached from "
        "three directions (vAP), or one pose in groups over eight hours (drift). Mark repeat measurements "
        "of the same pose in repeat_of."
    )


CommandedBy = Literal["nominal", "identified"]

_OF_COMMANDS: Final = frozenset({"AP", "AD", "dAP"})  # all others are of the attained poses alone


@dataclass(frozen=True, slots=True)
class PoseTest:
    """A test of ISO 9283, and what is known of the rest of the work space.

    Attributes
    ----------
    nominal, identified : Performance
        Against the poses that each model commands.
    poses, cycles, nest : int
    work_space : NominalAndIdentified or None
        Errors at configurations that are no poses; None: none measured.
    claimed_mm : float
        Mean error that the identified model itself lets expect of such.
    commanded : tuple of CommandedPose
        Where the identified model puts them, frame of the readings.
    mixed : tuple of str
        Poses that were approached from several directions, where only one is meant.
    drift : Drift or None
        Of the identified model; None where the test is another one.
    """

    nominal: Performance
    identified: Performance
    poses: int
    cycles: int
    nest: int
    work_space: NominalAndIdentified | None
    claimed_mm: float
    commanded: tuple[CommandedPose, ...] = ()
    mixed: tuple[str, ...] = ()
    drift: Drift | None = None

    def figures(self) -> Iterator[tuple[CommandedBy | None, Characteristic]]:
        """Yield every figure once, with the model that commands where it depends on one.

        Yields
        ------
        commanded_by : str or None
            "nominal" or "identified"; None of figures of the attained poses alone.
        figure : Characteristic
        """
        before = [figure for figure in self.nominal.characteristics if figure.symbol in _OF_COMMANDS]
        yield from (("nominal", figure) for figure in before)
        for figure in self.identified.characteristics:
            yield ("identified" if figure.symbol in _OF_COMMANDS else None), figure


def pose_test(model: Model, points: Readings) -> PoseTest:
    """Return the figures that a table of measured points gives.

    Parameters
    ----------
    model : Model
    points : PointReadings
        n >= 1 rows: cycles, as `find_cycles` tells them, and any other configurations.

    Returns
    -------
    PoseTest
        AP, RP, AD and RD of five poses; vAP of three; drift of one. Components are along and about the axes
        of the frame that the readings are in.

    Raises
    ------
    ConfigurationError
        The table holds no such test, or lengths instead of points, or does not fit the model.
    """
    if not isinstance(points, PointReadings):
        raise ConfigurationError(
            "ISO 9283 evaluates attained positions; ballbar lengths cannot be used. Give positions."
        )
    cycles = find_cycles(points)
    judged = judge(model, points, model.repeatability_mm)
    nominal, identified = (
        _Attained(points.stops, cycles, _commanded(cycles, result), _visits(points, cycles, result))
        for result in (judged.nominal, judged.identified)
    )
    figures = _TESTS[len(cycles.poses)]
    return PoseTest(
        figures(nominal),
        figures(identified),
        len(cycles.poses),
        int(cycles.cycle.max()),
        cycles.nest,
        judged.pair(cycles.others) if cycles.others.any() else None,
        judged.claimed_mm(),
        commanded=_commanded(cycles, judged.identified),
        mixed=tuple(_mixed(points.stops, cycles)),
        drift=_drift(identified) if len(cycles.poses) == 1 else None,
    )


@dataclass(frozen=True, slots=True)
class _Attained:
    """A test as one model commands it."""

    stops: Stops  # of the whole table
    cycles: Cycles
    commanded: tuple[CommandedPose, ...]
    visits: Visits


def _mixed(stops: Stops, cycles: Cycles) -> Iterator[str]:
    """Yield the poses that were approached from several sides in a test that means one."""
    if stops.direction is None or len(cycles.poses) == len(DIRECTION_POSES):
        return
    came = stops.direction[cycles.rows]
    for number in cycles.poses:
        if len(np.unique(came[cycles.pose == number], axis=0)) > 1:
            yield f"P{number}"


def _commanded(cycles: Cycles, result: BlockResult) -> tuple[CommandedPose, ...]:
    """Return where a model puts the poses."""
    return tuple(CommandedPose.at(number, _predicted(cycles, result, number)) for number in cycles.poses)


def _predicted(cycles: Cycles, result: BlockResult, number: int) -> FloatArray:
    """Return the mean place that a model predicts for the visits of a pose, shape (3,)."""
    # The mean: reported joints may differ in their last digit from visit to visit, and predictions with them.
    return barycentre(result.state.position_mm[cycles.rows[cycles.pose == number]])


def _visits(points: PointReadings, cycles: Cycles, result: BlockResult) -> Visits:
    """Return what was read at the poses, turns from the orientation that a model predicts."""
    seen, turn = points.taken(cycles.rows), None
    if seen.quaternion is not None:
        wanted = result.state.orientation[cycles.rows]
        turn = vector_from_rotation(rotation_from_quaternion(seen.quaternion) @ np.swapaxes(wanted, 1, 2))
    return Visits(
        cycles.pose,
        cycles.cycle,
        seen.position_mm,
        seen.standard_uncertainty_mm,
        turn,
        None if turn is None else seen.rotation_uncertainty_rad,
    )


def _of_five(test: _Attained) -> Performance:
    """Return AP, RP, AD and RD."""
    figures = pose_performance(test.commanded, test.visits)
    return figures.joined(distance_performance(test.commanded, test.visits))


def _of_three(test: _Attained) -> Performance:
    """Return vAP."""
    rows, group, direction = test.cycles.rows, test.stops.group, test.stops.direction
    # A planned session numbers its directions; where it does not, the last motions of the joints tell them
    # apart.
    if group is not None and len(np.unique(group[rows])) == DIRECTIONS:
        came = group[rows][:, None]
    elif direction is not None:
        came = direction[rows]
    else:
        raise ConfigurationError(
            "vAP requires the direction of approach of each measurement. Give its number in the column "
            "group, or the columns dir1..."
        )
    return direction_performance(tuple(_approaches(test.visits, came)), test.cycles.poses)


def _approaches(visits: Visits, came: IntArray) -> Iterator[Visits]:
    """Yield the visits of each direction, which are other motions of the joints at each pose."""
    # Pose by pose: one direction in space takes different motions of the joints at each pose.
    ways = {number: np.unique(came[visits.pose == number], axis=0) for number in np.unique(visits.pose)}
    for place in range(max(len(way) for way in ways.values())):
        rows = [
            np.flatnonzero((visits.pose == number) & (came == way[place]).all(axis=1))
            for number, way in ways.items()
            if place < len(way)
        ]
        yield _counted_anew(visits.taken(np.concatenate(rows)))


def _counted_anew(visits: Visits) -> Visits:
    """Return visits whose cycles are counted from 1."""
    return replace(visits, cycle=visits.cycle - visits.cycle.min() + 1)


def _of_one(test: _Attained) -> Performance:
    """Return dAP and dRP."""
    return _drift(test).performance


def _drift(test: _Attained) -> Drift:
    """Return the drift of the one pose."""
    rows, group, time_s = test.cycles.rows, test.stops.group, test.stops.time_s
    if group is None or time_s is None or not np.isfinite(time_s[rows]).all():
        raise ConfigurationError(
            "Only one pose was measured repeatedly, which is a drift test. Give the columns group and "
            "time_s; for AP and RP, measure five poses."
        )
    groups = _groups(test.visits, group[rows], time_s[rows])
    return drift(test.commanded[0], sorted(groups, key=lambda one: one.time_s))


def _groups(visits: Visits, member: IntArray, time_s: FloatArray) -> Iterator[Group]:
    """Yield the groups of a drift, each with its mean time."""
    for number in np.unique(member):
        rows = np.flatnonzero(member == number)
        yield Group(float(time_s[rows].mean()), _counted_anew(visits.taken(rows)))


_TESTS: Final[dict[int, Callable[[_Attained], Performance]]] = {5: _of_five, 3: _of_three, 1: _of_one}
