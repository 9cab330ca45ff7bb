"""Derivatives of blocks of observations against central differences of their residuals."""

import numpy as np
import pytest

from truepose.identification.observations.blocks import linearise_blocks


def require_alike(structure, blocks, values, *, rel=1e-6, smallest=0.0, step_of=None):
    """Whitened derivatives in every parameter are those of differences, to `rel` of the largest of each.

    Parameters
    ----------
    smallest : float
        A largest derivative below it counts as it.
    step_of : callable, optional
        Step of a parameter; 1e-4 of its prior width otherwise, at which smooth functions are right to 1e-6.
    """
    analytic = linearise_blocks(structure, blocks, values, None).jacobian
    for k, spec in enumerate(structure.specs):
        step = 1e-4 * spec.prior_width if step_of is None else step_of(spec)
        ahead, behind = (
            linearise_blocks(structure, blocks, values + sign * step * np.eye(len(values))[k], None).residual
            for sign in (1.0, -1.0)
        )
        slope = (behind - ahead) / (2.0 * step)
        assert analytic[k] == pytest.approx(slope, abs=rel * max(np.abs(slope).max(), smallest)), spec.name
