"""Targets of contacts: spheres, wires, planes, gauges, balls and faces, each with its start and slope.

A sphere that a probe or gauge touches, and a point where a wire ends: distances from a centre. With the nest
at P, the centre at C and the distance z at which the instrument reads 0,

    reading = |P - C| - z

Source: thesis of A. Nubiola, 2014, sections 1.2 (a sphere as constraint) and 1.8 (CompuGauge, wires to the
tool; MasterCal, a probe and two spheres).

A plane that a probe touches, and a fixed gauge whose flat face a ball pushes: distances along a normal. With
the nest at P, a point Q of the plane and its normal n, tilted by slopes a and b about a start n0,

    reading = n . (P - Q) - s,    n = (n0 + a t1 + b t2) / |n0 + a t1 + b t2|

with t1 and t2 across n0, and s the shift of the plane, in which the gauge's zero is. A gauge of a flat face
reads the same: its face is the plane, its axis the normal.

Source: H. Zhuang, S. H. Motaghedi, Z. S. Roth, Robot calibration with planar constraints, ICRA 1999 (one
plane is seldom enough, three are as good as points); three perpendicular gauges: future work of the thesis of
A. Nubiola, 2014.

A plane that a sensor or gauge in the tool reads along its own axis. With the nest at P, from which readings
count, its axis a, which the tool carries, and a plane as above,

    reading = -h / (n . a),    h = n . (P - Q) - s

Source: the axis from P meets the plane at P + reading a.

A fixed ball that sensors in the tool look at: its place in their frame, one axis a reading. With the sensor
at P, its axis a (a unit vector that the tool carries) and the ball at C,

    reading = a . (C - P)

Where the sensor sits in the tool is its nest, how it is turned the rotation of the tool.

Source: ROSY and LaserLAB as the thesis of A. Nubiola, 2014, describes them in section 1.8; three gauges that
the tool carries to fixed balls: C. Icli, O. Stepanenko, I. Bonev, Sensors 20, 2020, 5919.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Final, Protocol

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, Table
from truepose.domain.contacts import Target, TargetKind
from truepose.effects.ports import ParameterSpec

PLACE_WIDTH_MM = 10.0  # about the start found from the data, as for an unknown base


@dataclass(frozen=True, slots=True)
class Probe(Table):
    """Where the tool was at n readings, world frame.

    Attributes
    ----------
    place_mm : ndarray, shape (n, 3)
        Of its nest.
    along : ndarray, shape (n, 3)
        Unit vector of the sensor's axis; zeros of a reading that has none.
    """

    place_mm: FloatArray
    along: FloatArray


@dataclass(frozen=True, slots=True)
class Slope:
    """How n predicted readings change.

    Attributes
    ----------
    place : ndarray, shape (n, 3)
        Per mm of the tool nest [1], axes of the world.
    turn : ndarray, shape (n, 3)
        Per rad of the tool about its nest [mm], axes of the world.
    own : ndarray, shape (p, n)
        Per unit of the target's own parameters [mm].
    """

    place: FloatArray
    turn: FloatArray
    own: FloatArray


class TargetModel(Protocol):
    """A kind of target; `values` (p,) are those of its parameters, in their order."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return the parameters of a target about the values where it was found."""
        ...

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return what is read.

        Parameters
        ----------
        target : Target
        values : ndarray, shape (p,)
        probe : Probe
            At n readings.

        Returns
        -------
        ndarray, shape (n,)
            [mm]
        """
        ...

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return how what is read changes; parameters as of `reading_mm`."""
        ...

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the target where readings of a nominal robot put it.

        Parameters
        ----------
        target : Target
            With what was stated of its place, normal or zero.
        probe : Probe
            Where the nominal robot had the tool at n readings.
        reading_mm : ndarray, shape (n,)

        Returns
        -------
        target : Target
            About what its parameters count from.
        values : ndarray, shape (p,)
            To start from.
        """
        ...

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return the same target, and values (p,), about where these values put it."""
        ...


def sensor_axes(end_rotation: FloatArray, axis: IntArray) -> FloatArray:
    """Return the axis of the sensor of each reading, shape (n, 3); zeros where it has none.

    Parameters
    ----------
    end_rotation : ndarray, shape (n, 3, 3)
        Orientation of the tool.
    axis : ndarray, shape (n,)
        0 to 2, or NO_AXIS.
    """
    along = end_rotation[np.arange(len(axis)), :, np.maximum(axis, 0)]
    return np.where((axis >= 0)[:, None], along, 0.0)


# Readings that vary more than this are lengths of their own, which the distance can be told from.
_LONG_MM = 20.0


