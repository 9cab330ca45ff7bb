"""A model whose base is known so far, and readings of an arm that errs by some structure."""

import numpy as np

from tests.helpers.domain.robots import IRB_120
from tests.helpers.identification.models import model_of
from tests.helpers.identification.synthetic import NESTS, configurations
from truepose.domain.campaign import PointReadings, Stops
from truepose.domain.identification import NestCentre, Parameter
from truepose.domain.robot import FramePlacement
from truepose.kinematics.chain import nominal_chain

U_MM = 0.02
FRAME = ("base_x", 0.03), ("base_y", 0.01), ("base_rz", 5e-5)
_CENTRES = tuple(NestCentre(number, centre) for number, centre in enumerate(NESTS, start=1))


def model_with_frame(**changes):
    """A model whose base is known as `FRAME` says."""
    parameters = tuple(
        Parameter(name, "base", 0.0, "rad" if "r" in name else "mm", u, 1.0) for name, u in FRAME
    )
    values = {
        "effects": ("base",),
        "parameters": parameters,
        "covariance": np.diag([u**2 for _, u in FRAME]),
        "base": FramePlacement(),
        "nests": _CENTRES,
        "nominal_nests": _CENTRES,
    }
    return model_of(IRB_120, **(values | changes))


def readings(n, error_mm=0.25, seed=0):
    """Readings that a sound instrument would give of an arm with errors of some structure."""
    joints, nest = configurations(n, seed=seed), 1 + np.arange(n) % 3
    places = nominal_chain(IRB_120, joints).points(np.array(NESTS)[nest - 1])
    off = error_mm * np.stack(
        [np.cos(joints[:, 0]), np.sin(2.0 * joints[:, 1]), np.cos(joints[:, 2])], axis=1
    )
    return PointReadings(Stops(np.arange(n), joints), nest, places + off, np.full(n, U_MM))
