r"""The fitted model as a linear problem: what any further parameter could still explain.

At the solution the whitened residuals r and the priors' own residuals are stacked; an orthonormal basis Q of
the present parameters' derivatives is projected out of everything. A further parameter with whitened
derivatives g explains (g^T r)^2 / (g^T g - |Q^T g|^2) of the remaining sum of squares: what the present
parameters would absorb of it does not count (Frisch-Waugh; priors are observations of the parameters).
"""

from dataclasses import dataclass, replace

import numpy as np

from service.domain.arrays import FloatArray
from service.identification.observations import Block, BlockResult
from service.identification.robust import RobustFit
from service.identification.rows import sites

_INDEPENDENT = 1e-6  # share of a column's length that must be left to be a direction of its own


@dataclass(frozen=True, slots=True)
class Footing:
    """Residuals after what the present model absorbed."""

    basis: FloatArray  # (m + P, q) orthonormal, of the present parameters: observations first, then priors
    residual: FloatArray  # (m + P,) projected
    size: int  # m
    degrees: float  # of freedom of the residuals
    observations: float  # readings that count, times their components
    alike: float = 1.0  # how many readings of a stop are worth one

    @property
    def residual_square(self) -> float:
        """Sum of squares that the present parameters leave."""
        return float(self.residual @ self.residual)

    def directions(self, columns: FloatArray) -> FloatArray:
        """Return what columns (k, m) add to the basis, orthonormal, shape (m + P, <= k)."""
        full = np.zeros((len(self.residual), len(columns)))
        full[: self.size] = columns.T
        for _ in range(2):  # twice is enough (B. N. Parlett, The Symmetric Eigenvalue Problem, 1980, 6.9)
            full -= self.basis @ (self.basis.T @ full)
        left, sizes, _ = np.linalg.svd(full, full_matrices=False)
        return np.asarray(left[:, sizes > _INDEPENDENT * max(float(np.linalg.norm(columns)), 1e-300)])

    def extended(self, new: FloatArray) -> "Footing":
        """Return the footing with the parameters of further `directions` fitted."""
        return replace(
            self,
            basis=np.hstack([self.basis, new]),
            residual=self.residual - new @ (new.T @ self.residual),
            degrees=self.degrees - new.shape[1],
        )


def footing_of(fit: RobustFit) -> Footing:
    """Return the footing of a fit."""
    final, structure = fit.solution.final, fit.structure
    widths = structure.prior_widths
    residual = np.concatenate([final.residual, (structure.prior_means - fit.values) / widths])
    basis, _ = np.linalg.qr(np.vstack([final.jacobian.T, np.diag(1.0 / widths)]))
    for _ in range(2):
        residual = residual - basis @ (basis.T @ residual)
    observations = observations_of(fit)
    alike = design_effect(fit.blocks[0], fit.results[0])
    return Footing(basis, residual, len(final.residual), max(observations, 1.0), observations, alike)


def observations_of(fit: RobustFit) -> float:
    """Count the readings that count, times their components."""
    return float(
        sum(
            (block.weights > 0.5).sum() * result.residual.shape[1]
            for block, result in zip(fit.blocks, fit.results, strict=True)
        )
    )


def design_effect(block: Block, result: BlockResult) -> float:
    """How many readings of a stop are worth one: 1 + (m - 1) of their correlation.

    What a model lacks moves all nests that are read at one stop together; so does a stop that is revisited.
    """
    vectors = result.whitening.apply(result.residual)
    if result.direction is not None:
        vectors = vectors * result.direction
    kept = block.weights > 0.5
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
