r"""What a fit is worth: errors on configurations left out, and what certificates add to its covariance.

*Cross-validation.* Every configuration is predicted by a model that never saw it. All readings of a
configuration, and of its revisits, are left out together, at the weights of the full fit. From the full
solution a fold is one step of Gauss-Newton away, which needs no new linearisation: with whitened derivatives
J_k and residuals r_k of the readings of fold k, prior precision W and the slope g of the whole cost (zero but
for the solver's tolerance), the parameters without fold k are off the full solution by

    s_k = C_k (g - J_k r_k)        C_k = (W + sum over the other folds of J_l J_l^T)^-1

and a held-out reading by what s_k moves its prediction. What further steps of a refit would change is of the
second order in s_k.

*Consider parameters.* Tool nests and the registration of the world frame are known within a certificate. They
are held at their stated values while identifying; their uncertainty is carried into the covariance of the
parameters afterwards (consider parameters: B. D. Tapley, B. E. Schutz, G. H. Born, Statistical Orbit
Determination, 2004, chapter 6).

References
----------
R. D. Cook, S. Weisberg, Residuals and Influence in Regression, 1982, section 2.2 (deletion formulae).
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, distinct_values
from truepose.domain.campaign import Campaign, FixedNestReadings, sites
from truepose.domain.robot import FixedNest, WorldRegistration, span_triangle
from truepose.effects.frames.tool_certificate import moves
from truepose.identification.fit.robust import RobustFit
from truepose.identification.fit.solver import covariance_of, posterior_covariance, slope
from truepose.identification.observations.blocks import BlockResult, ObservationBlock
from truepose.kinematics.frames import cross_matrix

_LEAVE_ONE_OUT = 40  # up to so many configurations one is left out at a time, beyond it a tenth
_FOLDS = 10


def held_out_residuals(fit: RobustFit) -> tuple[FloatArray, FloatArray]:
    """Residuals of the first block's readings, each predicted without its configuration.

    Parameters
    ----------
    fit : RobustFit
        The full solution with its weights.

    Returns
    -------
    residual : ndarray, shape (n, d)
        Observed minus predicted [mm, or rad of orientations], not whitened.
    variance : ndarray, shape (n,)
        What the uncertainty of the fold's parameters adds per component [mm2 or rad2].

    Notes
    -----
    Up to 40 configurations one is left out at a time, beyond that a tenth of them.
    """
    final, first = fit.solution.final, fit.results[0]
    precision = 1.0 / fit.structure.prior_widths**2
    whole_slope = slope(final, precision, fit.values - fit.structure.prior_means)
    owners = _folds(fit)
    columns = _columns_of_folds(fit, owners)
    parts = [final.jacobian[:, held] for held in columns]
    residual, variance = first.residual.copy(), np.zeros(len(first.residual))
    for fold, covariance in enumerate(_covariances(final.jacobian, columns, parts, precision)):
        held, out = columns[fold], np.flatnonzero(owners[0] == fold)
        # The slope is not quite zero: the solver ends where a step is invisible beside the uncertainty.
        step = covariance @ (whole_slope - parts[fold] @ final.residual[held])
        motion = first.jacobian[:, out].reshape(len(step), first.residual[out].size)  # also of no parameter
        residual[out] -= (step @ motion).reshape(len(out), -1)
        spread = ((covariance @ motion) * motion).sum(axis=0)
        variance[out] = spread.reshape(len(out), -1).mean(axis=1)
    return residual, variance


def _folds(fit: RobustFit) -> list[IntArray]:
    """Return the fold of each reading, (n,) per block; -1 of readings that are never held out."""
    owners = [sites(block.targets.stops) for block in fit.blocks]
    distinct = distinct_values(owners[0])
    if len(distinct) <= _LEAVE_ONE_OUT:
        fold = np.arange(len(distinct))
    else:
        # Shuffled, as neighbours in a file are often neighbours in space; the same folds each time, as the
        # same campaign must give the same figures.
        shuffled = np.random.default_rng(0).permutation(len(distinct))
        fold = np.empty(len(distinct), dtype=np.int64)
        for number, members in enumerate(np.array_split(shuffled, _FOLDS)):
            fold[members] = number
    # Sides, clamped cups and fixed nests have configurations of their own: they stay in every fold.
    places = [np.minimum(np.searchsorted(distinct, owner), len(distinct) - 1) for owner in owners]
    return [
        np.where(distinct[place] == owner, fold[place], -1)
        for place, owner in zip(places, owners, strict=True)
    ]


def _columns_of_folds(fit: RobustFit, owners: list[IntArray]) -> list[IntArray]:
    """Return the stacked observations of each fold, at the end those that are never held out."""
    each = zip(owners, fit.results, strict=True)
    stacked = np.concatenate([np.repeat(owner, result.residual.shape[1]) for owner, result in each])
    numbers = (*range(int(owners[0].max()) + 1), -1)
    return [np.flatnonzero(stacked == number) for number in numbers]


def _covariances(
    jacobian: FloatArray, columns: list[IntArray], parts: list[FloatArray], precision: FloatArray
) -> Iterable[FloatArray]:
    """Return the covariances (P, P) of the parameters without each fold; where one is ill, each by itself."""
    normals = _normals_of_others(parts) + np.diag(precision)
    # All folds in one batch take little more than half the time of one by one.
    together = covariance_of(normals)
    return _one_by_one(jacobian, columns, normals, precision) if together is None else together


def _one_by_one(
    jacobian: FloatArray, columns: list[IntArray], normals: FloatArray, precision: FloatArray
) -> Iterator[FloatArray]:
    for held, normal in zip(columns[:-1], normals, strict=True):
        covariance = covariance_of(normal)
        if covariance is None:
            covariance = posterior_covariance(np.delete(jacobian, held, axis=1), precision)
        yield covariance


def _normals_of_others(parts: list[FloatArray]) -> FloatArray:
    """Return J J^T of all parts but one, for each but the last, shape (folds, P, P).

    As sums of what is left: a difference from the whole would lose the digits of what only one fold sees.
    """
    products = np.stack([part @ part.T for part in parts])
    others: FloatArray = np.tensordot(1.0 - np.eye(len(parts)), products, 1)
    return others[:-1]


@dataclass(frozen=True, slots=True)
class ConsideredCovariances:
    """Covariances of the parameters, term by term; internal units.

    Attributes
    ----------
    readings : ndarray, shape (P, P)
        From the observations and the priors.
    nests : ndarray, shape (P, P)
        Added by the certified tool nests.
    registration : ndarray, shape (P, P)
        Added by the registration of the world frame.
    """

    readings: FloatArray
    nests: FloatArray
    registration: FloatArray

    @property
    def total(self) -> FloatArray:
        """Sum of the three, shape (P, P)."""
        return self.readings + self.nests + self.registration


def propagate_certificates(campaign: Campaign, fit: RobustFit) -> ConsideredCovariances:
    """Carry the certified uncertainties into the covariance of the parameters.

    Parameters
    ----------
    campaign : Campaign
        Whose certificates hold nests and world.
    fit : RobustFit
        Of that campaign.

    Returns
    -------
    ConsideredCovariances
        Three terms; the last two are zero of lengths, whose certified nests are parameters and which know no
        world.

    References
    ----------
    B. D. Tapley, B. E. Schutz, G. H. Born, Statistical Orbit Determination, 2004, chapter 6.
    """
    covariance, gain = fit.solution.covariance, _Gain(fit)
    each = list(zip(fit.blocks, fit.results, strict=True))
    held = _held_nests(campaign, fit)
    nests = gain([_nest_sensitivity(held, block, result) for block, result in each])
    registration = world_registration(campaign)
    if registration is None:
        return ConsideredCovariances(covariance, nests @ nests.T, np.zeros_like(covariance))
    frame = gain([block.moved_by_world(result) for block, result in each])
    return ConsideredCovariances(covariance, nests @ nests.T, frame @ registration.covariance @ frame.T)


class _Gain:
    """Change of the parameters per change of something held: -C J^T W S, summed over the blocks."""

    def __init__(self, fit: RobustFit) -> None:
        self._results = fit.results
        # The same for nests and world.
        self._left = [fit.solution.covariance @ result.white_jacobian for result in fit.results]  # (P, n d)

    def __call__(self, sensitivities: list[FloatArray]) -> FloatArray:
        """Return the gain, shape (P, S), from one sensitivity (S, n, d) per block."""
        gain = np.zeros((len(self._left[0]), len(sensitivities[0])))
        for left, result, sensitivity in zip(self._left, self._results, sensitivities, strict=True):
            white = result.whitening.apply(sensitivity).reshape(len(sensitivity), left.shape[1])
            gain -= left @ white.T
        return gain


def _held_nests(campaign: Campaign, fit: RobustFit) -> dict[int, float]:
    """Return the standard uncertainty [mm] of each certified nest that is no parameter of the fit."""
    # A nest that is free to move within its certificate has its uncertainty in the fit already.
    return {
        number: nest.standard_uncertainty_mm
        for number, nest in enumerate(campaign.nests, start=1)
        if nest.centre_mm is not None
        and nest.standard_uncertainty_mm
        and not moves(number, fit.structure.names)
    }


def _nest_sensitivity(held: dict[int, float], block: ObservationBlock, result: BlockResult) -> FloatArray:
    """Return how predictions move per standard uncertainty of each certified coordinate, (S, n, d)."""
    # Per standard uncertainty, so that the product of gains is their covariance.
    moved = [u_mm * block.moved_by_nest(result, number) for number, u_mm in held.items()]
    return np.concatenate([np.zeros((0, *result.residual.shape)), *moved])


def world_registration(campaign: Campaign) -> WorldRegistration | None:
    """Return how well the world frame is known: as stated, else from the looks at the fixed nests.

    Parameters
    ----------
    campaign : Campaign

    Returns
    -------
    WorldRegistration or None
        Covariance (6, 6) of a small shift [mm] and turn [rad] about the world's origin; None where
        nothing was stated and the fixed nests that were looked at place no frame: fewer than three, or on a
        line.
    """
    if campaign.registration is not None or campaign.reference is None:
        return campaign.registration
    looked_at = set(campaign.reference.fixed_nest.tolist())
    nests = {number: nest for number, nest in enumerate(campaign.fixed_nests, start=1) if number in looked_at}
    # Nests on a line leave open the turn about it, whatever else is certified.
    if len(nests) < 3 or not span_triangle(list(nests.values())):
        return None
    return WorldRegistration(_registration_covariance(campaign.reference, nests))


def _registration_covariance(readings: FixedNestReadings, nests: dict[int, FixedNest]) -> FloatArray:
    normal = np.zeros((6, 6))
    for number, nest in nests.items():
        here = readings.fixed_nest == number
        # Looks average out; the error of the certificate is the same in each and does not.
        mean_variance = 1.0 / float((1.0 / readings.standard_uncertainty_mm[here] ** 2).sum())
        variance = mean_variance + nest.standard_uncertainty_mm**2
        motion = np.hstack([np.eye(3), -cross_matrix(np.array(nest.centre_mm))])
        normal += motion.T @ motion / variance
    return np.asarray(np.linalg.inv(normal))
