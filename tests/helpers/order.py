"""In which order files of tests run beside each other."""

from collections.abc import Mapping, Sequence
from typing import Final, TypeVar

# Files that wait more than they compute, files that do both, and short files, which fill what time is left.
_WAITING: Final = "browser"
_SHORT: Final = "unit"

_T = TypeVar("_T")


def spread(files: Sequence[str]) -> Mapping[str, float]:
    """Return the rank of each file, by which waiting ones lie evenly among those that compute.

    Files are named by their paths from the folder of the tests. One after the other, those that wait for a
    browser would leave the cores idle, and then there would be nothing left to do beside the others.
    """
    rooms: dict[str, list[str]] = {_WAITING: [], _SHORT: [], "": []}
    for file in files:
        room = file.split("/")[0]
        rooms[room if room in rooms else ""].append(file)
    shares = {file: (k + 0.5) / len(room) for room in rooms.values() for k, file in enumerate(room)}
    return {file: share + (file in rooms[_SHORT]) for file, share in shares.items()}


def turned(children: Sequence[_T], share: float) -> list[_T]:
    """Return what a folder holds, beginning after this share of it and ending before it."""
    first = int(share * len(children))
    return [*children[first:], *children[:first]]
