"""Visits of commanded poses, as a test of ISO 9283 would measure them."""

import numpy as np

from truepose.validation.iso9283.visits import CommandedPose, Visits

CORNERS = ((0.0, 0.0, 0.0), (160.0, 160.0, -160.0), (-160.0, 160.0, -160.0), (-160.0, -160.0, 160.0))
COMMANDED = tuple(
    CommandedPose(number, place) for number, place in enumerate((*CORNERS, (160.0, -160.0, 160.0)), start=1)
)


def visits_of(number, positions_mm, *, turns_rad=None, u_mm=0.0, u_rot_rad=None):
    """One pose, cycle after cycle."""
    n = len(positions_mm)
    return Visits(
        np.full(n, number),
        np.arange(1, n + 1),
        np.asarray(positions_mm, dtype=float),
        np.full(n, u_mm),
        None if turns_rad is None else np.asarray(turns_rad, dtype=float),
        None if u_rot_rad is None else np.full(n, u_rot_rad),
    )


def joined(*parts):
    """Visits of several poses as one test."""
    turns = [part.turn_rad for part in parts]
    return Visits(
        np.concatenate([part.pose for part in parts]),
        np.concatenate([part.cycle for part in parts]),
        np.vstack([part.position_mm for part in parts]),
        np.concatenate([part.standard_uncertainty_mm for part in parts]),
        None if turns[0] is None else np.vstack(turns),
    )


def five_poses(scatter_mm=0.0, error_mm=(0.0, 0.0, 0.0), cycles=30, seed=1, u_mm=0.0):
    """All five poses with one error and a scatter."""
    rng = np.random.default_rng(seed)
    return joined(
        *(
            visits_of(
                pose.number,
                np.array(pose.position_mm) + error_mm + scatter_mm * rng.standard_normal((cycles, 3)),
                u_mm=u_mm,
            )
            for pose in COMMANDED
        )
    )
