"""Held-out statistics: errors of position, and of the distances between all pairs of points."""

from collections.abc import Iterator

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import LegReadings, PointReadings
from truepose.domain.errors import ConfigurationError
from truepose.domain.results import Model, NominalAndIdentified, Statistics, Validation
from truepose.identification import predict, predict_lengths, predict_nominal
from truepose.identification.verdict.statistics import covariance_with_scatter_mm2, mean_norm, statistics

_PAIRS_AT_ONCE = 2_000_000
_BEYOND_CLAIM = 3.0  # times the claimed mean error: drift and other zones of the work space stay within it


def validate(
    model: Model, readings: PointReadings | LegReadings, *, limit_mm: float | None = None
) -> Validation:
    """Judge a model on readings it was not made from.

    Parameters
    ----------
    model : Model
    readings : PointReadings or LegReadings
        n >= 1 readings.
    limit_mm : float, optional
        Largest error that passes; without it the model passes when its mean error is neither above the
        nominal model's nor far above what it claims itself.

    Returns
    -------
    Validation

    Raises
    ------
    ConfigurationError
        The readings do not fit the model, or there are none.
    """
    if len(readings) == 0:
        raise ConfigurationError("There is no reading to validate with.")
    if isinstance(readings, LegReadings):
        return _validate_legs(model, readings, limit_mm)
    predicted, uncertainty = predict(model, readings.stops, readings.nest)
    nominal = predict_nominal(model, readings.stops, readings.nest)
    covariance = covariance_with_scatter_mm2(readings, model.repeatability_mm)
    noise = mean_norm(covariance)
    position = NominalAndIdentified(
        statistics(readings.position_mm - nominal, noise), statistics(readings.position_mm - predicted, noise)
    )
    own = np.maximum(uncertainty**2 - model.repeatability_mm**2, 0.0)  # the scatter is in the covariance
    claimed = mean_norm(covariance + own[:, None, None] * np.eye(3))
    distance = _distances(readings, nominal, predicted, covariance)
    passed = _passes(position, limit_mm, claimed)
    return Validation("position", position, distance, limit_mm, passed, claimed)


def _passes(position: NominalAndIdentified, limit_mm: float | None, claimed_mm: float) -> bool:
    if limit_mm is not None:
        return position.identified.max_mm <= limit_mm
    # A model far from what it claims does not know this robot, frame or unit, however bad the nominal one is.
    better = position.identified.mean_mm <= position.nominal.mean_mm
    return better and position.identified.mean_mm <= _BEYOND_CLAIM * claimed_mm


def _validate_legs(model: Model, legs: LegReadings, limit_mm: float | None) -> Validation:
    sigma = np.sqrt(legs.standard_uncertainty_mm**2 + model.repeatability_mm**2)
    noise = float(np.sqrt(2.0 / np.pi) * sigma.mean())
    nominal = (legs.length_mm - predict_lengths(model, legs, nominal=True))[:, None]
    identified = (legs.length_mm - predict_lengths(model, legs))[:, None]
    pair = NominalAndIdentified(statistics(nominal, noise), statistics(identified, noise))
    claimed = noise * float(np.sqrt(1.0 + (model.discrepancy_mm / np.sqrt(np.mean(sigma**2))) ** 2))
    return Validation("length", pair, None, limit_mm, _passes(pair, limit_mm, claimed), claimed)


def _distances(
    readings: PointReadings, nominal: FloatArray, predicted: FloatArray, covariance_mm2: FloatArray
) -> NominalAndIdentified | None:
    if len(readings) < 2:
        return None
    # A distance sees one component of the noise of each of its two ends.
    variance = float(np.trace(covariance_mm2, axis1=1, axis2=2).mean()) / 3.0
    noise = float(np.sqrt(2.0 / np.pi) * np.sqrt(2.0 * variance))
    before, after = _Running(), _Running()
    for first, second in _pairs(len(readings)):
        seen = _lengths(readings.position_mm, first, second)
        before.add(seen - _lengths(nominal, first, second))
        after.add(seen - _lengths(predicted, first, second))
    return NominalAndIdentified(before.statistics(noise), after.statistics(noise))


def _lengths(points: FloatArray, first: IntArray, second: IntArray) -> FloatArray:
    return np.asarray(np.linalg.norm(points[first] - points[second], axis=1))


def _pairs(n: int) -> Iterator[tuple[IntArray, IntArray]]:
    """Yield all pairs i < j in blocks that fit in memory."""
    rows = max(1, _PAIRS_AT_ONCE // n)
    for start in range(0, n, rows):
        here = np.arange(start, min(start + rows, n), dtype=np.int64)
        first, second = np.meshgrid(here, np.arange(n, dtype=np.int64), indexing="ij")
        chosen = first < second
        yield first[chosen], second[chosen]


class _Running:
    """Statistics of absolute errors over blocks of pairs."""

    def __init__(self) -> None:
        self._n, self._sum, self._squares, self._largest = 0, 0.0, 0.0, 0.0

    def add(self, errors: FloatArray) -> None:
        """Take another block."""
        if errors.size == 0:
            return
        self._n += errors.size
        self._sum += float(np.abs(errors).sum())
        self._squares += float(errors @ errors)
        self._largest = max(self._largest, float(np.abs(errors).max()))

    def statistics(self, noise_mm: float) -> Statistics:
        """Return the statistics of all blocks."""
        mean = self._sum / self._n
        variance = max(self._squares / self._n - mean**2, 0.0) * self._n / max(self._n - 1, 1)
        return Statistics(
            self._n,
            mean,
            float(np.sqrt(self._squares / self._n)),
            float(np.sqrt(variance)),
            self._largest,
            noise_mm,
        )
