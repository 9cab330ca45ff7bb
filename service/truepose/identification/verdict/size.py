"""The size of a closed loop: what nothing certified is in may as well be larger by one factor.

Contacts with targets of unknown place are the same for an arm whose lengths, tool, targets and zeros are all
larger by a factor, but for readings of a known size, which are small. Source: J. M. Hollerbach,
C. W. Wampler, Int. J. Robotics Research 15(6), 1996, 573-591 (a loop without a length has no scale).
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.identification.model.structure import Structure

_ALIKE = 0.9  # cosine between a direction that is left open and that of the size


def size_direction(structure: Structure) -> FloatArray | None:
    """Return how the parameters grow with the size of the arm, over their prior widths: a unit vector (P,).

    None where nothing of a length is a parameter.
    """
    joints = structure.robot.joints
    lengths = {f"a_{k}": row.a_mm for k, row in enumerate(joints, start=1)}
    lengths |= {f"d_{k}": row.d_mm for k, row in enumerate(joints, start=1)}
    grown = np.array([lengths.get(name, 0.0) for name in structure.names]) / structure.prior_widths
    total = float(np.linalg.norm(grown))
    return grown / total if total > 0.0 else None


def split_off_size(structure: Structure, space: FloatArray) -> tuple[FloatArray | None, FloatArray]:
    """Split the size off the directions that are left open.

    Parameters
    ----------
    structure : Structure
    space : ndarray, shape (P, k)
        Orthonormal columns, over the prior widths.

    Returns
    -------
    size : ndarray, shape (P,), or None
        The direction among them that is the size; None where the readings, or a certificate, tell it.
    rest : ndarray, shape (P, k - 1) or (P, k)
        Orthonormal columns of what is left.
    """
    grown = size_direction(structure) if structure.targets else None
    if grown is None:
        return None, space
    share = space.T @ grown
    if float(np.linalg.norm(share)) < _ALIKE:
        return None, space
    within = share / np.linalg.norm(share)
    rest = np.linalg.svd(within[None], full_matrices=True)[2][1:]
    return space @ within, space @ rest.T