class Centre:
    """The centre of a sphere or of a wire's end; the zero too where it is not exact."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return the coordinates of the centre in the world, and the distance that reads 0."""
        at = dict(zip(("x", "y", "z", "zero"), values.tolist(), strict=False))
        # A zero with a certificate is held by it; one that nobody stated has the prior of a place.
        zero = target.zero_mm
        known = zero is not None
        told = {"zero": zero} if zero is not None else {}
        width = {"zero": target.zero_uncertainty_mm} if known else {}
        return tuple(
            ParameterSpec(name, "mm", told.get(name, start), width.get(name, PLACE_WIDTH_MM))
            for name, start in at.items()
        )

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return |P - C| - z, the distances from the centre less the zero [mm], shape (n,)."""
        return np.asarray(np.linalg.norm(probe.place_mm - values[:3], axis=1) - _zero(target, values))

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return the directions away from the centre, their opposites for the centre, -1 for the zero [1]."""
        arm = probe.place_mm - values[:3]
        away = arm / np.linalg.norm(arm, axis=1)[:, None]
        own = -away.T if len(values) == 3 else np.vstack([-away.T, np.full(len(arm), -1.0)])
        return Slope(away, np.zeros_like(away), own)

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the centre from equations that are linear in it once its own square is an unknown."""
        places = probe.place_mm
        if target.place_mm is not None:
            centre = np.array(target.place_mm)
        elif target.zero_mm is not None:
            centre = _trilaterated(places, reading_mm + target.zero_mm)
        # A draw wire: its length varies enough to tell the zero with the centre.
        elif np.std(reading_mm) > _LONG_MM:
            centre = _trilaterated(places, reading_mm, with_zero=True)
        else:
            # Readings that hardly vary tell nothing of the zero: the places are on a sphere, whatever its
            # radius.
            centre = _trilaterated(places, np.zeros(len(places)))
        away = float(np.median(np.linalg.norm(places - centre, axis=1) - reading_mm))
        zero = away if target.zero_mm is None else target.zero_mm
        return target, np.append(centre, zero) if _has_zero(target) else centre

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return it as it is: coordinates count from the world."""
        return target, values


def _has_zero(target: Target) -> bool:
    return target.zero_mm is None or target.zero_uncertainty_mm > 0.0


def _zero(target: Target, values: FloatArray) -> float:
    return float(values[3]) if len(values) > 3 else target.zero_mm or 0.0


def _trilaterated(places: FloatArray, length_mm: FloatArray, *, with_zero: bool = False) -> FloatArray:
    """Solve 2 P.C + 2 l z + (z^2 - |C|^2) = |P|^2 - l^2 for the centre; without zero, z = 0 in it."""
    # From the middle of the places: squares of coordinates metres away would cost digits.
    middle = places.mean(axis=0)
    off = places - middle
    columns = [2.0 * off, np.ones((len(off), 1))]
    if with_zero:
        columns.append(2.0 * length_mm[:, None])
    right = (off**2).sum(axis=1) - length_mm**2
    return np.asarray(middle + np.linalg.lstsq(np.hstack(columns), right, rcond=1e-9)[0][:3])


# A gauge of a few millimetres' travel finds its direction to some degrees from a nominal robot's places.
_SLOPE_WIDTH = 0.3


class Plane:
    """Shift and two slopes of a plane about where it was found."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return the shift along the normal, and two slopes."""
        shift, first, second = values.tolist()
        return (
            ParameterSpec("shift", "mm", shift, PLACE_WIDTH_MM),
            ParameterSpec("slope1", "1", first, _SLOPE_WIDTH),
            ParameterSpec("slope2", "1", second, _SLOPE_WIDTH),
        )

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return n . (P - Q) - s, the distances from the plane [mm], shape (n,)."""
        normal, _ = tilted(target, values)
        return np.asarray((probe.place_mm - point_of(target)) @ normal - values[0])

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return the normal [1], and what tilting it does [mm per unit of slope]; -1 for the shift."""
        normal, across = tilted(target, values)
        arm = probe.place_mm - point_of(target)
        own = np.vstack([np.full(len(arm), -1.0), across @ arm.T])
        place = np.broadcast_to(normal, arm.shape)
        return Slope(place, np.zeros_like(arm), own)

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the plane through the middle of the places; its normal is the one that fits best."""
        middle = np.median(probe.place_mm, axis=0)
        off = probe.place_mm - middle
        told = target.normal
        normal = _best_normal(off, reading_mm) if told is None else np.array(told) / np.linalg.norm(told)
        x, y, z = middle.tolist()
        nx, ny, nz = normal.tolist()
        # A median: a probe that missed the plane at one stop must not shift where the search begins.
        shift = float(np.median(off @ normal - reading_mm))
        return replace(target, place_mm=(x, y, z), normal=(nx, ny, nz)), np.array([shift, 0.0, 0.0])

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return it about the normal as it is tilted."""
        # Slopes count from the normal that was found: a prior about a rough start would pull it back.
        nx, ny, nz = tilted(target, values)[0].tolist()
        return replace(target, normal=(nx, ny, nz)), np.array([values[0], 0.0, 0.0])


def point_of(target: Target) -> FloatArray:
    """Return the point that a plane's shift counts from, shape (3,) [mm, world frame]."""
    return np.zeros(3) if target.place_mm is None else np.array(target.place_mm)


