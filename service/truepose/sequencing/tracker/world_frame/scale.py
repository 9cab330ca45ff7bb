"""The tracker's scale against certified lengths. Pure.

Lengths certified by themselves come first; where there are none, the figure of the fixed nests' certified
centres is as good as one, as long as its certificate is fine enough to say something.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.cell.description import CertifiedLength
from truepose.domain.measurement.session import Registration

VERIFIED_BELOW: Final = 5e-5  # standard uncertainty; 0.05 mm at 1 m would spoil every absolute figure


@dataclass(frozen=True, slots=True)
class Scale:
    """Certified over measured length [1]."""

    value: float
    standard_uncertainty: float

    @property
    def verified(self) -> bool:
        """Whether the certificate is fine enough to speak of the scale at all."""
        return self.standard_uncertainty < VERIFIED_BELOW


def scale_of_figure(measured_mm: FloatArray, certified_mm: FloatArray, covariances_mm2: FloatArray) -> Scale:
    """Scale from the size of a figure of points, turned alike (Umeyama 1991, equation 42).

    Parameters
    ----------
    measured_mm, certified_mm : ndarray, shape (n, 3)
    covariances_mm2 : ndarray, shape (n, 3, 3)
        Of the differences between the two, certificate included.
    """
    measured = measured_mm - measured_mm.mean(axis=0)
    arms = certified_mm - certified_mm.mean(axis=0)
    size = float(np.sum(measured**2))
    variance = float(np.einsum("ni,nij,nj->", arms, covariances_mm2, arms)) / size**2
    return Scale(float(np.sum(arms * measured)) / size, float(np.sqrt(variance)))


def scale_of_lengths(
    measured_mm: FloatArray, covariances_mm2: FloatArray, lengths: Sequence[CertifiedLength]
) -> Scale:
    """Scale from certified lengths between nests, the nests that they share taken into account.

    Parameters
    ----------
    measured_mm : ndarray, shape (n, 3)
    covariances_mm2 : ndarray, shape (n, 3, 3)
        Of the readings alone.
    lengths : sequence of CertifiedLength
        At least one; their nests are 1-based rows of `measured_mm`.
    """
    ends = np.array([length.fixed_nests for length in lengths]) - 1
    arms = measured_mm[ends[:, 1]] - measured_mm[ends[:, 0]]
    long_mm = np.linalg.norm(arms, axis=1)
    gradient = np.zeros((len(lengths), *measured_mm.shape))
    rows = np.arange(len(lengths))
    gradient[rows, ends[:, 1]] = arms / long_mm[:, None]
    gradient[rows, ends[:, 0]] = -arms / long_mm[:, None]
    covariance = np.einsum("ani,nij,bnj->ab", gradient, covariances_mm2, gradient)
    covariance += np.diag([length.standard_uncertainty_mm**2 for length in lengths])
    relative = covariance / np.outer(long_mm, long_mm)
    weights = np.linalg.solve(relative, np.ones(len(lengths)))
    ratios = np.array([length.length_mm for length in lengths]) / long_mm
    return Scale(float(weights @ ratios / weights.sum()), float(weights.sum() ** -0.5))


def scale_sentence(registration: Registration) -> str:
    """Say what the certified lengths say of the tracker's scale."""
    if registration.scale is None or registration.scale_standard_uncertainty is None:
        return "Scale not verified: there is no length certified finely enough."
    off, u = 1e6 * (registration.scale - 1.0), 1e6 * registration.scale_standard_uncertainty
    verdict = "agrees with" if abs(off) <= 3.0 * u else "contradicts"
    return f"The tracker's scale {verdict} the certified lengths: {off:+.1f} ppm (u = {u:.1f} ppm)."
