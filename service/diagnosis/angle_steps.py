r"""Joint angles that were rounded before they were written down: noise that the steps of the file explain.

Rounding to a step s leaves each angle off by up to s / 2 either way, s / sqrt(12) in the root mean square. A
stop's readings move by its levers J times that, so that their covariance, whitened, is I + (s^2 / 12) J J^T.
Whole steps alone say nothing: a plan may ask for them, and the arm go there exactly. So this must be the
better story of the residuals than noise that is larger all over, which has a free size.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from service.diagnosis.selection import Selected
from service.diagnosis.ways import of_joint
from service.domain.arrays import FloatArray
from service.identification.rows import sites

_STEPS_DEG = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
_SLACK_DEG = 1e-9  # angles pass through radians
_FEWEST = 10  # configurations: fewer may all be whole by chance
_CLEARLY = 5.0  # in log likelihood
_MATTERS = 0.04  # of the stated variance: a fifth of the noise
_OF_THAT_SIZE = (0.5, 2.0)  # what is there beyond the stated noise, over what the steps explain


@dataclass(frozen=True, slots=True)
class AngleSteps:
    """Steps of the joint angles that explain the noise."""

    step_deg: float
    scatter_mm: float  # root mean square of what they do to the place of the tool, or to lengths
    of_lengths: bool = False


def telling_steps(selected: Selected) -> AngleSteps | None:
    """Return the steps of the joint angles where they explain noise beyond what is stated; else None."""
    stops = selected.fit.blocks[0].targets.stops
    step_deg = step_of(np.rad2deg(stops.joints_rad))
    if step_deg is None:
        return None
    spread_rad = np.deg2rad(step_deg) / np.sqrt(12.0)
    levers = np.stack([of_joint(selected, joint) for joint in range(stops.joints_rad.shape[1])])
    scatter_mm = float(spread_rad * np.sqrt((levers**2).sum(axis=(0, 2)).mean()))
    white = list(_of_each_stop(selected, spread_rad * levers))
    found = AngleSteps(step_deg, scatter_mm, of_lengths=levers.shape[2] == 1)
    return found if _explain(white, _freedom(selected)) else None


def step_of(joints_deg: FloatArray) -> float | None:
    """Return the coarsest step of which all angles (n, J) are multiples; None where there is none."""
    if len(np.unique(joints_deg, axis=0)) < _FEWEST:
        return None
    return next((step for step in _STEPS_DEG if _whole(joints_deg, step)), None)


def _whole(joints_deg: FloatArray, step_deg: float) -> bool:
    return bool(np.abs(joints_deg - step_deg * np.round(joints_deg / step_deg)).max() < _SLACK_DEG)


def _freedom(selected: Selected) -> float:
    """Return the share of the variance of the noise that the fitted parameters leave in the residuals."""
    counted = max(float(selected.pool.normal.observations), 1.0)
    return max(1.0 - len(selected.fit.structure.specs) / counted, 0.05)


def _of_each_stop(selected: Selected, moves: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield whitened residuals (m,) of each place of the arm, with what the steps do to them (m, J)."""
    block, result = selected.fit.blocks[0], selected.fit.results[0]
    stated, counts = block.weighted(block.weights, 0.0), block.weights > 0.5
    shape = result.residual.shape
    residual = stated.whitened(result).reshape(shape)
    moved = np.stack([stated.whitened(replace(result, residual=move)).reshape(shape) for move in moves])
    place = sites(block.targets.stops)
    for one in np.unique(place[counts]).tolist():
        here = counts & (place == one)
        yield residual[here].reshape(-1), moved[:, here].reshape(len(moves), -1).T


def _explain(white: list[tuple[FloatArray, FloatArray]], freedom: float) -> bool:
    """Whether steps of this size are there, and a better story than noise that is larger all over."""
    count = sum(len(residual) for residual, _ in white)
    left = sum(float(residual @ residual) for residual, _ in white) / (freedom * count)
    added = sum(float((moved**2).sum()) for _, moved in white) / count
    low, high = _OF_THAT_SIZE
    if added < _MATTERS or not low * added <= left - 1.0 <= high * added:
        return False
    larger = -0.5 * count * (np.log(freedom * left) + 1.0)
    rounded = sum(_log_likelihood(residual, moved, freedom) for residual, moved in white)
    return bool(rounded > larger + _CLEARLY)


def _log_likelihood(residual: FloatArray, moved: FloatArray, freedom: float) -> float:
    covariance = freedom * (np.eye(len(residual)) + moved @ moved.T)
    _, log_size = np.linalg.slogdet(covariance)
    return -0.5 * float(log_size + residual @ np.linalg.solve(covariance, residual))
