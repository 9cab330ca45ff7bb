"""Orders of stops whose straight joint motions keep off the table.

Two stops that are clear of the table say nothing of the straight joint motion between them: a tenth of such
ways dips below it. Who chooses the stops also chooses their order, so an order is found that avoids them.

Looked at are points with room about them: that keeps more room than bodies that just do not touch. Points
know the table only (`path_repair` knows the rest).
"""

from collections.abc import Iterator
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.planning.workspace.space import WorkSpace, heights_above_table_mm

_LOOKS: Final = 25  # along a way; a joint turns by some degrees between two of them
_ROOM_MM: Final = 60.0  # what stops keep: bodies round the points, and what lies between two looks
_ROWS_AT_ONCE: Final = 40  # stops that are tried together as the next one
_EXCHANGES: Final = 100  # places that a stop is tried at in exchange
_FEWEST: Final = 3  # stops of which one can stand between two others


def clear_order(space: WorkSpace, joints_rad: FloatArray, start_rad: FloatArray | None = None) -> IntArray:
    """Return the given order, changed as little as it takes to keep every way off the table.

    Parameters
    ----------
    space : WorkSpace
    joints_rad : ndarray, shape (n, J)
        Stops in the order that is wanted.
    start_rad : ndarray, shape (J,), optional
        Where the arm comes from; None: nobody knows.

    Returns
    -------
    ndarray, shape (n,)
        Indices. Where no order is clear the ways that are not come last, the highest first.
    """
    if not len(joints_rad):
        return np.zeros(0, dtype=np.int64)
    stops = joints_rad if start_rad is None else np.vstack([start_rad, joints_rad])
    left = list(range(1, len(stops)))
    order = [0]
    while left:
        order.append(_next(space, stops[order[-1]], stops, left))
        left.remove(order[-1])
    # Taking the next clear one leaves the ways that are not for the end, where there is no choice left.
    mended = _mended(space, stops, order, fixed=start_rad is not None)
    return mended if start_rad is None else mended[1:] - 1


def room_mm(space: WorkSpace, starts_rad: FloatArray, ends_rad: FloatArray) -> FloatArray:
    """Return the least height above the table on straight joint ways to the approaches of stops.

    Parameters
    ----------
    space : WorkSpace
    starts_rad, ends_rad : ndarray, shape (n, J)
        Stops; each way ends where the approach of the second begins.

    Returns
    -------
    ndarray, shape (n,)
        [mm], of points, without room for the bodies about them.
    """
    share = np.linspace(0.0, 1.0, _LOOKS)[None, :, None]
    approach = ends_rad + (space.approach_offset_rad or 0.0)
    way = starts_rad[:, None] + share * (approach - starts_rad)[:, None]
    heights = heights_above_table_mm(space, way.reshape(-1, way.shape[-1]))
    return np.asarray(heights.reshape(len(starts_rad), _LOOKS).min(axis=1))


def _next(space: WorkSpace, here: FloatArray, joints_rad: FloatArray, left: list[int]) -> int:
    """Return the first of what is left to which the way is clear, else the one whose way is highest."""
    best, highest_mm = left[0], -np.inf
    # The one that is wanted by itself first: nine of ten ways are clear.
    for first, last in ((0, 1), *((k, k + _ROWS_AT_ONCE) for k in range(1, len(left), _ROWS_AT_ONCE))):
        some = left[first:last]
        rooms = room_mm(space, np.broadcast_to(here, joints_rad[some].shape), joints_rad[some])
        clear = np.flatnonzero(rooms >= _ROOM_MM)
        if clear.size:
            return some[int(clear[0])]
        if rooms.max() > highest_mm:
            best, highest_mm = some[int(np.argmax(rooms))], float(rooms.max())
    return best


def _mended(space: WorkSpace, joints_rad: FloatArray, order: list[int], *, fixed: bool) -> IntArray:
    """Move or exchange stops whose way is not clear, as long as that leaves fewer such ways.

    With `fixed` the first one stays where it is.
    """
    while blocked := _blocked(space, joints_rad, order):
        # Either end of a blocked way may be what is out of place.
        places = dict.fromkeys(place for end in blocked for place in (end, end - 1))
        tried = (
            changed
            for at in places
            if not (fixed and at == 0)
            for changed in _reordered(space, joints_rad, order, at, fixed=fixed)
        )
        better = (other for other in tried if len(_blocked(space, joints_rad, other)) < len(blocked))
        mended = next(better, None)
        if mended is None:
            break
        order = mended
    return np.array(order, dtype=np.int64)


def _reordered(
    space: WorkSpace, joints_rad: FloatArray, order: list[int], at: int, *, fixed: bool
) -> Iterator[list[int]]:
    """Yield the order with one stop at its best place elsewhere, then exchanged with others."""
    yield _reinserted(space, joints_rad, order, at, fixed=fixed)
    for other in range(int(fixed), min(len(order), _EXCHANGES)):
        exchanged = [*order]
        exchanged[at], exchanged[other] = order[other], order[at]
        yield exchanged


def _reinserted(
    space: WorkSpace, joints_rad: FloatArray, order: list[int], at: int, *, fixed: bool
) -> list[int]:
    """Return the order with one stop where the ways to it and from it are highest."""
    stop, others = order[at], order[:at] + order[at + 1 :]
    here = np.broadcast_to(joints_rad[stop], (len(others), joints_rad.shape[1]))
    to, onward = room_mm(space, joints_rad[others], here), room_mm(space, here, joints_rad[others])
    # before the first there is only a way onward, behind the last only one that leads there
    first = [-np.inf] if fixed else onward[:1]
    place = int(np.argmax(np.concatenate([first, np.minimum(to[:-1], onward[1:]), to[-1:]])))
    return [*others[:place], stop, *others[place:]]


def _blocked(space: WorkSpace, joints_rad: FloatArray, order: list[int]) -> list[int]:
    """Return the places in an order to which the way before is not clear."""
    if len(order) < _FEWEST:
        return []
    rooms = room_mm(space, joints_rad[order[:-1]], joints_rad[order[1:]])
    return [int(at) + 1 for at in np.flatnonzero(rooms < _ROOM_MM)]
