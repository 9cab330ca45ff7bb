"""What is wanted of a session of closed loops, held against itself and the cell before anything is drawn."""

from collections.abc import Mapping
from typing import Final

import numpy as np

from truepose.domain.cell.description import Cell
from truepose.domain.measurement.contacts import Loop
from truepose.domain.measurement.session import Vector
from truepose.domain.measurement.targets import CENTRES, Target, TargetKind
from truepose.planning.contacts.wish import ContactWish
from truepose.planning.errors import WorkSpaceError

_READS: Final[Mapping[Loop, frozenset[TargetKind]]] = {
    "probe": frozenset({TargetKind.SPHERE, TargetKind.PLANE}),
    "gauges": frozenset({TargetKind.GAUGE}),
    "wires": frozenset({TargetKind.WIRE}),
    "sensor": frozenset({TargetKind.BALL}),
}
_WITH_ZERO: Final = frozenset({TargetKind.SPHERE, TargetKind.WIRE})
_LEAST_LENGTH: Final = 1e-3  # of a direction


def require_sense(cell: Cell, wish: ContactWish) -> None:
    """Raise WorkSpaceError, with one sentence, for the first thing that cannot be meant."""
    for target in wish.targets:
        _require_target(wish, target)
    if wish.loop == "sensor" and len(wish.targets) != 1:
        raise WorkSpaceError("A sensor sees one ball; give one target.")
    _require_length(wish.axis, "The axis of the tool")
    _require_distances(wish)
    if not 0.0 <= wish.margin_mm < 0.5 * wish.stroke_mm:
        raise WorkSpaceError("The margin must be less than half the stroke.")
    if not 1 <= wish.nest <= len(cell.nests) or cell.nests[wish.nest - 1].centre_mm is None:
        raise WorkSpaceError(f"The cell has no tool nest {wish.nest} with a centre.")


def _require_target(wish: ContactWish, target: Target) -> None:
    if target.kind not in _READS[wish.loop]:
        raise WorkSpaceError(
            f"Target {target.number} is a {target.kind.value}, and what reads target 1 does not read that."
        )
    if target.place_mm is None:
        raise WorkSpaceError(f"Target {target.number} has no place; say about where it will be bolted.")
    if target.kind in _WITH_ZERO and target.zero_mm is None:
        raise WorkSpaceError(f"Target {target.number} has no zero_mm; say about how far off it reads 0.")
    if target.normal is not None:
        _require_length(target.normal, f"The normal of target {target.number}")


def _require_length(direction: Vector, what: str) -> None:
    if not np.linalg.norm(direction) > _LEAST_LENGTH:
        raise WorkSpaceError(f"{what} has no length; a direction needs one.")


def _require_distances(wish: ContactWish) -> None:
    centres = {target.number for target in wish.targets if target.kind in CENTRES}
    for distance in wish.distances:
        if not set(distance.targets) <= centres or len(set(distance.targets)) < len(distance.targets):
            raise WorkSpaceError(
                "A certified distance joins the centres of two different targets of the list."
            )
