"""The order of stops: each the nearest that a clear way leads to."""

from collections.abc import Sequence
from typing import Final, TypeAlias

import numpy as np

from service.domain.arrays import FloatArray
from service.planning.ballbar.motions import Stop, Surroundings
from service.planning.ballbar.ways import way
from service.planning.errors import NoWayError

Via: TypeAlias = tuple[tuple[float, ...], ...]

_TRIES: Final = 3  # stops to which a way is searched before it is given up


def tour(
    around: Surroundings,
    joints_rad: FloatArray,
    groups: Sequence[Sequence[int]],
    here: Stop,
    rng: np.random.Generator,
) -> tuple[list[int], list[Via]]:
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

    Returns
    -------
    order : list of int
        Rows in their order.
    vias : list of via points
        The way to each from the one before.

    Raises
    ------
    NoWayError
        From a stop no clear way leads on.
    """
    order: list[int] = []
    vias: list[Via] = []
    for group in groups:
        left = list(group)
        while left:
            row, via = _next(around, joints_rad, left, here, rng)
            left.remove(row)
            order.append(row)
            vias.append(via)
            here = Stop(joints_rad[row])
    return order, vias


def _next(
    around: Surroundings, joints: FloatArray, left: list[int], here: Stop, rng: np.random.Generator
) -> tuple[int, Via]:
    nearest = sorted(left, key=lambda row: float(np.max(np.abs(joints[row] - here.joints_rad))))
    for row in nearest[:_TRIES]:
        try:
            return row, way(around, here, Stop(joints[row]), rng)
        except NoWayError:
            continue
    raise NoWayError(
        f"From one stop of placement {around.fixture.number} no clear way leads on: move the base fixture a "
        "little, or ask for fewer poses."
    )
