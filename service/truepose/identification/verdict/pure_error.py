"""Pure error: what revisited configurations say about repeatability and about the model.

Readings of one nest in one configuration and its revisits differ by noise and scatter alone. Their
variance needs no model; the model's residuals beyond it are lack of fit (N. R. Draper, H. Smith,
Applied Regression Analysis, 3rd ed., 1998, section 2.1).
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import PureError
from truepose.identification.distributions import f_exceeded
from truepose.identification.model.stops import sites
from truepose.identification.observations.blocks import Block

_NOTHING_MM2 = 1e-12  # readings of a simulator without noise: there is no pure error to compare with


def pure_error(block: Block, residual_mm: FloatArray, n_parameters: int) -> PureError | None:
    """Compare lack of fit with pure error; None without revisits.

    Parameters
    ----------
    block : Block
    residual_mm : ndarray, shape (n, d)
        Of the identified model.
    n_parameters : int
    """
    repeat_of = block.targets.stops.repeat_of
    if repeat_of is None or not np.any(repeat_of >= 0):
        return None
    site = sites(block.targets.stops)
    kept = block.counts
    keys = np.stack([site, *block.ends()], axis=1)[kept]
    _, group, sizes = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    residual = residual_mm[kept]
    means = np.stack([np.bincount(group.ravel(), column) / sizes for column in residual.T], axis=1)
    within = float(((residual - means[group.ravel()]) ** 2).sum())
    pure_dof = block.components * int((sizes - 1).sum())
    lack_dof = block.components * len(residual) - n_parameters - pure_dof
    if pure_dof < 3 or lack_dof < 1 or within < _NOTHING_MM2:
        return None
    lack = float((residual**2).sum()) - within
    ratio = (lack / lack_dof) / (within / pure_dof)
    return PureError(
        revisits=int((sizes - 1).sum()),
        degrees_of_freedom=pure_dof,
        repeatability_mm=float(np.sqrt(within / pure_dof)),
        lack_of_fit_ratio=ratio,
        p_value=f_exceeded(ratio, lack_dof, pure_dof),
    )
