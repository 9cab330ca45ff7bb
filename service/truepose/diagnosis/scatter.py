"""Scatter that depends on something: noise that is larger far away, late, or at one nest than elsewhere.

What a model lacks moves like readings alike; scatter does not. So it is looked for in what the extended model
leaves, with what has no name described too. With y the length of a reading's whitened
residual of d components, over what normal noise of the stated size makes it on the average, and u a variable
stretched to -1 .. 1,

    y = exp(b_0 + b_1 u + b_2 u^2) e,        of numbered things exp(b_k),

with errors e of mean 1. Whether y depends on u is told by the F test of a linear regression (Glejser), with
the level shared by all variables; how, by quasi-likelihood with a variance that goes as the mean squared.

Lengths rather than squares or logarithms: the former are carried by heavy tails, the latter by residuals that
are close to nothing. Gross readings take no part, so that one in ten spoiled readings of a nest are outliers
that gather there and not its scatter.

References
----------
H. Glejser, J. American Statistical Association 64, 1969, 316-323.
R. J. Carroll, D. Ruppert, Transformation and Weighting in Regression, 1988, chapter 3.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.special import gammaln

from truepose.diagnosis.distributions import f_exceeded
from truepose.domain.arrays import BoolArray, FloatArray, distinct_values
from truepose.domain.campaign import Campaign, PointReadings, Readings
from truepose.domain.diagnosis import Scatter, ScatterVariable
from truepose.effects.causes import has_spread
from truepose.effects.names import joint_subject
from truepose.identification.fit.robust import RobustFit
from truepose.identification.observations.poses import position_block

_LEVEL = 0.003  # chance that noise which is alike everywhere seems to depend on anything
_MATTERS = 1.5  # times as large at one end as at the other
_FEWEST = 30  # readings: fewer tell no scatter apart
_FEWEST_OF_EACH = 8  # readings of a nest, mounting or placement
_MOST_THINGS = 12
_TAIL = 0.05  # of the readings at either end, that a statement about the ends does not rest on
_ROUNDS = 25
_FAR_ABOVE = 2.0  # of the mean: the length of a residual that is not gross seldom lies as far above


@dataclass(frozen=True, slots=True)
class _Over:
    """A variable of n readings.

    Attributes
    ----------
    name : ScatterVariable
    value : ndarray, shape (n,)
        In the unit in which it is told.
    subject : str
        The joint of an angle, else "".
    numbered : bool
        Whether it numbers things.
    """

    name: ScatterVariable
    value: FloatArray
    subject: str = ""
    numbered: bool = False


@dataclass(frozen=True, slots=True)
class ScatterModel:
    """By how much the noise of a reading exceeds what it states, over one variable.

    Attributes
    ----------
    told : Scatter
    knots : ndarray, shape (2,) or (k,)
        Ends of the variable, or the numbers of the things.
    coefficients : ndarray, shape (3,) or (k,)
        Of the logarithm of the scale.
    base_mm : ndarray, shape (3,)
        From where reach counts, in the world.
    """

    told: Scatter
    knots: FloatArray
    coefficients: FloatArray
    base_mm: FloatArray

    def scale(self, readings: Readings, campaign: Campaign) -> FloatArray:
        """Return what multiplies the standard uncertainty of readings, shape (n,); 1 where unknown.

        Never less than 1: what is stated may hold what all readings share, which residuals do not show.
        """
        over = _like(self.told, readings, campaign, self.base_mm)
        scale = np.ones(len(readings))
        if over is None:
            return scale
        known = np.isfinite(over.value) & (not over.numbered or np.isin(over.value, self.knots))
        log_scale = _design(over.value[known], self.knots, over.numbered) @ self.coefficients
        scale[known] = np.maximum(np.exp(log_scale), 1.0)
        return scale


def telling_scatter(fit: RobustFit, campaign: Campaign) -> ScatterModel | None:
    """Return on what the scatter of the readings depends.

    Parameters
    ----------
    fit : RobustFit
        Of the extended model, what has no name described too.
    campaign : Campaign
        Whose readings it was fitted to.

    Returns
    -------
    ScatterModel or None
        Over the most telling variable; None where none tells, or where nobody stated an uncertainty.
    """
    block, readings = fit.blocks[0], campaign.readings
    counts = block.counts & ~fit.gross[0]
    if readings is None or block.stated_sigma() == 0.0 or int(counts.sum()) < _FEWEST:
        return None
    base_mm = np.asarray(fit.results[0].state.chain.base_origin.mean(axis=0))
    lengths = _standardised(fit)
    tried = [
        (over, usable)
        for over in _variables(readings, campaign, base_mm)
        if (usable := _usable(over, counts)) is not None
    ]
    tests = [_test(lengths[usable], over.value[usable], over.numbered) for over, usable in tried]
    best = min(range(len(tests)), key=tests.__getitem__, default=None)
    if best is None or len(tests) * tests[best] > _LEVEL:
        return None
    over, usable = tried[best]
    # Where readings scatter most, some are gross by the measure of the others.
    everything = _usable(over, np.ones(len(readings), dtype=bool))
    usable = usable if everything is None else everything
    model = _fitted(over, lengths[usable], usable, block.stated_sigma(), base_mm)
    told = replace(model.told, p_value=min(1.0, len(tests) * tests[best]))
    return replace(model, told=told) if told.high_mm >= _MATTERS * told.low_mm else None


def with_scatter(campaign: Campaign, model: ScatterModel) -> Campaign:
    """Return a campaign whose readings are as uncertain as they scatter, those that judge it too.

    Parameters
    ----------
    campaign : Campaign
    model : ScatterModel
    """
    changes: dict[str, Any] = {}
    for table in ("calibration", "validation", "legs", "validation_legs", "contacts", "validation_contacts"):
        readings: Readings | None = getattr(campaign, table)
        if readings:
            changes[table] = _widened(readings, model.scale(readings, campaign), campaign.scatter_mm)
    return replace(campaign, **changes)


def _widened(readings: Readings, scale: FloatArray, scatter_mm: float) -> Readings:
    """Return readings whose noise, that of the arm included, is `scale` times as large, shape (n,)."""
    of_arm = (scale**2 - 1.0) * scatter_mm**2  # what the arm adds to each is added elsewhere, once
    if isinstance(readings, PointReadings):
        covariance = scale[:, None, None] ** 2 * position_block(readings, scatter_mm).covariance_mm2
        return replace(readings, covariance_mm2=covariance + of_arm[:, None, None] * np.eye(3))
    variance = scale**2 * readings.standard_uncertainty_mm**2 + of_arm
    return replace(readings, standard_uncertainty_mm=np.sqrt(variance))


def _variables(readings: Readings, campaign: Campaign, base_mm: FloatArray) -> Iterator[_Over]:
    """Yield what the scatter of readings may depend on; what is unknown of a reading is NaN."""
    stops = readings.stops
    if isinstance(readings, PointReadings):
        yield _Over("reach", np.linalg.norm(readings.position_mm - base_mm, axis=1))
        if campaign.tracker_position_mm is not None:
            sight = readings.position_mm - np.array(campaign.tracker_position_mm)
            yield _Over("range", np.linalg.norm(sight, axis=1))
    for joint, angle in enumerate(np.rad2deg(stops.joints_rad).T):
        yield _Over("angle", angle, joint_subject(joint))
    if stops.time_s is not None:
        yield _Over("time", stops.time_s)
    if stops.temperature_c is not None:
        yield _Over("temperature", stops.temperature_c)
    yield _Over("nest", readings.nest.astype(float), numbered=True)
    if stops.attachment is not None:
        yield _Over("mounting", stops.attachment.astype(float), numbered=True)
    placement = getattr(readings, "placement", None)
    if placement is not None:
        yield _Over("placement", placement.astype(float), numbered=True)


def _like(told: Scatter, readings: Readings, campaign: Campaign, base_mm: FloatArray) -> _Over | None:
    """Return the variable of a statement at readings; None where nobody knows it of these."""
    over = _variables(readings, campaign, base_mm)
    return next((one for one in over if (one.name, one.subject) == (told.variable, told.subject)), None)


def _usable(over: _Over, counts: BoolArray) -> BoolArray | None:
    """Return the readings (n,) that may tell of a variable; None where too few do."""
    usable = counts & np.isfinite(over.value)
    if over.numbered:
        things, many = np.unique(over.value[usable], return_counts=True)
        things = things[many >= _FEWEST_OF_EACH]
        usable &= np.isin(over.value, things)
        enough = 2 <= len(things) <= _MOST_THINGS
    else:
        enough = has_spread(over.value[usable])
    return usable if enough and int(usable.sum()) >= _FEWEST else None


def _standardised(fit: RobustFit) -> FloatArray:
    """Return the length of each whitened residual over its mean in normal noise of the stated size, (n,)."""
    block, result = fit.blocks[0], fit.results[0]
    n, d = result.residual.shape
    # Against what is stated: a discrepancy that the fit added to all readings would hide what some have more.
    stated = block.weighted(np.ones(n), 0.0).rewhitened(result)
    jacobian = result.white_jacobian  # as the fit weighed them: leverages are of it
    taken = np.einsum("pm,pq,qm->m", jacobian, fit.solution.covariance, jacobian, optimize=True)
    freedom = np.maximum(1.0 - taken.reshape(n, d).mean(axis=1), 0.05)
    length = np.linalg.norm(stated.white_residual.reshape(n, d), axis=1)
    usual = np.sqrt(2.0) * np.exp(gammaln(0.5 * (d + 1)) - gammaln(0.5 * d))
    return np.asarray(length / (usual * np.sqrt(freedom)))


def _knots(value: FloatArray, numbered: bool) -> FloatArray:
    """Return the numbers of the things that there are, or the ends of a variable."""
    return distinct_values(value) if numbered else value[[np.argmin(value), np.argmax(value)]]


def _design(value: FloatArray, knots: FloatArray, numbered: bool) -> FloatArray:
    """Return a column for each thing, or constant, linear and quadratic ones that stay within the ends."""
    if numbered:
        return np.asarray(value[:, None] == knots, dtype=float)
    low, high = knots.tolist()
    u = np.clip((2.0 * value - low - high) / (high - low), -1.0, 1.0)
    return np.column_stack([np.ones_like(u), u, u**2])


def _test(lengths: FloatArray, value: FloatArray, numbered: bool) -> float:
    """Return the chance that lengths (m,) which depend on nothing follow a variable (m,) as much."""
    design = _design(value, _knots(value, numbered), numbered)
    coefficients, _, rank, _ = np.linalg.lstsq(design, lengths)
    left = float(((lengths - design @ coefficients) ** 2).sum())
    without = float(((lengths - lengths.mean()) ** 2).sum())
    above, below = int(rank) - 1, len(lengths) - int(rank)
    if above < 1 or left <= 0.0:
        return 1.0
    return float(f_exceeded((without - left) / above / (left / below), above, below))


def _fitted(
    over: _Over, lengths: FloatArray, usable: BoolArray, sigma_mm: float, base_mm: FloatArray
) -> ScatterModel:
    """Return how lengths (m,) of the usable readings (n,) go with a variable."""
    value = over.value[usable]
    knots = _knots(value, over.numbered)
    design = _design(value, knots, over.numbered)
    coefficients = _log_scale(design, lengths)
    log_scale = design @ coefficients
    low, high = np.quantile(value, [_TAIL, 1.0 - _TAIL]) if not over.numbered else knots[[0, -1]]
    within = np.flatnonzero((value >= low) & (value <= high))
    least, most = within[np.argmin(log_scale[within])], within[np.argmax(log_scale[within])]
    begin = float(knots[0]) if over.name == "time" else 0.0
    told = Scatter(
        variable=over.name,
        subject=over.subject,
        at_low=float(value[least]) - begin,
        low_mm=sigma_mm * float(np.exp(log_scale[least])),
        at_high=float(value[most]) - begin,
        high_mm=sigma_mm * float(np.exp(log_scale[most])),
        p_value=1.0,
    )
    return ScatterModel(told, knots, coefficients, base_mm)


def _log_scale(design: FloatArray, lengths: FloatArray) -> FloatArray:
    """Return b of lengths (m,) whose mean is exp(design b) and whose spread goes with it: scoring steps."""
    coefficients = np.linalg.lstsq(design, np.full(len(lengths), np.log(lengths.mean())))[0]
    for _ in range(_ROUNDS):
        # Of a length far above its mean the linear step leads much too far, and never back.
        off = np.clip(lengths * np.exp(-design @ coefficients) - 1.0, -1.0, _FAR_ABOVE)
        step = np.linalg.lstsq(design, off)[0]
        coefficients = coefficients + step
        if float(np.abs(step).max()) < 1e-8:
            break
    return np.asarray(coefficients)
