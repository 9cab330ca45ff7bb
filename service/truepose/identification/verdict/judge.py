"""A model against readings: the one judge, of any kind of observation, and its statistics.

*Pure error* is what repeat measurements say about repeatability and about the model. Readings of one nest in
one configuration and its revisits differ by noise and scatter alone. Their variance needs no model; the
model's residuals r beyond it are lack of fit (N. R. Draper, H. Smith, Applied Regression Analysis, 3rd ed.,
1998, section 2.1). With m the mean of the residuals of each group of repeats,

    within = sum |r - m|^2        lack = sum |r|^2 - within
    F = (lack / lack_dof) / (within / pure_dof)

*Discrepancy.* What residuals show per component beyond all that was to be expected of them:

    d^2 = mean of |r|^2 / d - (stated variance + scatter^2 + variance of the prediction)        0 at least

Who identifies, validates, diagnoses or reports holds a model against readings here, the one place that asks
of which kind they are. What answers for a kind is imported where it comes: most campaigns have one.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.campaign import LegReadings, PointReadings, Readings, Stops, sites
from truepose.domain.identification import Model, NominalAndIdentified, PureError, Statistics
from truepose.domain.last_moves import with_moves
from truepose.identification.distributions import carlson_rg, f_exceeded
from truepose.identification.model.derivatives import mean_variance, position_jacobian
from truepose.identification.model.estimates import (
    Estimate,
    check_targets,
    identified_estimate,
    nominal_estimate,
)
from truepose.identification.model.prediction import lacking_variance, unknown_variance, unpredictable_at
from truepose.identification.model.structure import Structure
from truepose.identification.observations.blocks import BlockResult, ObservationBlock
from truepose.identification.observations.poses import position_block
from truepose.messages.message import Message


def statistics(residual_mm: FloatArray, noise_mm: float) -> Statistics:
    """Statistics of the norms of residuals.

    Parameters
    ----------
    residual_mm : ndarray, shape (n, d)
        n >= 1.
    noise_mm : float
        Mean norm expected from the stated uncertainties alone.

    Returns
    -------
    Statistics
        [mm]; a single residual has a standard deviation of 0.
    """
    norms = np.linalg.norm(residual_mm, axis=1)
    return Statistics(
        n=len(norms),
        mean_mm=float(norms.mean()),
        rms_mm=float(np.sqrt((norms**2).mean())),
        # Of norms, as the thesis states its position errors.
        sd_mm=float(norms.std(ddof=1)) if len(norms) > 1 else 0.0,
        max_mm=float(norms.max()),
        noise_mm=noise_mm,
    )


def expected_noise_mm(block: ObservationBlock) -> float:
    """Return the mean norm of the residuals that readings and the arm's scatter alone would give.

    Parameters
    ----------
    block : ObservationBlock
        n readings of d components.

    Returns
    -------
    float
        [mm]; without the discrepancy, which no instrument states.
    """
    return mean_norm(block.covariance() + block.scatter_mm**2 * np.eye(block.components))


def mean_norm(covariance: FloatArray) -> float:
    r"""Mean length of normal vectors, averaged over n covariances.

    E|x| = sqrt(8 / pi) R_G(l1, l2, l3) with the eigenvalues l of the covariance and Carlson's
    completely symmetric integral of the second kind (NIST DLMF 19.16.3: R_G is the mean of
    sqrt(u^T L u) over the unit sphere); of a single component sqrt(2 l / pi).

    Parameters
    ----------
    covariance : ndarray, shape (n, d, d)
        With d of 1 or 3 [mm2 or rad2].

    Returns
    -------
    float
        [mm or rad]; NaN where one of them is not known.
    """
    if not np.isfinite(covariance).all():
        return float("nan")
    if covariance.shape[-1] == 1:
        return float(np.sqrt(2.0 / np.pi) * np.sqrt(covariance[:, 0, 0]).mean())
    # Rounding may leave an eigenvalue of a flat ellipsoid a little below 0.
    eigenvalues = np.maximum(np.linalg.eigvalsh(covariance), 0.0)
    return float(np.sqrt(8.0 / np.pi) * carlson_rg(eigenvalues).mean())


_NOTHING_MM2 = 1e-12  # readings of a simulator without noise: there is no pure error to compare with


def pure_error(block: ObservationBlock, residual_mm: FloatArray, absorbed: float) -> PureError | None:
    """Compare lack of fit with pure error.

    Parameters
    ----------
    block : ObservationBlock
        With the weights of the fit: readings that do not count take no part.
    residual_mm : ndarray, shape (n, d)
        Of the identified model.
    absorbed : float
        How many readings' worth the model's parameters absorb. Fewer than there are parameters: those that
        their priors hold would take degrees of freedom from the lack of fit and make too much of it.

    Returns
    -------
    PureError or None
        None without revisits, with fewer than 3 degrees of freedom of them or none of lack of fit, and where
        repeats agree to rounding.
    """
    repeat_of = block.targets.stops.repeat_of
    if repeat_of is None or not np.any(repeat_of >= 0):
        return None
    # A revisit counts as the configuration that it revisits.
    site = sites(block.targets.stops)
    # A gross reading is no repeat: its group would say that the arm scatters.
    kept = block.counts
    keys = np.stack([site, *block.ends()], axis=1)[kept]
    _, group, sizes = np.unique(keys, axis=0, return_inverse=True, return_counts=True)
    residual = residual_mm[kept]
    means = np.stack([np.bincount(group.ravel(), column) / sizes for column in residual.T], axis=1)
    within = float(((residual - means[group.ravel()]) ** 2).sum())
    pure_dof = block.components * int((sizes - 1).sum())
    lack_dof = block.components * len(residual) - absorbed - pure_dof
    if pure_dof < 3 or lack_dof < 1 or within < _NOTHING_MM2:
        return None
    lack = float((residual**2).sum()) - within
    ratio = (lack / lack_dof) / (within / pure_dof)
    return PureError(
        revisits=int((sizes - 1).sum()),
        degrees_of_freedom=pure_dof,
        repeatability_mm=float(np.sqrt(within / pure_dof)),
        lack_of_fit_ratio=ratio,
        p_value=f_exceeded(ratio, lack_dof, pure_dof),
    )


def observation_block(readings: Readings, scatter_mm: float, structure: Structure) -> ObservationBlock:
    """Return readings as observations of a model.

    Parameters
    ----------
    readings : PointReadings, LegReadings or ContactReadings
    scatter_mm : float
        Of the arm per axis, beside what the readings state.
    structure : Structure
        Of the model that they are held against.

    Returns
    -------
    ObservationBlock
        With unit weights.

    Raises
    ------
    ConfigurationError
        A leg is from a cup, or a contact against a target, that the model does not know.
    """
    if isinstance(readings, PointReadings):
        return position_block(readings, scatter_mm)
    if isinstance(readings, LegReadings):
        from truepose.identification.observations.legs import leg_block

        return leg_block(readings, scatter_mm, structure.anchors)
    from truepose.identification.observations.contacts import contact_block

    return contact_block(readings, scatter_mm, structure.targets)


USUAL = 25.0  # typical squares; readings as far out as those found gross say nothing of the model


@dataclass(frozen=True, slots=True)
class Assessment:
    """n readings of d components against two models.

    Attributes
    ----------
    block : ObservationBlock
    nominal, identified : BlockResult
        Residuals and derivatives of each model.
    variance : ndarray, shape (n,)
        Per component, of the identified predictions [mm2 or rad2].
    """

    block: ObservationBlock
    nominal: BlockResult
    identified: BlockResult
    variance: FloatArray

    @property
    def stops(self) -> Stops:
        """Where the arm stood."""
        return self.block.targets.stops

    @property
    def nominal_mm(self) -> FloatArray:
        """Residuals of the nominal model: observed minus predicted, shape (n, d)."""
        return self.nominal.residual

    @property
    def identified_mm(self) -> FloatArray:
        """Residuals of the identified model, shape (n, d)."""
        return self.identified.residual

    @property
    def position_mm(self) -> FloatArray:
        """Places of the nests as the identified model predicts them, world frame, shape (n, 3)."""
        return self.identified.state.position_mm

    @property
    def places_mm(self) -> FloatArray:
        """Places of the nests as they were read, world frame, shape (n, 3); of lengths there are none."""
        places = self.block.place_mm
        return np.zeros((0, 3)) if places is None else places

    @property
    def noise_variance(self) -> FloatArray:
        """Variance per component of each reading as stated, the arm's scatter included, shape (n,)."""
        return np.asarray(self.block.component_variance() + self.block.scatter_mm**2)

    def pair(self, rows: BoolArray | None = None) -> NominalAndIdentified:
        """Return the statistics before and after.

        Parameters
        ----------
        rows : ndarray of bool, shape (n,), optional
            Of these readings alone.
        """
        kept = np.ones(len(self.variance), dtype=bool) if rows is None else rows
        # Expected of the same readings: those left out may be the noisy ones.
        noise = expected_noise_mm(self.block.taken(np.flatnonzero(kept)))
        return NominalAndIdentified(
            statistics(self.nominal_mm[kept], noise), statistics(self.identified_mm[kept], noise)
        )

    def claimed_mm(self) -> float:
        """Return the mean error that noise, scatter and what is said of the predictions let expect [mm]."""
        own = self.variance + self.block.scatter_mm**2
        return mean_norm(self.block.covariance() + own[:, None, None] * np.eye(self.block.components))

    def discrepancy_mm(self) -> float:
        """Return what residuals show per component beyond noise, scatter and parameters' share [mm]; >= 0."""
        squared = (self.identified_mm**2).mean(axis=1)
        # One reading far off would stand for a model that lacks as much everywhere.
        usual = squared <= USUAL * float(np.median(squared))
        beyond = squared - (self.noise_variance + self.variance)
        return float(np.sqrt(max(float(beyond[usual].mean()), 0.0)))

    def vectors_mm(self, residual_mm: FloatArray) -> FloatArray:
        """Return residuals as vectors in the world: those of legs lie along the leg.

        Parameters
        ----------
        residual_mm : ndarray, shape (n, d)

        Returns
        -------
        ndarray, shape (n, 3)
            [mm]
        """
        along = self.identified.direction
        return residual_mm if along is None else residual_mm * along


