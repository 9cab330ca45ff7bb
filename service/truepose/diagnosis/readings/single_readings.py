"""Single readings: labels of nests that were swapped, readings that belong to no model, heavy-tailed noise.

Heavy tails are noise: what is left follows Student's t better than a normal distribution with a few wild
readings besides (mixture). Readings are called bad only where the mixture is clearly the better story.

References
----------
K. L. Lange, R. J. A. Little, J. M. G. Taylor, J. American Statistical Association 84, 1989, 881-896.
"""

from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize
from scipy.special import gammaln

from truepose.diagnosis.distributions import chi2_log_density
from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.measurement.campaign import PointReadings
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.evaluation import Targets, evaluate

_FITS = 0.2  # another nest must leave less than this share of the residual
_CLEARLY = 5.0  # in log likelihood
_HARDLY = 1.5  # in log likelihood: the others show no heavy tails
_FAR_BEYOND = 150.0  # of the usual variance, twelve standard deviations: t noise of 4 degrees once in 10,000
_MOST_DEGREES = 30.0  # Student's t beyond is normal for all that a campaign can tell


def swapped_labels(points: PointReadings, suspect: BoolArray, model: RobustFit) -> IntArray:
    """Return the nest that each reading fits: another than its own only where that explains a suspect one.

    Parameters
    ----------
    points : PointReadings
        n readings.
    suspect : ndarray, shape (n,)
    model : RobustFit
        Whose predictions are compared.

    Returns
    -------
    ndarray, shape (n,)
        1-based nests.
    """
    nest = points.nest.copy()
    rows = np.flatnonzero(suspect)
    numbers = range(1, len(model.structure.nests_mm) + 1)
    if rows.size == 0 or len(numbers) < 2:
        return nest
    distances = np.stack([_distance(points, rows, number, model) for number in numbers])
    own = distances[points.nest[rows] - 1, np.arange(rows.size)]
    best = np.argmin(distances, axis=0)
    better = distances[best, np.arange(rows.size)] < _FITS * own
    nest[rows[better]] = best[better] + 1
    return nest


def _distance(points: PointReadings, rows: IntArray, number: int, model: RobustFit) -> FloatArray:
    asked = Targets(points.stops.taken(rows), np.full(rows.size, number))
    predicted = evaluate(model.structure, model.values, asked).position_mm
    return np.asarray(np.linalg.norm(points.position_mm[rows] - predicted, axis=1))


@dataclass(frozen=True, slots=True)
class Tails:
    """How the squared normalised residuals of n readings of d components are distributed."""

    bad: BoolArray  # (n,) readings that belong to no model; none where tails are merely heavy
    degrees_of_freedom: float | None  # of Student's t where the tails are heavy


def tails(squared: FloatArray, components: int, gross: BoolArray) -> Tails:
    """Judge the tails of the residuals.

    Parameters
    ----------
    squared : ndarray, shape (n,)
        Squared residual of each reading in its own covariance.
    components : int
    gross : ndarray, shape (n,)
        Readings that the fit gave no weight.
    """
    none = np.zeros(len(squared), dtype=bool)
    if _stand_apart(squared, components, gross):
        return Tails(gross, None)
    normal = _normal(squared, components)
    student, degrees = _student(squared, components)
    mixed = _mixture(squared, components)
    if gross.any() and mixed - max(normal, student) > _CLEARLY:
        return Tails(gross, None)
    heavy = student - normal > _CLEARLY and degrees < _MOST_DEGREES
    return Tails(none, degrees if heavy else None)


def _stand_apart(squared: FloatArray, components: int, gross: BoolArray) -> bool:
    """Whether gross readings lie so far beyond others that scatter normally that no tail reaches there."""
    if not gross.any() or gross.all():
        return False
    usual = squared[~gross]
    typical = float(usual.mean()) / components
    if float(squared[gross].min()) < _FAR_BEYOND * typical:
        return False
    student, _ = _student(usual, components)
    return student - _normal(usual, components) < _HARDLY


def _log_chi2(squared: FloatArray, components: int, variance: float) -> FloatArray:
    return np.asarray(chi2_log_density(squared / variance, components) - np.log(variance))


def _normal(squared: FloatArray, components: int) -> float:
    variance = max(float(squared.mean()) / components, 1e-12)
    return float(_log_chi2(squared, components, variance).sum())


def _student(squared: FloatArray, components: int) -> tuple[float, float]:
    """Squared radius of a multivariate t, scaled: its largest log likelihood and degrees of freedom."""
    d, safe = components, np.maximum(squared, 1e-12)

    def negative(p: FloatArray) -> float:
        scale, nu = np.exp(p[0]), np.exp(p[1])
        constant = gammaln((nu + d) / 2) - gammaln(nu / 2) - gammaln(d / 2) - d / 2 * np.log(nu * scale)
        kernel = (d / 2 - 1) * np.log(safe) - (nu + d) / 2 * np.log1p(safe / (nu * scale))
        return -float((constant + kernel).sum())

    start = np.array([np.log(max(float(np.median(squared)) / d, 1e-12)), np.log(5.0)])
    found = minimize(negative, start, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-3})
    return -float(found.fun), float(np.exp(found.x[1]))


def _mixture(squared: FloatArray, components: int) -> float:
    """Return the largest log likelihood of normal noise with a share of wild readings, less one.

    One parameter more than Student's t has costs one unit (Akaike).
    """
    typical = max(float(np.median(squared)) / components, 1e-12)
    largest = max(float(squared.max()) / components, 4.0 * typical)

    def negative(p: FloatArray) -> float:
        # the share of wild readings by its log odds p[0]: both logarithms stay finite
        usual = _log_chi2(squared, components, float(np.exp(p[1]))) - np.logaddexp(0.0, p[0])
        wild = _log_chi2(squared, components, float(np.exp(p[2]))) - np.logaddexp(0.0, -p[0])
        return -float(np.logaddexp(usual, wild).sum())

    start = np.array([-3.0, np.log(typical), np.log(largest / 2.0)])
    found = minimize(negative, start, method="Nelder-Mead", options={"xatol": 1e-3, "fatol": 1e-3})
    return -float(found.fun) - 1.0
