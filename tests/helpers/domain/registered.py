"""A tracker that stands somewhere in the world and reads certified nests with noise."""

import numpy as np

from tests.unit.service.sessions.tracker.fakes import FIXED_NESTS, TRACKER_AT
from truepose.kinematics.frames import rotation_xyz
from truepose.sessions.tracker.registration import nest_mean, register

ROTATION = rotation_xyz(0.003, -0.002, 2.1)
SPREAD_MM = (0.010, 0.022, 0.022)
CERTIFIED = np.array([nest.centre_mm for nest in FIXED_NESTS])


def in_tracker(world):
    return (world - np.array(TRACKER_AT)) @ ROTATION


def readings(place, rng, n=20):
    return place + np.array(SPREAD_MM) * rng.standard_normal((n, 3))


def draw(rng, true_nests=CERTIFIED, scale=1.0, nests=FIXED_NESTS, lengths=()):
    stated = np.broadcast_to(np.diag(np.square(SPREAD_MM)), (20, 3, 3))
    means = [nest_mean(readings(scale * place, rng), stated) for place in in_tracker(true_nests)]
    return register(means, nests, lengths=lengths)
