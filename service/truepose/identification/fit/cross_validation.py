"""Cross-validation by configuration: every configuration is predicted by a model that never saw it.

All readings of a configuration, and of its revisits, are left out together. The folds start from the
full solution and keep its weights, so that a fold costs a step or two of the solver.
"""

from collections.abc import Iterator

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.identification.fit.robust import fit
from truepose.identification.model.stops import sites
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import Block

_LEAVE_ONE_OUT = 40  # up to so many configurations one is left out at a time, beyond it a tenth
_FOLDS = 10


def held_out_residuals(
    structure: Structure, blocks: tuple[Block, ...], values: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Residuals of the first block's readings, each predicted without its configuration.

    Parameters
    ----------
    structure : Structure
    blocks : tuple of Block
        With the weights of the full fit.
    values : ndarray, shape (P,)
        The full solution.

    Returns
    -------
    residual : ndarray, shape (n, d)
    variance : ndarray, shape (n,)
        What the uncertainty of the fold's parameters adds per component.
    """
    first = blocks[0]
    n = len(first.weights)
    residual: FloatArray | None = None
    variance = np.zeros(n)
    owners = [sites(block.targets.stops) for block in blocks]
    for held in _folds(owners[0]):
        kept = tuple(
            block.subset(np.flatnonzero(~np.isin(owner, held)))
            for block, owner in zip(blocks, owners, strict=True)
        )
        out = np.flatnonzero(np.isin(owners[0], held))
        solution = fit(structure, kept, values)
        result = first.subset(out).result(structure, solution.values, None)
        if residual is None:
            residual = np.zeros((n, result.residual.shape[1]))
        residual[out] = result.residual
        jacobian, covariance = result.jacobian, solution.covariance
        spread = np.einsum("pni,pq,qni->n", jacobian, covariance, jacobian, optimize=True)
        variance[out] = spread / result.residual.shape[1]
    if residual is None:
        residual = np.zeros((n, 1))
    return residual, variance


def _folds(configurations: IntArray) -> Iterator[IntArray]:
    distinct = np.unique(configurations)
    if len(distinct) <= _LEAVE_ONE_OUT:
        yield from distinct[:, None]
    else:
        shuffled = np.random.default_rng(0).permutation(distinct)
        yield from np.array_split(shuffled, _FOLDS)
