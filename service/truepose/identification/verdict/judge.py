"""A model against readings: the one judge, of any kind of observation, before and after identification.

Who identifies, validates, diagnoses or reports holds a model against readings here.
"""

from dataclasses import dataclass, replace

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray
from truepose.domain.measurement.campaign import Readings, Stops
from truepose.domain.measurement.last_moves import told_moves
from truepose.domain.results.identification import Model, NominalAndIdentified
from truepose.domain.sentences import Sentence
from truepose.identification.model.derivatives import mean_variance, place_jacobian
from truepose.identification.model.estimates import (
    Estimate,
    check_targets,
    identified_estimate,
    nominal_estimate,
)
from truepose.identification.model.parameters.structure import Structure
from truepose.identification.model.prediction import unknown_variance, unpredictable_at
from truepose.identification.model.validity.shortfall import lacking_variance
from truepose.identification.observations.blocks import Block, BlockResult
from truepose.identification.observations.observed import observed
from truepose.identification.verdict.statistics import expected_noise_mm, mean_norm, statistics

USUAL = 25.0  # typical squares; readings as far out as those found gross say nothing of the model


@dataclass(frozen=True, slots=True)
class Judged:
    """n readings of d components against two models."""

    block: Block
    nominal: BlockResult
    identified: BlockResult
    variance: FloatArray  # (n,) per component, of the identified predictions [mm2 or rad2]

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
        """Return the statistics before and after, of some of the readings (n,) alone where asked."""
        kept = np.ones(len(self.variance), dtype=bool) if rows is None else rows
        noise = expected_noise_mm(self.block.taken(np.flatnonzero(kept)))
        return NominalAndIdentified(
            statistics(self.nominal_mm[kept], noise), statistics(self.identified_mm[kept], noise)
        )

    def claimed_mm(self) -> float:
        """Return the mean error that noise, scatter and what is said of the predictions let expect."""
        own = self.variance + self.block.scatter_mm**2
        return mean_norm(self.block.covariance() + own[:, None, None] * np.eye(self.block.components))

    def discrepancy_mm(self) -> float:
        """Return what residuals show per component beyond noise, scatter and the parameters' share."""
        squared = (self.identified_mm**2).mean(axis=1)
        usual = squared <= USUAL * float(np.median(squared))
        beyond = squared - (self.noise_variance + self.variance)
        return float(np.sqrt(max(float(beyond[usual].mean()), 0.0)))

    def vectors_mm(self, residual_mm: FloatArray) -> FloatArray:
        """Return residuals as vectors in the world, shape (n, 3): those of legs lie along the leg."""
        along = self.identified.direction
        return residual_mm if along is None else residual_mm * along


def judge_estimates(block: Block, nominal: Estimate, identified: Estimate) -> Judged:
    """Hold two models against readings.

    Parameters
    ----------
    block : Block
        Of any kind; numbered as the models number what it was read from.
    nominal, identified : Estimate

    Returns
    -------
    Judged
    """
    before, after = (block.result(model.structure, model.values, None) for model in (nominal, identified))
    return Judged(block, before, after, mean_variance(after.jacobian, identified.covariance))


def judge(model: Model, readings: Readings, scatter_mm: float) -> Judged:
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
    Judged

    Raises
    ------
    ConfigurationError
        The readings do not fit the model: another number of joints, an unknown nest or cup, no torques.
    """
    identified = identified_estimate(model)
    block = _observed(model, readings, scatter_mm, identified.structure)
    found = judge_estimates(block, nominal_estimate(model), identified)
    state = found.identified.state
    lacking = lacking_variance(model, state, place_jacobian(state)) + unknown_variance(model, state)
    return replace(found, variance=found.variance + lacking)


def unpredictable_readings(model: Model, readings: Readings) -> tuple[Sentence, ...]:
    """Return one sentence for every effect whose part in some of the readings is not known well."""
    structure = identified_estimate(model).structure
    return unpredictable_at(model, _observed(model, readings, 0.0, structure).targets)


def _observed(model: Model, readings: Readings, scatter_mm: float, structure: Structure) -> Block:
    told = replace(readings, stops=told_moves(readings.stops))
    block = observed(told, scatter_mm, structure)
    check_targets(model, block.targets)
    return block
