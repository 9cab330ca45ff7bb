"""Whether the arm has room at stops that somebody gives: bodies above floor or table, tool off the arm.

Refused is what would touch; chosen stops keep more room than that (`work_space`).
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.measurement.session import PlaceOf, PlannedStop
from truepose.planning.work_volume.cell_bodies import CellBodies, rooms

THE: Final[dict[PlaceOf, str]] = {
    "work": "The work before",
    "approach": "The approach to",
    "stop": "The stop at",
}
_AT_ONCE: Final = 2000  # configurations; keeps the arrays small


def what_is_in_the_way(
    bodies: CellBodies,
    stops: Sequence[PlannedStop],
    approach_offset_rad: float | None,
    *,
    floor_only: bool = False,
) -> str | None:
    """Return one sentence for the first place on the way, or stop, at which something would touch."""
    places = [(stop.config, *place) for stop in stops for place in stop.places(approach_offset_rad)]
    for first in range(0, len(places), _AT_ONCE):
        some = places[first : first + _AT_ONCE]
        found = rooms(bodies, np.array([place_rad for _, _, place_rad in some]), floor_only=floor_only)
        touching = found.least_mm() < 0.0
        if touching.any():
            row = int(np.argmax(touching))
            config, what, _ = some[row]
            return f"{THE[what]} configuration {config} cannot be: {found.what_touches(row)}."
    return None
