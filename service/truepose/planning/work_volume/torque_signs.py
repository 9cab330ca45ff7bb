"""Configurations in which gears stay loaded from one side: unloaded ones are much less stiff, and have play.

The thesis keeps joints 2 and 3 so by their ranges (A. Nubiola, 2014, section 2.4); where masses are known,
the torques say it themselves. Those of the wrist change sign whatever is chosen.
"""

from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.kinematics.gravity import gravity_torques
from truepose.planning.work_volume.work_space import WorkSpace, nominal_chain

_GRAVITY_M_S2: Final = np.array([0.0, 0.0, -9.81])  # a robot on a table; world
_WRIST_JOINTS: Final = 3
_MOSTLY: Final = 2.0 / 3.0  # of configurations: a gear loaded from either side alike is left so


def are_loaded_one_way(space: WorkSpace, joints_rad: FloatArray) -> BoolArray:
    """Whether gears keep the side from which most of these configurations (n, J) load them, shape (n,).

    At the stop and at its approach, of the joints between the first and the wrist; all do where masses are
    unknown.
    """
    if not space.robot.masses or not len(joints_rad):
        return np.ones(len(joints_rad), dtype=bool)
    ends = [joints_rad, joints_rad + (space.approach_offset_rad or 0.0)]
    positive = np.array([_torques(space, joints) > 0.0 for joints in ends])  # (2, n, carrying joints)
    share = positive.mean(axis=(0, 1))
    kept = (positive == (share > 0.5)) | (np.maximum(share, 1.0 - share) < _MOSTLY)
    one_way: BoolArray = kept.all(axis=(0, 2))
    return one_way


def _torques(space: WorkSpace, joints_rad: FloatArray) -> FloatArray:
    """Return the torques of the joints that carry the arm, shape (n, k)."""
    found = gravity_torques(nominal_chain(space, joints_rad), space.robot.masses, _GRAVITY_M_S2)
    return found[:, 1 : space.robot.n_joints - _WRIST_JOINTS]
