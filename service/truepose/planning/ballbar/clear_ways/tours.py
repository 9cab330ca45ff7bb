"""The order of stops: each the nearest that a clear way leads to."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.planning.ballbar.clear_ways.short_moves import Stop, Surroundings
from truepose.planning.ballbar.clear_ways.ways import way
from truepose.planning.errors import NoWayError

Via: TypeAlias = tuple[tuple[float, ...], ...]

_TRIES: Final = 3  # stops to which a way is searched before they are given up


@dataclass(frozen=True, slots=True)
class Tour:
    """Stops in their order, each with the way from the one before."""

    order: tuple[int, ...]
    vias: tuple[Via, ...]
    missed: tuple[int, ...]  # stops to which no clear way was found


def tour(
    around: Surroundings,
    joints_rad: FloatArray,
    groups: Sequence[Sequence[int]],
    here: Stop,
    rng: np.random.Generator,
) -> Tour:
    """Order stops by short motions, group after group, with the ways to them.

    Parameters
    ----------
    around : Surroundings
    joints_rad : ndarray, shape (n, J)
    groups : sequences of rows of `joints_rad`
        Those of one group are all visited before the next group.
    here : Stop
        Where the arm is.
    rng : numpy.random.Generator
        For the search for ways.
    """
    order: list[int] = []
    vias: list[Via] = []
    missed: list[int] = []
    for group in groups:
        left = list(group)
        while left:
            nearest = sorted(left, key=lambda row: _motion(joints_rad[row], here))[:_TRIES]
            found = _first_way(around, joints_rad, nearest, here, rng)
            if found is None:
                missed += nearest
                left = [row for row in left if row not in nearest]
                continue
            row, via = found
            left.remove(row)
            order.append(row)
            vias.append(via)
            here = Stop(joints_rad[row])
    return Tour(tuple(order), tuple(vias), tuple(missed))


def _motion(joints: FloatArray, here: Stop) -> float:
    return float(np.max(np.abs(joints - here.joints_rad)))


def _first_way(
    around: Surroundings, joints: FloatArray, rows: Sequence[int], here: Stop, rng: np.random.Generator
) -> tuple[int, Via] | None:
    for row in rows:
        try:
            return row, way(around, here, Stop(joints[row]), rng)
        except NoWayError:
            continue
    return None
