"""How well readings go with the pairs they may be of: a Gaussian of all of them at once.

The true lengths x of all pairs at one stop are foreseen as N(f, S). A reading of pair i is x_i plus the
reading's own error and that of the zero. If the readings y are of pairs a = (a_1 .. a_k), which may repeat,

    y ~ N(f_a, s^2 S_aa + (u_reading^2 + u_zero^2) I)

so readings of one pair agree within the instrument, readings of two pairs share what their forecasts have in
common, and readings already kept sharpen the forecast of the next. A pair that is none of them ("nothing": a
ball beside its cup, a length of another stop) may show anything within the range.

The scale s stands for forecasts that claim too much: what a model lacks is in no covariance. It is the same
for all legs of a stop, so the first readings teach how far to trust the forecast of the others.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.measurement.ballbar import Leg, PoseForecast

# One stop in 25 is foreseen half as well as claimed, one in a hundred a quarter.
_SCALES = ((1.0, 0.95), (2.0, 0.04), (4.0, 0.01))


@dataclass(frozen=True, slots=True, eq=False)
class Foreseen:
    """What is known of the lengths at one stop before they are read."""

    pairs: tuple[Leg, ...]  # p pairs that can be told apart
    length_mm: FloatArray  # (p,)
    covariance_mm2: FloatArray  # (p, p)
    noise_mm2: float  # variance that each reading adds
    spread_mm2: float  # variance of a reading of nothing about the nominal length

    def index(self, leg: Leg) -> int:
        """Return the row of a pair.

        Raises
        ------
        ConfigurationError
            Nothing is foreseen of the pair.
        """
        if leg not in self.pairs:
            raise ConfigurationError(f"The forecast of this pose says nothing of leg B{leg[0]} T{leg[1]}.")
        return self.pairs.index(leg)


def foreseen_by(forecast: PoseForecast, noise_mm2: float, spread_mm2: float) -> Foreseen:
    """Return a forecast as arrays.

    Raises
    ------
    ConfigurationError
        The covariance is not of the size of the forecast, not finite, or not one of real quantities.
    """
    length, covariance = np.array(forecast.length_mm), np.array(forecast.covariance_mm2)
    if covariance.shape != (len(length), len(length)) or len(forecast.legs) != len(length):
        raise ConfigurationError(
            f"The forecast of configuration {forecast.config} needs one length and one row and column of "
            f"covariance for each of its {len(forecast.legs)} legs."
        )
    finite = np.isfinite(length).all() and np.isfinite(covariance).all()
    # a little below 0 by rounding does no harm: the noise outweighs it at every scale
    if not finite or np.linalg.eigvalsh(covariance)[0] < -0.01 * noise_mm2:
        raise ConfigurationError(
            f"The covariance of the forecast of configuration {forecast.config} is not one of real lengths."
        )
    return Foreseen(forecast.legs, length, covariance, noise_mm2, spread_mm2)


def nothing_foreseen(
    pairs: Sequence[Leg], nominal_mm: float, noise_mm2: float, spread_mm2: float
) -> Foreseen:
    """Return what is known where no model foresees anything: all lengths are somewhere within the range."""
    count = len(pairs)
    return Foreseen(
        tuple(pairs), np.full(count, nominal_mm), spread_mm2 * np.eye(count), noise_mm2, spread_mm2
    )


def log_likelihood(
    foreseen: Foreseen, asked: Sequence[Leg], readings: Mapping[Leg, float], assignments: IntArray
) -> FloatArray:
    """Return the log-likelihood of the readings under each assignment.

    Parameters
    ----------
    foreseen : Foreseen
    asked : sequence of k legs
        What the readings were asked for.
    readings : mapping of leg to length [mm]
    assignments : ndarray of int, shape (m, k)
        Pairs (rows of `foreseen`) that the readings are of; the number of pairs stands for nothing.

    Returns
    -------
    ndarray, shape (m,)
    """
    pairs, count = len(foreseen.pairs), len(asked)
    own = np.array([foreseen.index(leg) for leg in asked])
    # Nothing has a place of its own for every reading: two readings of nothing have nothing in common.
    place = np.where(assignments == pairs, pairs + np.arange(count), assignments)
    mean = np.concatenate([foreseen.length_mm, foreseen.length_mm[own]])
    misfit = np.array([readings[leg] for leg in asked]) - mean[place]
    variance = np.zeros((pairs + count, pairs + count))
    variance[pairs:, pairs:] = foreseen.spread_mm2 * np.eye(count)
    terms = []
    for scale, share in _SCALES:
        variance[:pairs, :pairs] = scale**2 * foreseen.covariance_mm2
        total = variance[place[:, :, None], place[:, None, :]] + foreseen.noise_mm2 * np.eye(count)
        terms.append(np.log(share) + _log_density(misfit, total))
    return np.asarray(np.logaddexp.reduce(terms, axis=0))


def _log_density(misfit: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the log-density of N(0, covariance) at each of m misfits (m, k)."""
    factor = np.linalg.cholesky(covariance)
    white = np.linalg.solve(factor, misfit[..., None])[..., 0]
    logarithm = np.log(np.diagonal(factor, axis1=1, axis2=2)).sum(axis=1)
    density: FloatArray = (
        -0.5 * (white**2).sum(axis=1) - logarithm - 0.5 * misfit.shape[1] * np.log(2 * np.pi)
    )
    return density
