"""Straight lines of the tool, walked in steps."""

import math

import numpy as np

from truepose_simulators.physics.inverse import UnreachableError
from truepose_simulators.physics.rigid import FloatArray, from_quaternion, motion, to_quaternion

_LINE_STEP_MM = 20.0
_LONGEST_LINE_MM = 4000.0  # these arms reach less than 1.2 m to every side, tool included


def straight_line(start: FloatArray, end: FloatArray) -> list[FloatArray]:
    """Return placements on the straight line from `start` (left out) to `end`, orientation turning evenly.

    Raises UnreachableError when it is longer than any arm here.
    """
    length_mm = float(np.linalg.norm(end[:3, 3] - start[:3, 3]))
    if not length_mm <= _LONGEST_LINE_MM:
        raise UnreachableError(f"a line of {length_mm:g} mm leads out of the arm's reach")
    steps = max(1, math.ceil(length_mm / _LINE_STEP_MM))
    turn = to_quaternion(end[:3, :3] @ start[:3, :3].T)
    frames = [_between(start, end, turn, step / steps) for step in range(1, steps)]
    return [*frames, end]


def _between(start: FloatArray, end: FloatArray, turn: FloatArray, share: float) -> FloatArray:
    half = share * math.acos(min(1.0, float(turn[0])))
    sine = float(np.linalg.norm(turn[1:]))
    axis = turn[1:] / sine if sine > 0.0 else np.zeros(3)
    partial = from_quaternion(np.array([math.cos(half), *(math.sin(half) * axis)]))
    position = start[:3, 3] + share * (end[:3, 3] - start[:3, 3])
    return motion(position, partial @ start[:3, :3])
