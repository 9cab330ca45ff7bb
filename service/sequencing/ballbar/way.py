"""The clear way of the arm to its next stop, also where stops were left out or are visited again.

Every motion is planned from the stop listed before it. From elsewhere the arm follows the listed ways one
after the other, forwards or backwards: each of them was found clear, a shortcut was not.
"""

from collections.abc import Sequence
from itertools import pairwise

from service.domain.ballbar import BallbarStep

Joints = tuple[float, ...]


def way(moves: Sequence[BallbarStep], last_stop: str | None, to: str) -> tuple[Joints, ...]:
    """Return the joints [rad] between the stop where the last motion ended and the one named `to`.

    `moves` are all motions in listed order. From a place that no motion led to, the way is the planned one.
    """
    places = {step.id: index for index, step in enumerate(moves)}
    there = places[to]
    here = places.get(last_stop) if last_stop is not None else None
    if here is None:
        return moves[there].via_rad
    if here <= there:
        return tuple(_forwards(moves[here : there + 1]))
    return tuple(reversed(_forwards(moves[there : here + 1])))


def _forwards(moves: Sequence[BallbarStep]) -> list[Joints]:
    """Return everything strictly between the first and the last of these stops."""
    passed: list[Joints] = []
    for _, step in pairwise(moves):
        passed += [*step.via_rad, *([step.target_rad] if step.target_rad else [])]
    return passed[:-1]
