"""Whether the arm has room at stops that somebody gives: bodies above floor or table, tool off the arm.

Refused is what would touch; chosen stops keep more room than that (`work_space`).
"""

from collections.abc import Sequence
from typing import Final

import numpy as np

from truepose.domain.session import PlannedStop
from truepose.planning.work_volume.cell_bodies import CellBodies, rooms

_AT_ONCE: Final = 2000  # configurations; keeps the arrays small


def what_is_in_the_way(
    bodies: CellBodies,
    stops: Sequence[PlannedStop],
    approach_offset_rad: float | None,
    *,
    floor_only: bool = False,
) -> str | None:
    """Return one sentence for the first stop, or approach to one, at which something would touch."""
    offsets = {"The stop at": 0.0}
    if approach_offset_rad is not None:
        offsets["The approach to"] = approach_offset_rad
    for first in range(0, len(stops), _AT_ONCE):
        some = stops[first : first + _AT_ONCE]
        joints = np.array([stop.joints_rad for stop in some])
        found = {what: rooms(bodies, joints + by, floor_only=floor_only) for what, by in offsets.items()}
        touching = np.array([each.least_mm() < 0.0 for each in found.values()])
        if touching.any():
            row = int(np.argmax(touching.any(axis=0)))
            what = list(found)[int(np.argmax(touching[:, row]))]
            return f"{what} configuration {some[row].config} cannot be: {found[what].what_touches(row)}."
    return None
