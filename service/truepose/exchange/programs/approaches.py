"""From where the targets of a program are reached, as far as straight-line code tells it."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.exchange.programs.program import Program

_STILL_RAD: Final = 1e-6  # a joint that moves less comes from neither side


def befores(program: Program) -> dict[int, set[int]]:
    """Return the targets from which each one is reached."""
    found: dict[int, set[int]] = {}
    for motion in program.motions:
        if motion.before is not None:
            found.setdefault(motion.target, set()).add(motion.before)
    return found


def approach_directions(program: Program, rows: Sequence[int], joints_rad: FloatArray) -> IntArray:
    """Return from which side joints come to targets, shape (n, J); 0 where straight-line code does not tell.

    A target that is reached from several places has no one direction.
    """
    row_of = {index: row for row, index in enumerate(rows)}
    directions = np.zeros(joints_rad.shape, dtype=np.int64)
    starts: dict[int, set[int | None]] = {}
    for motion in program.motions:
        starts.setdefault(motion.target, set()).add(motion.before)
    for target, before in starts.items():
        start = next(iter(before)) if len(before) == 1 else None
        if target in row_of and start in row_of:
            way = joints_rad[row_of[target]] - joints_rad[row_of[start]]
            directions[row_of[target]] = np.sign(np.where(np.abs(way) > _STILL_RAD, way, 0.0))
    return directions
