"""Rows before the first or after the last reading of a campaign, where nobody followed what drifts.

A drift may go on or stop. Its state is held where the readings left it, and its uncertainty grows as that of
a local linear trend, a slope with a random walk on top (Harvey 1989), both as large as the campaign shows.
Beyond it the slope is unknown: its mean is 0, its mean square that of the fitted slope r, with the variance
of the estimate. Whether it stays or changes, it takes the drift no farther than r t in t hours, root mean
square (Cauchy and Schwarz). The walk comes as far as the drift did, r T, in the T hours of a campaign. Thus

    u^2 = (r t)^2 + (r T)^2 t / T = r^2 t (t + T).

A row that does not tell its time counts as one a campaign's length beyond, t = T.

References
----------
A. C. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter, Cambridge, 1989.
"""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.measurement.campaign import Stops
from truepose.domain.sentences import Sentence, said
from truepose.effects.registry import goes_on
from truepose.effects.shapes.times import SECONDS_PER_HOUR
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.model.parameters.structure import Structure


def held(structure: Structure, targets: Targets) -> tuple[Sentence, ...]:
    """Return one sentence for every effect that is held in some rows because nobody followed it there."""
    hours = _hours_beyond(structure, targets.stops)
    rows = int((hours > 0.0).sum())
    if rows == 0:
        return ()
    return tuple(
        said("cautions.held", effect=effect, rows=rows, targets=len(targets))
        for effect in _going_on(structure)
    )


def held_variance(
    structure: Structure, values: FloatArray, covariance: FloatArray, targets: Targets
) -> FloatArray:
    """Return the variance per axis that drifts add beyond the readings, shape (n,) [mm2].

    Parameters
    ----------
    structure : Structure
        Of a made model.
    values : ndarray, shape (P,)
    covariance : ndarray, shape (P, P)
    targets : Targets
    """
    variance, lasted_h = np.zeros(len(targets)), _lasted_h(structure)
    hours = np.nan_to_num(_hours_beyond(structure, targets.stops), nan=lasted_h)
    rows = np.flatnonzero(hours > 0.0)
    if rows.size and _going_on(structure):
        square = _mean_square_per_h(structure, values, covariance, targets.taken(rows))
        variance[rows] = square * hours[rows] * (hours[rows] + lasted_h)
    return variance


def _mean_square_per_h(
    structure: Structure, values: FloatArray, covariance: FloatArray, targets: Targets
) -> FloatArray:
    """Mean square per axis of what drifts move each position by in an hour, shape (n,) [mm2/h2]."""
    later = replace(targets, stops=replace(targets.stops, time_s=None))
    longer = replace(structure, last_s=(structure.last_s or 0.0) + SECONDS_PER_HOUR)
    before, after = evaluate(structure, values, later), evaluate(longer, values, later)
    way = after.position_mm - before.position_mm
    change = position_jacobian(after) - position_jacobian(before)
    estimate = np.einsum("pni,pq,qni->n", change, covariance, change, optimize=True)
    return np.asarray(((way**2).sum(axis=1) + estimate) / 3.0)


def _going_on(structure: Structure) -> tuple[str, ...]:
    return tuple(effect for effect in structure.effects if goes_on(effect, structure.names_of(effect)))


def _hours_beyond(structure: Structure, stops: Stops) -> FloatArray:
    """Time from the nearest reading [h], 0 between them, NaN where it is unknown, shape (n,)."""
    if stops.time_s is None or structure.last_s is None:
        return np.full(len(stops), np.nan)
    beyond_s = np.maximum(structure.origin_s - stops.time_s, stops.time_s - structure.last_s)
    return np.asarray(np.maximum(beyond_s, 0.0) / SECONDS_PER_HOUR)


def _lasted_h(structure: Structure) -> float:
    last_s = structure.origin_s if structure.last_s is None else structure.last_s
    return (last_s - structure.origin_s) / SECONDS_PER_HOUR
