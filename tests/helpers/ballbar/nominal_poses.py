"""What the nominal robot reaches with the ballbar, and the lengths that it gives."""

import numpy as np

from truepose.planning.ballbar.bodies import chain_of, nest_places
from truepose.planning.ballbar.poses import planned_poses, reach


def reachable(cell, fixture, first_config=1):
    """Return every measurable configuration as a planned pose, numbered from `first_config`."""
    return planned_poses(reach(cell, fixture), fixture.number, first_config)


def nominal_lengths(cell, cups_mm, legs):
    """Return the lengths that the nominal robot gives legs from cups (K, 3) in the world."""
    cups = cups_mm[[base - 1 for base, _ in legs]]
    nest = [tool - 1 for _, tool in legs]

    def lengths(joints_rad):
        nests = nest_places(cell, chain_of(cell, joints_rad))[nest]
        return np.linalg.norm(nests - cups[:, None], axis=2).T

    return lengths