def judge_estimates(block: ObservationBlock, nominal: Estimate, identified: Estimate) -> Assessment:
    """Hold two models against readings.

    Parameters
    ----------
    block : ObservationBlock
        Of any kind; numbered as the models number what it was read from.
    nominal, identified : Estimate

    Returns
    -------
    Assessment
        Its variance is that of the identified parameters alone.
    """
    # Each from its own torques: the arms stand apart.
    before, after = (block.result(model.structure, model.values, None) for model in (nominal, identified))
    return Assessment(block, before, after, mean_variance(after.jacobian, identified.covariance))


def judge(model: Model, readings: Readings, scatter_mm: float) -> Assessment:
    """Hold a model and its nominal robot against readings.

    What the model lacks, and what rows do not tell, adds to the variance of its predictions.

    Parameters
    ----------
    model : Model
    readings : PointReadings, LegReadings or ContactReadings
        n >= 1 readings.
    scatter_mm : float
        Of the arm per axis, beside what the readings state.

    Returns
    -------
    Assessment

    Raises
    ------
    ConfigurationError
        The readings do not fit the model: another number of joints, an unknown nest or cup, no torques.
    """
    identified = identified_estimate(model)
    block = _observed(model, readings, scatter_mm, identified.structure)
    found = judge_estimates(block, nominal_estimate(model), identified)
    state = found.identified.state
    lacking = lacking_variance(model, state, position_jacobian(state)) + unknown_variance(model, state)
    return replace(found, variance=found.variance + lacking)


def unpredictable_readings(model: Model, readings: Readings) -> tuple[Message, ...]:
    """Return one sentence for every effect whose part in some of the readings is not known well.

    Parameters
    ----------
    model : Model
    readings : PointReadings, LegReadings or ContactReadings

    Raises
    ------
    ConfigurationError
        The readings do not fit the model, as of `judge`.
    """
    structure = identified_estimate(model).structure
    return unpredictable_at(model, _observed(model, readings, 0.0, structure).targets)


def _observed(model: Model, readings: Readings, scatter_mm: float, structure: Structure) -> ObservationBlock:
    told = replace(readings, stops=with_moves(readings.stops))
    block = observation_block(told, scatter_mm, structure)
    check_targets(model, block.targets)
    return block
