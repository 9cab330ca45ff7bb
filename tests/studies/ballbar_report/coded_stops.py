"""Stops of the arm at which a person connects six legs, and what makes their lengths uncertain."""

from dataclasses import dataclass
from itertools import product
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.ballbar import Leg, PoseForecast
from truepose.kinematics.frames import rotation_from_vector
from truepose.kinematics.pose_device import (
    Assembly,
    Fixtures,
    Pose,
    assemblies,
    foreseen,
    least_squares_pose,
    linear_legs,
    measurable,
)

READING_U_MM: Final = 0.00051  # of a QC20-W, thesis section 3.5
ZERO_U_MM: Final = 0.0015  # from one magnetic snap to the next
CODES_MM: Final[FloatArray] = np.arange(6, dtype=np.float64) * 0.28 - 0.7
_ZERO_BOUND_MM: Final = 0.003  # snaps and handling together add no more, thesis section 3.5
_NOMINAL_MM: Final = 300.0
_LEVER_MM: Final = 200.0  # makes a turn of the tool worth a shift


@dataclass(slots=True)
class CodedStop:
    """One stop: what is asked for, what is foreseen, and what is true."""

    legs: tuple[Leg, ...]
    forecast: PoseForecast
    true_mm: dict[Leg, float]
    rng: np.random.Generator
    zero_mm: float = 0.0

    def read(self, leg: Leg) -> float:
        """Snap the ballbar between two balls and read it."""
        walked = self.zero_mm + self.rng.normal(0.0, ZERO_U_MM)
        self.zero_mm = float(np.clip(walked, -_ZERO_BOUND_MM, _ZERO_BOUND_MM))
        return self.true_mm[leg] + self.zero_mm + float(self.rng.normal(0.0, READING_U_MM))


class StopMaker:
    """Draws stops over one base fixture and one tool."""

    def __init__(self, cups_mm: FloatArray, nests_mm: FloatArray) -> None:
        self._fixtures = Fixtures(cups_mm, nests_mm)
        self._measurable = measurable(assemblies(cups_mm, nests_mm), cups_mm, nests_mm)
        self._pairs: tuple[Leg, ...] = tuple(product(range(1, len(cups_mm) + 1), (1, 2, 3)))

    def stop(
        self, rng: np.random.Generator, u_mm: float = 0.06, offsets_mm: FloatArray = CODES_MM
    ) -> CodedStop:
        """Return a stop whose six lengths are aimed at 300 mm and these offsets, in random order.

        The worst of the six is foreseen with `u_mm`; all errors come from one error of the pose, so they are
        correlated as the forecast says.
        """
        assembly: Assembly = self._measurable[rng.integers(len(self._measurable))]
        legs = tuple(assembly.legs[k] for k in rng.permutation(6))
        wanted = _NOMINAL_MM + rng.permutation(offsets_mm)
        fixtures = self._fixtures
        aimed = least_squares_pose(fixtures, legs, wanted, 1e-6 * np.eye(6), commanded=assembly.pose).pose
        gradient = linear_legs(fixtures, legs, aimed).gradient
        shape = np.diag([1.0] * 3 + [1.0 / _LEVER_MM**2] * 3)
        shape *= u_mm**2 / np.diag(gradient @ shape @ gradient.T).max()
        off = np.sqrt(np.diag(shape)) * rng.normal(size=6)
        true = Pose(rotation_from_vector(off[3:]) @ aimed.rotation, aimed.origin_mm + off[:3])
        lengths = linear_legs(fixtures, self._pairs, true).length_mm.tolist()
        return CodedStop(
            legs, foreseen(1, fixtures, aimed, shape), dict(zip(self._pairs, lengths, strict=True)), rng
        )
