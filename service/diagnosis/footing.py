r"""The fitted model as a linear problem: what any further parameter could still explain.

At the solution the whitened residuals r and the priors' own residuals are stacked; an orthonormal basis Q of
the present parameters' derivatives is projected out of everything. A further parameter with whitened
derivatives g explains (g^T r)^2 / (g^T g - |Q^T g|^2) of the remaining sum of squares: what the present
parameters would absorb of it does not count (Frisch-Waugh; priors are observations of the parameters).
"""

from dataclasses import dataclass, replace

import numpy as np

from service.domain.arrays import FloatArray
from service.identification.robust import RobustFit


@dataclass(frozen=True, slots=True)
class Footing:
    """Residuals after what the present model absorbed."""

    basis: FloatArray  # (m + P, q) orthonormal, of the present parameters: observations first, then priors
    residual: FloatArray  # (m + P,) projected
    size: int  # m
    degrees: float  # of freedom of that sum
    observations: float  # readings that count, times their components

    @property
    def residual_square(self) -> float:
        """Sum of squares that the present parameters leave."""
        return float(self.residual @ self.residual)

    @property
    def variance(self) -> float:
        """Variance of the whitened residuals: 1 where the weights are right."""
        return self.residual_square / max(self.degrees, 1.0)

    def absorbed(self, columns: FloatArray) -> FloatArray:
        """Coordinates of columns (K, m) in the present parameters, shape (K, q)."""
        return np.asarray(columns @ self.basis[: self.size])

    def extended(self, columns: FloatArray) -> "Footing":
        """Return the footing with further parameters of columns (k, m) fitted."""
        full = np.zeros((len(self.residual), len(columns)))
        full[: self.size] = columns.T
        for _ in range(2):  # twice is enough (B. N. Parlett, The Symmetric Eigenvalue Problem, 1980, 6.9)
            full -= self.basis @ (self.basis.T @ full)
        left, sizes, _ = np.linalg.svd(full, full_matrices=False)
        new = left[:, sizes > 1e-6 * max(float(np.linalg.norm(columns)), 1e-300)]
        return replace(
            self,
            basis=np.hstack([self.basis, new]),
            residual=self.residual - new @ (new.T @ self.residual),
            degrees=self.degrees - new.shape[1],
        )


def footing_of(fit: RobustFit) -> Footing:
    """Return the footing of a fit."""
    final, structure = fit.solution.final, fit.structure
    return _footing(
        fit, final.jacobian, final.residual, structure.prior_widths, structure.prior_means - fit.values
    )


def _footing(
    fit: RobustFit, jacobian: FloatArray, residual: FloatArray, widths: FloatArray, deviation: FloatArray
) -> Footing:
    stacked = np.vstack([jacobian.T, np.diag(1.0 / widths)])
    basis, _ = np.linalg.qr(stacked)
    full = np.concatenate([residual, deviation / widths])
    for _ in range(2):
        full = full - basis @ (basis.T @ full)
    observations = sum(
        float((block.weights > 0.5).sum()) * result.residual.shape[1]
        for block, result in zip(fit.blocks, fit.results, strict=True)
    )
    return Footing(basis, full, len(residual), max(observations, 1.0), observations)


def footing_without(fit: RobustFit, names: tuple[str, ...]) -> Footing:
    """Return the footing of a fit as if the parameters `names` had not been fitted, to first order."""
    final, structure = fit.solution.final, fit.structure
    left = np.array([name not in names for name in structure.names])
    out = ~left
    residual = final.residual + fit.values[out] @ final.jacobian[out]
    return _footing(
        fit,
        final.jacobian[left],
        residual,
        structure.prior_widths[left],
        (structure.prior_means - fit.values)[left],
    )
