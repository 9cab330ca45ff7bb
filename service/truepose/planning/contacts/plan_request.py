"""What is wanted of a session of closed loops, held against itself and the cell before anything is computed.

Places and directions are those that somebody states roughly; where the targets truly are is found from the
readings.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell import Cell
from truepose.domain.contacts import CENTRES, Loop, Target, TargetDistance, TargetKind
from truepose.domain.session import Role, Vector
from truepose.planning.errors import WorkSpaceError

_UP = (0.0, 0.0, 1.0)
_CANCELLED: Final = 1e-6  # of the mean of unit vectors: what is left shows no direction


@dataclass(frozen=True, slots=True)
class ContactPlanRequest:
    """Targets, what reads them, and how many stops; lengths in mm, directions of any length but none."""

    loop: Loop
    targets: tuple[Target, ...]
    stops: int
    nest: int = 1
    role: Role = "calibration"
    distances: tuple[TargetDistance, ...] = ()
    found_zeros: tuple[int, ...] = ()  # targets whose zero is rough, and found from the readings
    axis: Vector = _UP  # flange frame: where the probe points, the ball sits on its stem, the sensor looks
    stroke_mm: float = 5.0
    margin_mm: float = 1.0
    reading_u_mm: float = 0.001
    plane_mm: float = 100.0  # half the side of the square of a plane that is touched, about its place
    clearance_mm: float = 90.0  # from where nothing is near to the stop
    seed: int = 0

    @property
    def usable_mm(self) -> float:
        """How far from its zero a gauge is read [mm]: the stroke less the margin at its end."""
        return self.stroke_mm - self.margin_mm


def place_of(target: Target) -> FloatArray:
    """Return about where a target is.

    Parameters
    ----------
    target : Target

    Returns
    -------
    ndarray, shape (3,)
        [mm, world]; NaN where nobody says.
    """
    return np.array(target.place_mm if target.place_mm is not None else (np.nan,) * 3)


def normal_of(target: Target) -> FloatArray:
    """Return about the direction in which readings grow, or in which a sphere is open.

    Parameters
    ----------
    target : Target

    Returns
    -------
    ndarray, shape (3,)
        Unit vector in the world; up where nobody says.
    """
    normal = np.array(target.normal if target.normal is not None else _UP, dtype=np.float64)
    unit: FloatArray = normal / np.linalg.norm(normal)
    return unit


def mean_normal(targets: Sequence[Target]) -> FloatArray:
    """Return the mean direction in which the readings of targets grow together.

    Parameters
    ----------
    targets : sequence of Target
        Those that are read at one stop.

    Returns
    -------
    ndarray, shape (3,)
        Unit vector in the world.

    Raises
    ------
    WorkSpaceError
        Their directions cancel each other.
    """
    mean = np.mean([normal_of(target) for target in targets], axis=0)
    size = float(np.linalg.norm(mean))
    # Divided by its size, a mean that is rounding alone would point anywhere.
    if size < _CANCELLED:
        raise WorkSpaceError(
            "The normals of the targets that are read together cancel each other, so the tool has no "
            "direction of approach. Give one of them another normal."
        )
    return np.asarray(mean / size)


_READS: Final[Mapping[Loop, frozenset[TargetKind]]] = {
    "probe": frozenset({TargetKind.SPHERE, TargetKind.PLANE}),
    "gauges": frozenset({TargetKind.GAUGE}),
    "wires": frozenset({TargetKind.WIRE}),
    "sensor": frozenset({TargetKind.BALL}),
}
_WITH_ZERO: Final = frozenset({TargetKind.SPHERE, TargetKind.WIRE})
_LEAST_LENGTH: Final = 1e-3  # of a direction


def require_sense(cell: Cell, wish: ContactPlanRequest) -> None:
    """Raise, with one sentence, for the first thing that cannot be meant.

    Parameters
    ----------
    cell : Cell
    wish : ContactPlanRequest

    Raises
    ------
    WorkSpaceError
        There is no target; one is none that the loop reads, or lacks its place or zero; a sensor has not one
        ball; a direction has no length; a distance joins no two centres; the margin takes half the stroke;
        the clearance is no longer than the stroke; the nest is none of the tool's.
    """
    if not wish.targets:
        raise WorkSpaceError("There is no target to measure. Give at least one target.")
    for target in wish.targets:
        _require_target(wish, target)
    if wish.loop == "sensor" and len(wish.targets) != 1:
        raise WorkSpaceError("A sensor measures one ball. Give exactly one target.")
    _require_length(wish.axis, "The tool axis")
    _require_distances(wish)
    if not 0.0 <= wish.margin_mm < 0.5 * wish.stroke_mm:
        raise WorkSpaceError("The margin must be less than half the stroke.")
    # Wires hang on the tool all the way: nothing begins at a clearance.
    if wish.loop != "wires" and not wish.clearance_mm > wish.stroke_mm:
        raise WorkSpaceError(
            "The clearance must be greater than the stroke: the approach starts at this distance from the "
            "target."
        )
    if not 1 <= wish.nest <= len(cell.nests) or cell.nests[wish.nest - 1].centre_mm is None:
        raise WorkSpaceError(f"The cell has no tool nest {wish.nest} with a known centre.")


def _require_target(wish: ContactPlanRequest, target: Target) -> None:
    if target.kind not in _READS[wish.loop]:
        raise WorkSpaceError(
            f"Target {target.number} is a {target.kind.value}; the instrument that reads target 1 cannot "
            "read it."
        )
    if target.place_mm is None:
        raise WorkSpaceError(
            f"Target {target.number} has no position. Give its approximate mounting position."
        )
    if target.kind in _WITH_ZERO and target.zero_mm is None:
        raise WorkSpaceError(
            f"Target {target.number} has no zero_mm. Give the approximate distance at which it reads 0."
        )
    # Of a wire 0 is a length like any other: it reads from where it leaves its drum.
    if target.kind is TargetKind.SPHERE and not (target.zero_mm or 0.0) > 0.0:
        raise WorkSpaceError(
            f"zero_mm of target {target.number} must be greater than 0. Give the sum of the sphere radius "
            "and the tip radius."
        )
    if target.normal is not None:
        _require_length(target.normal, f"The normal of target {target.number}")


def _require_length(direction: Vector, what: str) -> None:
    if not np.linalg.norm(direction) > _LEAST_LENGTH:
        raise WorkSpaceError(f"{what} must not be a zero vector.")


def _require_distances(wish: ContactPlanRequest) -> None:
    centres = {target.number for target in wish.targets if target.kind in CENTRES}
    for distance in wish.distances:
        if not set(distance.targets) <= centres or len(set(distance.targets)) < len(distance.targets):
            raise WorkSpaceError(
                "A certified distance must connect the centres of two different targets in the list."
            )