def tilted(target: Target, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return the normal of a plane and how it changes.

    Parameters
    ----------
    target : Target
        With the normal that its slopes start from.
    values : ndarray, shape (3,)
        Shift [mm] and two slopes [1].

    Returns
    -------
    normal : ndarray, shape (3,)
        Unit vector in the world, n as above.
    across : ndarray, shape (2, 3)
        Its change per unit of each slope.
    """
    start = np.array([0.0, 0.0, 1.0]) if target.normal is None else np.array(target.normal)
    start = start / np.linalg.norm(start)
    # The axis that the normal is least along is never parallel to it.
    beside = np.eye(3)[int(np.argmin(np.abs(start)))]
    first = np.cross(beside, start)
    first /= np.linalg.norm(first)
    axes = np.stack([first, np.cross(start, first)])
    tilted = start + values[1:3] @ axes
    # A unit vector again, or a tilted plane would read too long.
    length = float(np.linalg.norm(tilted))
    normal = tilted / length
    return normal, (axes - np.outer(axes @ normal, normal)) / length


def _best_normal(off_mm: FloatArray, reading_mm: FloatArray) -> FloatArray:
    """Return the direction along which places (n, 3) vary as the readings do.

    Readings that hardly vary say that the places lie in the plane; those of a gauge grow along its axis.
    """
    flattest = np.linalg.svd(off_mm - off_mm.mean(axis=0), full_matrices=False)[2][-1]
    design = np.column_stack([off_mm, np.ones(len(off_mm))])
    growing = np.linalg.lstsq(design, reading_mm, rcond=1e-9)[0][:3]
    # A plane has two sides; readings grow towards one of them.
    candidates = [flattest, -flattest]
    if np.linalg.norm(growing) > 0.0:
        candidates.append(growing / np.linalg.norm(growing))

    def spread(normal: FloatArray) -> float:
        left = off_mm @ normal - reading_mm
        return float(np.median(np.abs(left - np.median(left))))

    return min(candidates, key=spread)


class Face(Plane):
    """Shift and two slopes of a plane that is read askew."""

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return -h / (n . a), the distances along the axes [mm], shape (n,)."""
        normal, _ = tilted(target, values)
        return -super().reading_mm(target, values, probe) / (probe.along @ normal)

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return what moving does, what turning the axis does, and what tilting the plane does."""
        normal, across = tilted(target, values)
        arm = probe.place_mm - point_of(target)
        facing = probe.along @ normal
        reading = self.reading_mm(target, values, probe)
        # A tool that turns by w swings the axis by w x a; the reading changes with n . a alone.
        turn = -(reading / facing)[:, None] * np.cross(probe.along, normal)
        tilts = -(across @ arm.T + reading * (across @ probe.along.T)) / facing
        return Slope(-normal / facing[:, None], turn, np.vstack([1.0 / facing, tilts]))

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the plane through the points that were met."""
        met = probe.place_mm + reading_mm[:, None] * probe.along
        return super().started(target, Probe(met, probe.along), np.zeros_like(reading_mm))


class BallPlace:
    """The place of a ball."""

    def parameters(self, target: Target, values: FloatArray) -> tuple[ParameterSpec, ...]:
        """Return its coordinates in the world."""
        return tuple(
            ParameterSpec(axis, "mm", start, PLACE_WIDTH_MM)
            for axis, start in zip("xyz", values.tolist(), strict=True)
        )

    def reading_mm(self, target: Target, values: FloatArray, probe: Probe) -> FloatArray:
        """Return a . (C - P), how far the ball is along the axis [mm], shape (n,)."""
        return np.asarray(((values - probe.place_mm) * probe.along).sum(axis=1))

    def slope(self, target: Target, values: FloatArray, probe: Probe) -> Slope:
        """Return the axes; a tool that turns by w turns them by w x a."""
        turned = np.cross(probe.along, values - probe.place_mm)
        return Slope(-probe.along, turned, probe.along.T)

    def started(self, target: Target, probe: Probe, reading_mm: FloatArray) -> tuple[Target, FloatArray]:
        """Return the place that the axes meet in."""
        if target.place_mm is not None:
            return target, np.array(target.place_mm)
        # Each reading says in which plane across its axis the ball is.
        right = (probe.place_mm * probe.along).sum(axis=1) + reading_mm
        return target, np.linalg.lstsq(probe.along, right, rcond=1e-9)[0]

    def centred(self, target: Target, values: FloatArray) -> tuple[Target, FloatArray]:
        """Return it as it is: coordinates count from the world."""
        return target, values


# A further kind is a class and a line here (docs/decisions/0048).
KINDS: Final[Mapping[TargetKind, TargetModel]] = {
    TargetKind.SPHERE: Centre(),
    TargetKind.WIRE: Centre(),
    TargetKind.PLANE: Plane(),
    TargetKind.GAUGE: Plane(),
    TargetKind.BALL: BallPlace(),
    TargetKind.FACE: Face(),
}
