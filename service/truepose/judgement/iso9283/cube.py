"""The cube that five poses were taken from, ISO 9283:1998, 6.8: whether there is one, and how large it is."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.judgement.iso9283.visits import CommandedPose

_DIAGONAL: Final = 0.80  # of that of the cube: P2 to P4, P3 to P5
_OFF: Final = 0.04  # of the diagonal; P2 to P5 may be 0.08 to 0.12 of it away from the corners


@dataclass(frozen=True, slots=True)
class FoundCube:
    """By the commanded poses, in the frame of the readings."""

    edge_mm: float
    centre_mm: tuple[float, float, float]


def cube_of(commanded: Sequence[CommandedPose]) -> FoundCube | None:
    """Return the cube in whose diagonal plane P1 to P5 lie; None where they lie otherwise.

    The sides of their rectangle are 0.8 of an edge and of a diagonal of a face. How the cube is turned does
    not matter: the frame of the readings need not be the base.
    """
    places = {pose.number: np.array(pose.position_mm) for pose in commanded}
    if set(places) != {1, 2, 3, 4, 5}:
        return None
    diagonals = [float(np.linalg.norm(places[a] - places[b])) for a, b in ((2, 4), (3, 5))]
    edge_mm = float(np.mean(diagonals)) / (_DIAGONAL * np.sqrt(3.0))
    sides = [float(np.linalg.norm(places[a] - places[b])) for a, b in ((2, 3), (4, 5), (3, 4), (5, 2))]
    wanted = _DIAGONAL * edge_mm * np.sqrt([1.0, 1.0, 2.0, 2.0])
    middle = np.mean([places[number] for number in (2, 3, 4, 5)], axis=0)
    off = [*np.abs(np.sort(sides) - wanted), np.ptp(diagonals), np.linalg.norm(places[1] - middle)]
    if max(off) > _OFF * edge_mm * np.sqrt(3.0):
        return None
    x, y, z = (float(value) for value in places[1])
    return FoundCube(edge_mm, (x, y, z))
