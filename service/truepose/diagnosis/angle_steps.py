"""Joint angles that were rounded before they were written down: noise that the steps of the file explain.

Rounding to a step s leaves each angle off by up to s / 2 either way, s / sqrt(12) in the root mean square. A
stop's readings move by its levers J times that, so that their covariance, whitened, is I + (s^2 / 12) J J^T.
Whole steps alone say nothing: a plan may ask for them, and the arm go there exactly. So this must be the
better story of the residuals than noise that is larger all over, which has a free size. Where it is, readings
of points weigh by it: joints with long levers scatter most, and their waves would be found in that (of 40
campaigns with rounded angles 8 had a likely wave of joint 2 or 3 beside equal weights, and none has now).

With r_s the m whitened residuals of stop s, f the share of the noise's variance that the fit leaves in them
and V_s = f (I + M_s M_s^T), M_s = (s / sqrt(12)) J_s whitened, the two log likelihoods over N components are

    larger   -N/2 (ln(sum r^2 / N) + 1),        rounded   -1/2 sum_s (ln det V_s + r_s^T V_s^-1 r_s).

References
----------
JCGM 100:2008 (GUM), 4.3.7 (a quantity known to lie within an interval).
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign, PointReadings, sites
from truepose.effects.ports import ParameterSpec, Port, PortKind, Term
from truepose.identification.fit.robust import RobustFit
from truepose.identification.model.derivatives import trial_derivatives, tried
from truepose.identification.model.evaluation import Targets, evaluate
from truepose.identification.observations.poses import position_block
from truepose.kinematics.chain import theta_gradient

_STEPS_DEG = (1.0, 0.5, 0.2, 0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001)
_SLACK_DEG = 1e-9  # angles pass through radians
_FEWEST = 10  # configurations: fewer may all be whole by chance
_CLEARLY = 5.0  # in log likelihood
_MATTERS = 0.04  # of the stated variance: a fifth of the noise
_OF_THAT_SIZE = (0.5, 2.0)  # what is there beyond the stated noise, over what the steps explain


@dataclass(frozen=True, slots=True)
class AngleSteps:
    """Steps of the joint angles that explain the noise.

    Attributes
    ----------
    step_deg : float
    scatter_mm : float
        Root mean square of what they do to the place of the tool, or to lengths.
    of_lengths : bool
    """

    step_deg: float
    scatter_mm: float
    of_lengths: bool = False


def telling_steps(fit: RobustFit) -> AngleSteps | None:
    """Return the steps of the joint angles where they explain noise beyond what is stated.

    Parameters
    ----------
    fit : RobustFit

    Returns
    -------
    AngleSteps or None
        None where the angles have no common step, or where it explains the residuals no better.
    """
    step_deg = step_of(np.rad2deg(fit.blocks[0].targets.stops.joints_rad))
    if step_deg is None:
        return None
    levers = _levers(fit)
    spread_rad = _spread_rad(step_deg)
    scatter_mm = float(spread_rad * np.sqrt((levers**2).sum(axis=(0, 2)).mean()))
    found = AngleSteps(step_deg, scatter_mm, of_lengths=levers.shape[2] == 1)
    return found if _explain(list(_of_each_stop(fit, spread_rad * levers)), _freedom(fit)) else None


def with_steps(campaign: Campaign, fit: RobustFit, steps: AngleSteps) -> Campaign:
    """Return a campaign whose points are as uncertain as the steps of their joint angles make them.

    Parameters
    ----------
    campaign : Campaign
    fit : RobustFit
        Whose model tells the levers.
    steps : AngleSteps

    Returns
    -------
    Campaign
        Validation points that are written with more digits stay as they are.
    """
    calibration, validation = (
        points and _scattered(points, campaign, fit, steps.step_deg)
        for points in (campaign.calibration, campaign.validation)
    )
    return replace(campaign, calibration=calibration, validation=validation)


def _scattered(points: PointReadings, campaign: Campaign, fit: RobustFit, step_deg: float) -> PointReadings:
    """Return points with the scatter of the steps added to their covariance.

    That is s^2 / 12 sum_j g_j g_j^T, g_j [mm/rad] the lever of joint j. Points of another step stay as they
    are.
    """
    if step_of(np.rad2deg(points.stops.joints_rad)) != step_deg:
        return points
    state = evaluate(fit.structure, fit.values, Targets(points.stops, points.nest))
    moves = _spread_rad(step_deg) * theta_gradient(state.chain, state.unscaled_mm)
    added = np.einsum("jni,jnk->nik", moves, moves)
    covariance = position_block(points, campaign.scatter_mm).covariance_mm2 + added
    return replace(points, covariance_mm2=covariance)


def _spread_rad(step_deg: float) -> float:
    """Return the standard deviation of an angle that was rounded to a step: s / sqrt(12) [rad]."""
    return float(np.deg2rad(step_deg) / np.sqrt(12.0))


def _levers(fit: RobustFit) -> FloatArray:
    """Return how each reading moves per angle of each joint, shape (J, n, d) [mm/rad]."""
    state = fit.results[0].state
    joints = range(fit.structure.robot.n_joints)
    specs = tuple(ParameterSpec(f"step_{joint}", "rad", 0.0, 1.0) for joint in joints)
    terms = tuple(Term(joint, Port(PortKind.THETA, joint), 1.0) for joint in joints)
    return trial_derivatives(fit.blocks[0].derivatives(tried(state, specs, terms)), state)


def step_of(joints_deg: FloatArray) -> float | None:
    """Return the coarsest step of which all angles are multiples.

    Parameters
    ----------
    joints_deg : ndarray, shape (n, J)

    Returns
    -------
    float or None
        [deg]; None where there is none, or fewer than ten configurations.
    """
    # Of different configurations: one that is repeated a hundred times is one chance to be whole.
    if len(np.unique(joints_deg, axis=0)) < _FEWEST:
        return None
    # The coarsest first: whole degrees are multiples of every finer step as well.
    return next((step for step in _STEPS_DEG if _whole(joints_deg, step)), None)


def _whole(joints_deg: FloatArray, step_deg: float) -> bool:
    """Whether all angles (n, J) are multiples of a step."""
    return bool(np.abs(joints_deg - step_deg * np.round(joints_deg / step_deg)).max() < _SLACK_DEG)


def _freedom(fit: RobustFit) -> float:
    """Return the share of the variance of the noise that the fitted parameters leave in the residuals."""
    counted = int(fit.blocks[0].counts.sum()) * fit.results[0].residual.shape[1]
    return float(max(1.0 - len(fit.structure.specs) / max(counted, 1), 0.05))


def _of_each_stop(fit: RobustFit, moves: FloatArray) -> Iterator[tuple[FloatArray, FloatArray]]:
    """Yield whitened residuals (m,) of each place of the arm, with what the steps do to them (m, J)."""
    block, result = fit.blocks[0], fit.results[0]
    # Against the stated noise: the discrepancy of the fit would already hold what the steps are to explain.
    stated, counts = block.weighted(block.weights, 0.0), block.counts
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
    # Steps too fine to matter, or errors far beyond what they scatter, are left to whoever looks for causes.
    if added < _MATTERS or not low * added <= left - 1.0 <= high * added:
        return False
    larger = -0.5 * count * (np.log(freedom * left) + 1.0)
    rounded = sum(_log_likelihood(residual, moved, freedom) for residual, moved in white)
    return bool(rounded > larger + _CLEARLY)


def _log_likelihood(residual: FloatArray, moved: FloatArray, freedom: float) -> float:
    """Return the log density of whitened residuals (m,) of one stop, moved (m, J), but for a constant."""
    covariance = freedom * (np.eye(len(residual)) + moved @ moved.T)
    _, log_size = np.linalg.slogdet(covariance)
    return -0.5 * float(log_size + residual @ np.linalg.solve(covariance, residual))
