"""Where a model has the ball about which the tool was held: as it was taught, or where the lengths fit best.

With p the places of the tool nest, c the centre and L the lengths, an error is e = L - |p - c|. It grows by
the direction d = (p - c) / |p - c| per unit of the centre. About the centre of least squares, covariance C,
errors from scatter V have the covariance V - d C d'; about one that is known from elsewhere, V + d C d'.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.sentences import Sentence, said
from truepose.identification.fit.solver import covariance_of

_ROUNDS: Final = 30
_CONVERGED_MM: Final = 1e-10
_FLAT: Final = 1e-9  # relative: places nearer to one plane say nothing of the centre beside it
_NARROW: Final = 0.1  # RMS direction cosine; stops within some 11 deg of one plane or one line stay below
_NARROWLY: Final = said("sphere.narrow")


@dataclass(frozen=True, slots=True)
class Centre:
    """A place of the ball in the world of a model."""

    place_mm: FloatArray  # (3,)
    covariance_mm2: FloatArray  # (3, 3)
    is_fitted: bool  # to the lengths themselves


def taught_centre(place_mm: FloatArray, standard_uncertainty_mm: float) -> Centre:
    """Return a centre that is known from elsewhere, to so much along each axis."""
    return Centre(place_mm, standard_uncertainty_mm**2 * np.eye(3), is_fitted=False)


def best_centre(places_mm: FloatArray, length_mm: FloatArray, variance_mm2: FloatArray) -> Centre | Sentence:
    """Return the centre that n lengths agree with best, or why there is none.

    Parameters
    ----------
    places_mm : ndarray, shape (n, 3)
        Of the tool nest, as a model has them.
    length_mm : ndarray, shape (n,)
        From the ball to the nest.
    variance_mm2 : ndarray, shape (n,)
        Of each length, the arm's scatter included, above 0.
    """
    start = _centre_of_powers(places_mm, length_mm)
    return _NARROWLY if start is None else _refined(start, places_mm, length_mm, 1.0 / variance_mm2)


def _refined(
    place: FloatArray, places_mm: FloatArray, length_mm: FloatArray, weight: FloatArray
) -> Centre | Sentence:
    for _ in range(_ROUNDS):
        errors, towards = errors_about(place, places_mm, length_mm)
        covariance = covariance_of(towards.T @ (weight[:, None] * towards)) if _spread_wide(towards) else None
        if covariance is None:
            return _NARROWLY
        step = -covariance @ (towards.T @ (weight * errors))
        place = place + step
        if np.abs(step).max() <= _CONVERGED_MM:
            return Centre(place, covariance, is_fitted=True)
    return said("sphere.lost")


def _centre_of_powers(places_mm: FloatArray, length_mm: FloatArray) -> FloatArray | None:
    """Return where squared lengths (n,) to places (n, 3) have their centre, shape (3,); None where flat."""
    origin = places_mm.mean(axis=0)
    own = places_mm - origin
    columns = np.column_stack([2.0 * own, np.ones(len(own))])
    scale = np.linalg.norm(columns, axis=0)
    power = (own**2).sum(axis=1) - length_mm**2
    values, _, rank, _ = np.linalg.lstsq(columns / scale, power, rcond=_FLAT)
    return None if rank < columns.shape[1] else np.asarray(origin + (values / scale)[:3])


def errors_about(
    place_mm: FloatArray, places_mm: FloatArray, length_mm: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Return the errors (n,) about a place [mm], and their derivatives (n, 3) in it."""
    away = places_mm - place_mm
    distance = np.maximum(np.linalg.norm(away, axis=1), _CONVERGED_MM)
    return length_mm - distance, np.asarray(away / distance[:, None])


def _spread_wide(towards: FloatArray) -> bool:
    least = np.linalg.eigvalsh(towards.T @ towards / len(towards))[0]
    return bool(least >= _NARROW**2)
