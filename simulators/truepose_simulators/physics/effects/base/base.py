"""Where an identified model says that the robot stands."""

import numpy as np

from truepose_simulators.physics.effects.stated import COMPONENTS, Stated
from truepose_simulators.physics.rigid import FloatArray, placed


def placed_base(start: FloatArray, stated: Stated) -> FloatArray:
    """Return the base in the world, shape (4, 4), from its start and `base_x`..`base_rz` [mm, rad].

    The identified angles turn the started orientation about the axes of the world, the identified shift moves
    the started origin; neither acts on the other.
    """
    six = np.zeros(6)
    for (component,), value in stated.matching(r"base_(r?[xyz])", "base_x to base_rz"):
        six[COMPONENTS.index(component)] = value
    base = placed(six[:3] + start[:3, 3], six[3:])
    base[:3, :3] = base[:3, :3] @ start[:3, :3]
    return base
