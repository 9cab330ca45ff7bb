"""Small fleets in which the zero of one robot ages."""

import numpy as np

from tests.helpers.fleet.linear import drawn
from truepose.fleet.minimum_detectable_change import least_of_robots

ZERO, SCALE = np.eye(4)[0], np.eye(4)[3]


def fleet_of(seed, drift=None, **options):
    return drawn(seed, **{"robots": 4, "readings": 20, "months": 3, "drift": drift, **options}).fleet()


def zero(account):
    return next(one for one in least_of_robots(account) if one.cause.effect == "joint_offset")


def ages(amount):
    """Return how the zero of robot 2 moves evenly to an amount, in stated widths."""
    return lambda i, k, month: 0.5 * amount * month * (i == 2) * ZERO
