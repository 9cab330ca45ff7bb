"""What is wanted of a session of closed loops."""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.contacts import Loop, TargetDistance
from truepose.domain.measurement.session import Role, Vector
from truepose.domain.measurement.targets import Target

_UP = (0.0, 0.0, 1.0)


@dataclass(frozen=True, slots=True)
class ContactWish:
    """Targets, what reads them, and how many stops."""

    loop: Loop
    targets: tuple[Target, ...]
    stops: int
    nest: int = 1
    role: Role = "calibration"
    distances: tuple[TargetDistance, ...] = ()
    found_zeros: tuple[int, ...] = ()  # targets whose zero is rough, and found from the readings
    axis: Vector = _UP  # last frame: where the probe points, the ball sits on its stem, the sensor looks
    stroke_mm: float = 5.0
    margin_mm: float = 1.0
    reading_u_mm: float = 0.001
    plane_mm: float = 100.0  # half the side of the square of a plane that is touched, about its place
    clearance_mm: float = 90.0  # from where nothing is near to the stop
    seed: int = 0

    @property
    def usable_mm(self) -> float:
        """How far from its zero a gauge is read."""
        return self.stroke_mm - self.margin_mm


def place_of(target: Target) -> FloatArray:
    """Return about where a target is [mm, world], shape (3,)."""
    return np.array(target.place_mm if target.place_mm is not None else (np.nan,) * 3)


def normal_of(target: Target) -> FloatArray:
    """Return about the direction in which readings grow, or in which a sphere is open, shape (3,)."""
    normal = np.array(target.normal if target.normal is not None else _UP, dtype=np.float64)
    unit: FloatArray = normal / np.linalg.norm(normal)
    return unit
