"""Errors of the instrument's own angles: its circles run out of true.

A point at s + l d, d the direction of the beam, is read turned about the place s of the instrument: by its
error in azimuth about the vertical, by that in elevation about the level axis (sin a, -cos a, 0).

    turn w = e(a) (0, 0, 1)  or  e(b) (sin a, -cos a, 0),     e(x) = p_s sin(n x) + p_c cos(n x)
    p is read at  p + w x (p - s):  a shift -w x s and a turn w about the world's origin

a the azimuth, b the elevation; n = 1 is an eccentric circle, n = 2 an oval one. Both signs hold for an
instrument that stands upright in the world.
"""

from collections.abc import Callable

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.causes import Scene
from truepose.effects.ports import Port, PortKind, Rows
from truepose.effects.unclassified.kinds import ALONE, Key, Kind, Moves, Part, Place, Size, Variants, once
from truepose.effects.waves import periods
from truepose.kinematics.frames import cross
from truepose.messages.message import Message, message

_WIDTH_RAD = 5e-5  # belief: five times what makers of trackers state
_WAVE = (Part("sin", "rad", _WIDTH_RAD), Part("cos", "rad", _WIDTH_RAD))


def _sights(rows: Rows) -> tuple[FloatArray, FloatArray]:
    """Return azimuth and elevation of each row as the instrument sees it, shape (n,) each [rad].

    Zeros where its place, or what it looks at, is not known.
    """
    if rows.sighted_mm is None or rows.instrument_mm is None:
        return np.zeros(len(rows.stops)), np.zeros(len(rows.stops))
    x, y, z = (rows.sighted_mm - rows.instrument_mm).T
    return np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))


def _wave(key: Key, angle_rad: FloatArray) -> FloatArray:
    wave = np.sin if key.part == "sin" else np.cos
    return np.asarray(wave(float(key.variant) * angle_rad))


def _turned(rows: Rows, turn: FloatArray) -> Moves:
    """Turn what is read about the instrument's place by small vectors, on the instrument's six ports.

    Parameters
    ----------
    rows : Rows
        n of them.
    turn : ndarray, shape (n, 3)
        [rad] per unit of the parameter.
    """
    if rows.instrument_mm is None:
        return []
    # The ports turn about the world's origin; the shift brings the instrument's own place back to where it
    # was.
    shift = -cross(turn, np.broadcast_to(rows.instrument_mm, turn.shape))
    six = np.concatenate([shift, turn], axis=1)
    return [(Port(PortKind.INSTRUMENT, component), six[:, component]) for component in range(6)]


def _azimuth_errs(key: Key, rows: Rows) -> Moves:
    azimuth, _ = _sights(rows)
    return _turned(rows, _wave(key, azimuth)[:, None] * np.array([0.0, 0.0, 1.0]))


def _elevation_errs(key: Key, rows: Rows) -> Moves:
    azimuth, elevation = _sights(rows)
    level = np.stack([np.sin(azimuth), -np.cos(azimuth), np.zeros_like(azimuth)], axis=1)
    return _turned(rows, _wave(key, elevation)[:, None] * level)


def _instrument(scene: Scene) -> list[Place]:
    # Without its place nobody knows under which angles the instrument saw a point.
    return [] if scene.legs or scene.instrument_mm is None else [ALONE]


def _orders(_scene: Scene) -> Variants:
    return [("1", 1.0), ("2", 2.0)]


def _of(angle: str) -> Callable[[Key, Size, Scene], Message]:
    def sentence(key: Key, size: Size, _scene: Scene) -> Message:
        order = periods(float(key.variant))
        return message("causes.circle", angle=angle, periods=order, amplitude_deg=size.amplitude)

    return sentence


KINDS = (
    Kind(
        "azimuth", "wave", _WAVE, once("tracker"), once("azimuth"),
        _instrument, _orders, _azimuth_errs, _of("azimuth"), ("order", "1"),
    ),
    Kind(
        "elevation", "wave", _WAVE, once("tracker"), once("elevation"),
        _instrument, _orders, _elevation_errs, _of("elevation"), ("order", "1"),
    ),
)  # fmt: skip
