"""Radial errors of a model about the centre of a ball, with their uncertainties.

The centre is where the ball was taught, or where the lengths fit best. With p the places of the tool nest, c
the centre and L the lengths, an error is e = L - |p - c|. It grows by the direction d = (p - c) / |p - c| per
unit of the centre. About the centre of least squares, covariance C, errors from scatter V have the covariance
V - d C d'; about one that is known from elsewhere, V + d C d'.

The best centre is found by Gauss-Newton, c -= C sum d e / v with C^-1 = sum d d' / v, from the one of squared
lengths: |p|^2 - L^2 = 2 p . c - (|c|^2), linear in c and |c|^2.

Everything is of first order in scatter V, centre C and a constant error of the instrument: a figure with the
influence g of each error has the variance g'Vg +- g'(d C d')g + (g'k)^2, k what the constant shifts each by.
The influence of a mean is 1 / n, of a standard deviation s it is (e - mean) / ((n - 1) s), of an RMS r it is
e / (n r).

References
----------
A. Nubiola, thesis, 2014, section 2.6.3 (the test with the ballbar), Tables 2.12 and 2.13.
JCGM 100:2008 (GUM), 5.1.2 and 5.2.2.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.identification.distributions import chi2_exceeded
from truepose.identification.fit.solver import covariance_of
from truepose.messages.message import Message, message
from truepose.validation.uncertainty import Figure

_ROUNDS: Final = 30
_CONVERGED_MM: Final = 1e-10
_FLAT: Final = 1e-9  # relative: places nearer to one plane say nothing of the centre beside it
_NARROW: Final = 0.1  # RMS direction cosine; stops within some 11 deg of one plane or one line stay below
_NARROWLY: Final = message("sphere.narrow")


@dataclass(frozen=True, slots=True)
class Centre:
    """A place of the ball in the world of a model.

    Attributes
    ----------
    place_mm : ndarray, shape (3,)
    covariance_mm2 : ndarray, shape (3, 3)
    is_fitted : bool
        To the lengths themselves; else known from elsewhere.
    """

    place_mm: FloatArray
    covariance_mm2: FloatArray
    is_fitted: bool


def taught_centre(place_mm: FloatArray, standard_uncertainty_mm: float) -> Centre:
    """Return a centre that is known from elsewhere.

    Parameters
    ----------
    place_mm : ndarray, shape (3,)
    standard_uncertainty_mm : float
        Along each axis.

    Returns
    -------
    Centre
    """
    return Centre(place_mm, standard_uncertainty_mm**2 * np.eye(3), is_fitted=False)


def best_centre(places_mm: FloatArray, length_mm: FloatArray, variance_mm2: FloatArray) -> Centre | Message:
    """Return the centre that n lengths agree with best, or why there is none.

    Parameters
    ----------
    places_mm : ndarray, shape (n, 3)
        Of the tool nest, as a model has them.
    length_mm : ndarray, shape (n,)
        From the ball to the nest.
    variance_mm2 : ndarray, shape (n,)
        Of each length, the arm's scatter included, above 0.

    Returns
    -------
    Centre or Message
        A reason where the stops lie near one plane or on one line as seen from the ball, or where the steps
        do not settle.
    """
    start = _centre_of_powers(places_mm, length_mm)
    return _NARROWLY if start is None else _refined(start, places_mm, length_mm, 1.0 / variance_mm2)


def _refined(
    place: FloatArray, places_mm: FloatArray, length_mm: FloatArray, weight: FloatArray
) -> Centre | Message:
    """Return the centre of least weighted squares of the errors, from a place near it."""
    for _ in range(_ROUNDS):
        errors, towards = errors_about(place, places_mm, length_mm)
        covariance = covariance_of(towards.T @ (weight[:, None] * towards)) if _spread_wide(towards) else None
        if covariance is None:
            return _NARROWLY
        step = -covariance @ (towards.T @ (weight * errors))
        place = place + step
        if np.abs(step).max() <= _CONVERGED_MM:
            return Centre(place, covariance, is_fitted=True)
    return message("sphere.lost")


def _centre_of_powers(places_mm: FloatArray, length_mm: FloatArray) -> FloatArray | None:
    """Return where squared lengths (n,) to places (n, 3) have their centre, shape (3,); None where flat."""
    origin = places_mm.mean(axis=0)
    own = places_mm - origin
    columns = np.column_stack([2.0 * own, np.ones(len(own))])
    # Columns of millimetres and of ones: `_FLAT` is to mean places near one plane, not a unit.
    scale = np.linalg.norm(columns, axis=0)
    scale[scale == 0.0] = 1.0  # of stops that are all at one place
    power = (own**2).sum(axis=1) - length_mm**2
    values, _, rank, _ = np.linalg.lstsq(columns / scale, power, rcond=_FLAT)
    return None if rank < columns.shape[1] else np.asarray(origin + (values / scale)[:3])


def errors_about(
    place_mm: FloatArray, places_mm: FloatArray, length_mm: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the errors about a place, and their derivatives in it.

    Parameters
    ----------
    place_mm : ndarray, shape (3,)
    places_mm : ndarray, shape (n, 3)
    length_mm : ndarray, shape (n,)

    Returns
    -------
    errors_mm : ndarray, shape (n,)
        Measured less predicted.
    towards : ndarray, shape (n, 3)
        d, unit vectors from the place [1].
    """
    away = places_mm - place_mm
    # A stop in the centre itself has no direction, and must not divide by zero while the centre is looked
    # for.
    distance = np.maximum(np.linalg.norm(away, axis=1), _CONVERGED_MM)
    return length_mm - distance, np.asarray(away / distance[:, None])


