"""Stops of the arm at which a person connects six legs, and what makes their lengths uncertain."""

from dataclasses import dataclass

import numpy as np

from service.domain.ballbar import PoseForecast
from service.kinematics.frames import rotation_from_vector
from service.kinematics.pose_device import (
    Fixtures,
    Pose,
    assemblies,
    foreseen,
    least_squares_pose,
    linear_legs,
    measurable,
)
from tests.pose_devices import ALL_LEGS, CUPS, NESTS

CODES_MM = np.arange(6) * 0.28 - 0.7
UNCERTAINTIES = {"reading_u_mm": 0.00051, "zero_u_mm": 0.0015}
BALLBAR = {**UNCERTAINTIES, "nominal_mm": 300.0, "range_mm": 1.0}
_FIXTURES = Fixtures(CUPS, NESTS)
_MEASURABLE = measurable(assemblies(CUPS, NESTS), CUPS, NESTS)


@dataclass
class Stop:
    """One stop: what is asked for, what is foreseen, and what is true."""

    legs: tuple
    forecast: PoseForecast
    true_mm: dict
    rng: np.random.Generator
    zero_mm: float = 0.0

    def read(self, leg):
        """Snap the ballbar between two balls and read it."""
        self.zero_mm = float(np.clip(self.zero_mm + self.rng.normal(0.0, 0.0015), -0.003, 0.003))
        return self.true_mm[leg] + self.zero_mm + self.rng.normal(0.0, 0.00051)


def coded_stop(rng, u_mm=0.06, offsets_mm=CODES_MM):
    """Return a stop whose six lengths are aimed at 300 mm and these offsets, in random order.

    The worst of the six is foreseen with `u_mm`; all errors come from one error of the pose, 200 mm making a
    turn worth a shift.
    """
    assembly = _MEASURABLE[rng.integers(len(_MEASURABLE))]
    legs = tuple(assembly.legs[k] for k in rng.permutation(6))
    wanted = 300.0 + rng.permutation(offsets_mm)
    aimed = least_squares_pose(_FIXTURES, legs, wanted, 1e-6 * np.eye(6), commanded=assembly.pose).pose
    gradient = linear_legs(_FIXTURES, legs, aimed).gradient
    shape = np.diag([1.0] * 3 + [1.0 / 200.0**2] * 3)
    shape *= u_mm**2 / np.diag(gradient @ shape @ gradient.T).max()
    off = np.sqrt(np.diag(shape)) * rng.normal(size=6)
    true = Pose(rotation_from_vector(off[3:]) @ aimed.rotation, aimed.origin_mm + off[:3])
    lengths = linear_legs(_FIXTURES, ALL_LEGS, true).length_mm
    return Stop(legs, foreseen(1, _FIXTURES, aimed, shape), dict(zip(ALL_LEGS, lengths, strict=True)), rng)
