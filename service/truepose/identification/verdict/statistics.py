"""Statistics of errors: norms over observations, and the mean norm that noise alone would give."""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import Statistics
from truepose.identification.observations.blocks import Block
from truepose.identification.special_functions import carlson_rg


def statistics(residual_mm: FloatArray, noise_mm: float) -> Statistics:
    """Statistics of the norms of residuals.

    Parameters
    ----------
    residual_mm : ndarray, shape (n, d)
    noise_mm : float
        Mean norm expected from the stated uncertainties alone.
    """
    norms = np.linalg.norm(residual_mm, axis=1)
    return Statistics(
        n=len(norms),
        mean_mm=float(norms.mean()),
        rms_mm=float(np.sqrt((norms**2).mean())),
        sd_mm=float(norms.std(ddof=1)) if len(norms) > 1 else 0.0,
        max_mm=float(norms.max()),
        noise_mm=noise_mm,
    )


def expected_noise_mm(block: Block) -> float:
    """Mean norm of the residuals that readings and the arm's scatter alone would give [mm]."""
    return mean_norm(block.covariance() + block.scatter_mm**2 * np.eye(block.components))


def mean_norm(covariance: FloatArray) -> float:
    r"""Mean length of normal vectors, averaged over n covariances, shape (n, d, d) with d of 1 or 3.

    E|x| = sqrt(8 / pi) R_G(l1, l2, l3) with the eigenvalues l of the covariance and Carlson's
    completely symmetric integral of the second kind (NIST DLMF 19.16.3: R_G is the mean of
    sqrt(u^T L u) over the unit sphere); of a single component sqrt(2 l / pi).
    """
    if covariance.shape[-1] == 1:
        return float(np.sqrt(2.0 / np.pi) * np.sqrt(covariance[:, 0, 0]).mean())
    eigenvalues = np.maximum(np.linalg.eigvalsh(covariance), 0.0)
    return float(np.sqrt(8.0 / np.pi) * carlson_rg(eigenvalues).mean())
