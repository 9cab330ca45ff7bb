"""The size of a closed loop: what nothing certified is in may as well be larger by one factor.

Contacts with targets of unknown place are the same for an arm whose lengths, tool, targets and zeros are all
larger by a factor, but for readings of a known size, which are small. Source: J. M. Hollerbach,
C. W. Wampler, Int. J. Robotics Research 15(6), 1996, 573-591 (a loop without a length has no scale).
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.identification.model.parameters.structure import Structure

_ALIKE = 0.9  # cosine between a direction that is left open and that of the size
# Of the prior width, which lets arms be a thousandth too large: what is not known better than to two in ten
# thousand is off by a tenth of a millimetre at half a metre, more than all the rest of a loop.
_HARDLY_KNOWN = 0.2


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


def size_left_open(structure: Structure, variances: FloatArray, directions: FloatArray) -> FloatArray | None:
    """Return the direction of the size where it is hardly known, a unit vector (P,); else None.

    Parameters
    ----------
    structure : Structure
    variances : ndarray, shape (P,)
        Of the posterior over the prior widths, along each of its own directions.
    directions : ndarray, shape (P, P)
        These directions in columns, orthonormal.
    """
    grown = size_direction(structure) if structure.targets else None
    if grown is None:
        return None
    hardly = directions[:, variances > _HARDLY_KNOWN**2]
    within = hardly @ (hardly.T @ grown)
    length = float(np.linalg.norm(within))
    return within / length if length > _ALIKE else None


def without(space: FloatArray, direction: FloatArray) -> FloatArray:
    """Return the directions of a space (P, k) in columns that are across another one (P,), (P, k - 1).

    All k of them where the other one is not among them.
    """
    share = space.T @ direction
    if float(np.linalg.norm(share)) < _ALIKE:
        return space
    across = np.linalg.svd(share[None], full_matrices=True)[2][1:]
    return np.asarray(space @ across.T)
