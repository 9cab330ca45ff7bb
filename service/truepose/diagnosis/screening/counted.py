"""How many readings count: those that weigh, and fewer than there are where a stop is read more than once."""

import numpy as np

from truepose.domain.arrays import BoolArray
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.stops import sites
from truepose.identification.observations.blocks import Block, BlockResult


def counted_rows(fit: RobustFit) -> BoolArray:
    """Return which of the stacked components are of readings that count, shape (m,)."""
    return np.concatenate([
        np.repeat(block.counts, result.residual.shape[1])
        for block, result in zip(fit.blocks, fit.results, strict=True)
    ])


def design_effect(block: Block, result: BlockResult) -> float:
    """How many readings of a stop are worth one: 1 + (m - 1) of their correlation.

    What a model lacks moves all nests that are read at one stop together; so does a stop that is revisited.
    """
    vectors = result.whitening.apply(result.residual)
    if result.direction is not None:
        vectors = vectors * result.direction
    kept = block.counts
    _, stop = np.unique(sites(block.targets.stops)[kept], return_inverse=True)
    vectors = vectors[kept]
    sizes = np.bincount(stop)
    sums = np.stack([np.bincount(stop, component) for component in vectors.T], axis=1)
    squares = float((vectors**2).sum())
    pairs = float((sizes * (sizes - 1)).sum())
    if pairs == 0.0 or squares == 0.0:
        return 1.0
    correlation = (float((sums**2).sum()) - squares) / pairs / (squares / len(vectors))
    usual = pairs / len(vectors)  # other readings of the same stop that a reading has on average
    return float(1.0 + usual * np.clip(correlation, 0.0, 1.0))
