"""Radial errors of a model about a centre, and the figures of some of them with their uncertainties.

Everything is of first order in scatter V, centre C and a constant error of the instrument: a figure with the
influence g of each error has the variance g'Vg +- g'(d C d')g + (g'k)^2, k what the constant shifts each by.
"""

from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.identification.distributions import chi2_exceeded
from truepose.judgement.figure import Figure
from truepose.judgement.sphere.centre import Centre, errors_about


@dataclass(frozen=True, slots=True)
class SphereFigures:
    """What Tables 2.12 and 2.13 of the thesis (A. Nubiola, 2014) tell of n errors, with range and RMS."""

    n: int
    mean_mm: Figure
    sd_mm: Figure
    rms_mm: Figure
    max_mm: Figure  # the largest size
    max_at: int  # row of it
    range_mm: Figure  # largest less smallest


@dataclass(frozen=True, slots=True)
class RadialErrors:
    """Errors of n lengths about one centre: measured less predicted."""

    centre: Centre
    errors_mm: FloatArray  # (n,)
    variance_mm2: FloatArray  # (n,) of a length, the arm's scatter included
    towards: FloatArray  # (n, 3) from the centre to the nest, unit
    constant_mm: FloatArray  # (n,) what one standard uncertainty of a constant error shifts each by

    @property
    def noise_chance(self) -> float:
        """Chance that scatter, constant and an uncertain centre alone show errors as large."""
        weight, shared = 1.0 / self.variance_mm2, self._shared
        slope = shared.T @ (weight * self.errors_mm)
        normal = np.eye(shared.shape[1]) + shared.T @ (weight[:, None] * shared)
        squared = float(weight @ self.errors_mm**2 - slope @ np.linalg.solve(normal, slope))
        return chi2_exceeded(max(squared, 0.0), len(weight) - 3 * self.centre.is_fitted)

    @property
    def standard_uncertainty_mm(self) -> FloatArray:
        """Of each error, shape (n,)."""
        centre = np.einsum("ni,ij,nj->n", self.towards, self._centre_part, self.towards)
        return np.asarray(np.sqrt(np.maximum(self.variance_mm2 + centre, 0.0) + self.constant_mm**2))

    def figures(self, rows: BoolArray) -> SphereFigures:
        """Return the figures of some of the errors, at least two."""
        chosen = np.flatnonzero(rows)
        own = self.errors_mm[chosen]
        off, sd, rms = own - own.mean(), float(own.std(ddof=1)), float(np.sqrt((own**2).mean()))
        largest, low, high = (int(chosen[k]) for k in (np.argmax(np.abs(own)), own.argmin(), own.argmax()))
        return SphereFigures(
            n=len(own),
            mean_mm=self._figure(float(own.mean()), chosen, np.full(len(own), 1.0 / len(own))),
            sd_mm=self._figure(sd, chosen, _share(off, (len(own) - 1) * sd)),
            rms_mm=self._figure(rms, chosen, _share(own, len(own) * rms)),
            max_mm=self._figure(abs(float(self.errors_mm[largest])), np.array([largest]), np.ones(1)),
            max_at=largest,
            range_mm=self._figure(float(np.ptp(own)), np.array([low, high]), np.array([-1.0, 1.0])),
        )

    @property
    def _shared(self) -> FloatArray:
        """What a standard deviation of each thing that no fit took up shifts errors by, shape (n, m)."""
        constant = self.constant_mm[:, None]
        if self.centre.is_fitted:
            return constant
        along = self.towards * np.sqrt(self.centre.covariance_mm2.diagonal())
        return np.hstack([along, constant])

    @property
    def _centre_part(self) -> FloatArray:
        return -self.centre.covariance_mm2 if self.centre.is_fitted else self.centre.covariance_mm2

    def _figure(self, value: float, rows: IntArray, influence: FloatArray) -> Figure:
        g = np.zeros(len(self.errors_mm))
        np.add.at(g, rows, influence)
        slope = self.towards.T @ g
        variance = float(g**2 @ self.variance_mm2 + slope @ self._centre_part @ slope)
        return Figure(value, float(np.hypot(np.sqrt(max(variance, 0.0)), g @ self.constant_mm)))


def _share(part: FloatArray, whole: float) -> FloatArray:
    return part / whole if whole > 0.0 else np.zeros(len(part))


def radial_errors(
    centre: Centre,
    places_mm: FloatArray,
    length_mm: FloatArray,
    variance_mm2: FloatArray,
    constant_u_mm: float,
) -> RadialErrors:
    """Return the errors of n lengths about a centre; shapes as `best_centre`.

    `constant_u_mm` is the standard uncertainty of an error that all lengths have in common: a fitted centre
    takes up a part of it.
    """
    errors, towards = errors_about(centre.place_mm, places_mm, length_mm)
    constant = np.ones(len(errors))
    if centre.is_fitted:
        constant = constant - towards @ centre.covariance_mm2 @ (towards.T @ (1.0 / variance_mm2))
    return RadialErrors(centre, errors, variance_mm2, towards, constant_u_mm * constant)