def _spread_wide(towards: FloatArray) -> bool:
    """Whether directions (n, 3) leave every plane: least eigenvalue of their mean square at least 0.1^2."""
    least = np.linalg.eigvalsh(towards.T @ towards / len(towards))[0]
    return bool(least >= _NARROW**2)


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
    """Errors of n lengths about one centre: measured less predicted.

    Attributes
    ----------
    centre : Centre
    errors_mm : ndarray, shape (n,)
    variance_mm2 : ndarray, shape (n,)
        Of a length, the arm's scatter included.
    towards : ndarray, shape (n, 3)
        From the centre to the nest, unit.
    constant_mm : ndarray, shape (n,)
        What one standard uncertainty of a constant error shifts each by.
    """

    centre: Centre
    errors_mm: FloatArray
    variance_mm2: FloatArray
    towards: FloatArray
    constant_mm: FloatArray

    @property
    def noise_chance(self) -> float:
        """Chance that scatter, constant and an uncertain centre alone show errors as large.

        Chi-square of the errors in their full covariance V + S S', S the shared shifts, by the matrix
        inversion lemma: e'V^-1 e - b'(I + S'V^-1 S)^-1 b with b = S'V^-1 e. A fitted centre took three
        degrees of freedom instead.
        """
        weight, shared = 1.0 / self.variance_mm2, self._shared
        slope = shared.T @ (weight * self.errors_mm)
        normal = np.eye(shared.shape[1]) + shared.T @ (weight[:, None] * shared)
        squared = float(weight @ self.errors_mm**2 - slope @ np.linalg.solve(normal, slope))
        # Of a perfect robot the two terms cancel but for rounding.
        return chi2_exceeded(max(squared, 0.0), len(weight) - 3 * self.centre.is_fitted)

    @property
    def standard_uncertainty_mm(self) -> FloatArray:
        """Of each error, shape (n,)."""
        centre = np.einsum("ni,ij,nj->n", self.towards, self._centre_part, self.towards)
        return np.asarray(np.sqrt(np.maximum(self.variance_mm2 + centre, 0.0) + self.constant_mm**2))

    def figures(self, rows: BoolArray) -> SphereFigures:
        """Return the figures of some of the errors.

        Parameters
        ----------
        rows : ndarray of bool, shape (n,)
            At least two.

        Returns
        -------
        SphereFigures
        """
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
        """What the centre adds along directions: C where it is known, -C where it is fitted; (3, 3)."""
        return -self.centre.covariance_mm2 if self.centre.is_fitted else self.centre.covariance_mm2

    def _figure(self, value: float, rows: IntArray, influence: FloatArray) -> Figure:
        """Return a figure by the influence of some errors on it, scatter, centre and constant counted."""
        g = np.zeros(len(self.errors_mm))
        np.add.at(g, rows, influence)
        slope = self.towards.T @ g
        variance = float(g**2 @ self.variance_mm2 + slope @ self._centre_part @ slope)
        return Figure(value, float(np.hypot(np.sqrt(max(variance, 0.0)), g @ self.constant_mm)))


def _share(part: FloatArray, whole: float) -> FloatArray:
    """Return a part of a whole; of nothing, zeros."""
    return part / whole if whole > 0.0 else np.zeros(len(part))


def radial_errors(
    centre: Centre,
    places_mm: FloatArray,
    length_mm: FloatArray,
    variance_mm2: FloatArray,
    constant_u_mm: float,
) -> RadialErrors:
    """Return the errors of n lengths about a centre.

    Parameters
    ----------
    centre : Centre
    places_mm : ndarray, shape (n, 3)
    length_mm, variance_mm2 : ndarray, shape (n,)
        As of `best_centre`.
    constant_u_mm : float
        Standard uncertainty of an error that all lengths have in common: a fitted centre takes up a part of
        it.

    Returns
    -------
    RadialErrors
    """
    errors, towards = errors_about(centre.place_mm, places_mm, length_mm)
    constant = np.ones(len(errors))
    if centre.is_fitted:
        # The centre moves by C sum d / v per unit of the constant, and each error by d times that.
        constant = constant - towards @ centre.covariance_mm2 @ (towards.T @ (1.0 / variance_mm2))
    return RadialErrors(centre, errors, variance_mm2, towards, constant_u_mm * constant)
