"""What systematic sources do to the judged readings, and how far that moves their mean error."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.results.identification import Model
from truepose.identification.model.estimates import identified_estimate
from truepose.identification.verdict.judge import Judged

DRAWS = 1000  # standard deviation of a standard deviation: 1 / sqrt(2 * 1000) = 2.2 %
_DRAWS_AT_ONCE = 50
_SEED = 20081001  # any fixed one: the same data give the same report


def parameter_shifts(judged: Judged, model: Model) -> FloatArray:
    """Return how predictions change per independent draw of the parameters, shape (P, n, d) [mm]."""
    width = np.sqrt(np.diag(model.covariance))
    used = np.flatnonzero(width > 0.0)
    here = _predicted(judged, model)
    steps = np.array([_predicted(judged, _moved(model, int(k), float(width[k]))) - here for k in used])
    correlation = model.covariance[np.ix_(used, used)] / np.outer(width[used], width[used])
    eigenvalues, vectors = np.linalg.eigh(correlation)
    root = vectors * np.sqrt(np.maximum(eigenvalues, 0.0))
    return np.asarray(np.einsum("pk,pnd->knd", root, steps.reshape(len(used), *here.shape)))


def _predicted(judged: Judged, model: Model) -> FloatArray:
    """Return what a model predicts of the judged readings, but for a constant, shape (n, d) [mm]."""
    moved = identified_estimate(model)
    return -judged.block.result(moved.structure, moved.values, None).residual


def _moved(model: Model, parameter: int, by: float) -> Model:
    parameters = list(model.parameters)
    parameters[parameter] = replace(parameters[parameter], value=parameters[parameter].value + by)
    return replace(model, parameters=tuple(parameters))


def spread_of_mean_mm(residual_mm: FloatArray, shifts: FloatArray) -> float:
    """Return the standard deviation of the mean norm when each source of `shifts` is drawn.

    Parameters
    ----------
    residual_mm : ndarray, shape (n, d)
    shifts : ndarray, shape (K, n, d)
        Change of the residuals per standard deviation of K independent sources [mm].
    """
    if len(shifts) == 0:
        return 0.0
    generator = np.random.default_rng(_SEED)
    flat = shifts.reshape(len(shifts), -1)
    means = []
    for _ in range(DRAWS // _DRAWS_AT_ONCE):
        drawn = (generator.standard_normal((_DRAWS_AT_ONCE, len(shifts))) @ flat).reshape(
            -1, *residual_mm.shape
        )
        means.append(np.linalg.norm(residual_mm + drawn, axis=2).mean(axis=1))
    return float(np.concatenate(means).std(ddof=1))


def nest_shifts(judged: Judged, model: Model, known: Sequence[tuple[int, float]]) -> FloatArray:
    """Return how predictions change per draw of each coordinate of `known` (nest, u [mm]), (K, n, d) [mm]."""
    here = _predicted(judged, model)
    return np.array([
        _predicted(judged, _nest_moved(model, nest, axis, u_mm)) - here
        for nest, u_mm in known
        for axis in range(3)
    ])


def _nest_moved(model: Model, number: int, axis: int, by_mm: float) -> Model:
    def moved(centre_mm: tuple[float, float, float]) -> tuple[float, float, float]:
        x, y, z = (value + (by_mm if k == axis else 0.0) for k, value in enumerate(centre_mm))
        return x, y, z

    nests = tuple(
        replace(nest, centre_mm=moved(nest.centre_mm)) if nest.nest == number else nest
        for nest in model.nests
    )
    return replace(model, nests=nests)


def growth(judged: Judged, origin_mm: FloatArray) -> FloatArray:
    """Return how observations change when all lengths from `origin_mm` grow by their own size, (1, n, d)."""
    return judged.block.moved_by_growth(judged.identified, origin_mm)[None]


def motion_shifts(judged: Judged, covariance: FloatArray) -> FloatArray:
    """Return how positions change per independent small motion of the world, shape (6, n, 3) [mm].

    Parameters
    ----------
    judged : Judged
        Of positions.
    covariance : ndarray, shape (6, 6)
        Of a translation [mm] and a rotation vector [rad] about the world's origin.
    """
    eigenvalues, vectors = np.linalg.eigh(covariance)
    root = (vectors * np.sqrt(np.maximum(eigenvalues, 0.0))).T  # one independent motion a row
    return np.tensordot(root, judged.block.moved_by_world(judged.identified), 1)
