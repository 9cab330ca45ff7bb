"""Circumstances under which an arm stands still: everything at its usual, unless a test says otherwise."""

import numpy as np

from truepose_simulators.physics.effects import Conditions


def stops(joints_rad, **changes):
    n = len(joints_rad)
    values = {
        "joints_rad": joints_rad,
        "direction": np.ones_like(joints_rad),
        "time_s": np.zeros(n),
        "temperature_c": np.full(n, 23.0),
        "attachment": np.ones(n),
    }
    return Conditions(**{**values, **changes})
