"""Which readings were taken at one stop of the arm, where a table does not number its stops."""

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
import numpy.typing as npt

from truepose.domain.arrays import FloatArray, IntArray
from truepose.exchange.tables.stops import NO_REPEAT, SAME_JOINTS_DEG

_SAME_DEG: Final = 1e-3  # steps in which controllers show an angle


def numbers_its_stops(config: npt.NDArray[Any] | None, joints_deg: FloatArray, ends: IntArray) -> bool:
    """Whether `config` numbers each stop once: whole numbers, one place each, no end of it read twice."""
    if config is None or config.dtype == object or not np.all(np.isfinite(config)):
        return False
    if np.any(config != np.round(config)) or np.any(config < 0):
        return False
    _, first, which = np.unique(config, return_index=True, return_inverse=True)
    away = np.abs(joints_deg - joints_deg[first[which.reshape(-1)]]).max(axis=1)
    pairs = np.unique(np.column_stack([config, ends]), axis=0)
    return bool(np.all(away <= SAME_JOINTS_DEG)) and len(pairs) == len(config)


def numbered_stops(joints_deg: FloatArray, ends: IntArray) -> tuple[FloatArray, FloatArray]:
    """Return `config` and `repeat_of` of readings in their order.

    A stop ends where the joints change, or where an end is read that this stop has already; one with the
    joints of an earlier one is a revisit of it.

    Parameters
    ----------
    joints_deg : ndarray, shape (n, J)
    ends : ndarray, shape (n,)
        What was read: the nest, or a number for each pair of ends of a length.
    """
    config, repeat_of = np.zeros(len(ends)), np.full(len(ends), float(NO_REPEAT))
    first_of: dict[tuple[float, ...], int] = {}
    stop, seen = 0, set[int]()
    for row, (joints, end) in enumerate(zip(joints_deg, ends.tolist(), strict=True)):
        moved = row == 0 or bool(np.abs(joints - joints_deg[row - 1]).max() > _SAME_DEG)
        if moved or end in seen:
            stop, seen = stop + 1, set()
        seen.add(end)
        place = tuple(np.round(joints / _SAME_DEG).tolist())
        earlier = first_of.setdefault(place, stop)
        config[row] = stop
        repeat_of[row] = NO_REPEAT if earlier == stop else earlier
    return config, repeat_of


def scatter_of_revisits_mm(
    position_mm: FloatArray, nest: IntArray, config: FloatArray, repeat_of: FloatArray
) -> float | None:
    """Return the standard deviation per axis of places measured again; None where few were."""
    place = np.where(repeat_of == NO_REPEAT, config, repeat_of)
    squares, freedom = 0.0, 0
    for rows in _groups(np.column_stack([place, nest])):
        if len(rows) > 1:
            squares += float(np.sum(np.square(position_mm[rows] - position_mm[rows].mean(axis=0))))
            freedom += 3 * (len(rows) - 1)
    return float(np.sqrt(squares / freedom)) if freedom >= _FEWEST_REVISITS else None


_FEWEST_REVISITS: Final = 15  # of three axes each


def _groups(keys: FloatArray) -> Sequence[IntArray]:
    _, which = np.unique(keys, axis=0, return_inverse=True)
    order = np.argsort(which.reshape(-1), kind="stable")
    return np.split(order, np.flatnonzero(np.diff(which.reshape(-1)[order])) + 1)
