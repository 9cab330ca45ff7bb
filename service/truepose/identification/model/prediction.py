"""Prediction with an identified model: positions, and how well they are known."""

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.measurement.campaign import Stops
from truepose.domain.measurement.last_moves import told_moves
from truepose.domain.results.identification import Model
from truepose.domain.sentences import Sentence
from truepose.identification.model.derivatives import (
    mean_variance,
    place_jacobian,
    position_jacobian,
    rotation_jacobian,
)
from truepose.identification.model.estimates import check_targets, structure_of, values_of
from truepose.identification.model.evaluation import State, Targets, evaluate
from truepose.identification.model.validity.beyond import held, held_variance
from truepose.identification.model.validity.missing import left_out, left_out_variance, span_of
from truepose.identification.model.validity.shortfall import lacking_variance


def predict(model: Model, stops: Stops, nest: IntArray) -> tuple[FloatArray, FloatArray]:
    """Predict nest positions.

    Parameters
    ----------
    model : Model
    stops : Stops
        n configurations.
    nest : ndarray, shape (n,)
        1-based.

    Returns
    -------
    position_mm : ndarray, shape (n, 3)
        World frame.
    standard_uncertainty_mm : ndarray, shape (n,)
        Per axis, root mean square of the three: covariance of the parameters, scatter of the arm, the
        discrepancy that held-out residuals showed, and of effects that a row does not tell enough about, or
        that nobody followed as far (`unpredictable`), what they usually do; not the noise of a reading.

    Raises
    ------
    ConfigurationError
        Another number of joints, an unknown nest, or measured torques that the model needs are missing.
    """
    targets = Targets(told_moves(stops), nest)
    check_targets(model, targets)
    state = evaluate(structure_of(model), values_of(model), targets)
    jacobian = position_jacobian(state)
    variance = mean_variance(jacobian, model.covariance) + unknown_variance(model, state)
    total = variance + model.repeatability_mm**2 + lacking_variance(model, state, jacobian)
    return state.position_mm, np.sqrt(total)


def placed_variance(model: Model, state: State) -> FloatArray:
    """Return the variance per axis of where the nests are, mean of the three, shape (n,) [mm2].

    As that of predictions, but for what only concerns the instrument: whoever sends a tool somewhere wants
    it there, not seen there.
    """
    jacobian = place_jacobian(state)
    variance = mean_variance(jacobian, model.covariance) + unknown_variance(model, state)
    return np.asarray(variance + model.repeatability_mm**2 + lacking_variance(model, state, jacobian))


def turned_variance(model: Model, state: State) -> FloatArray:
    """Return the variance per axis of the last frame's turn, of the parameters alone, shape (n,) [rad2]."""
    jacobian = rotation_jacobian(state)
    return mean_variance(jacobian, model.covariance)


def unpredictable(model: Model, stops: Stops) -> tuple[Sentence, ...]:
    """Return one sentence for every effect whose part in the positions of some rows is not known well."""
    return unpredictable_at(model, Targets(told_moves(stops), np.ones(len(stops), dtype=np.int64)))


def unpredictable_at(model: Model, targets: Targets) -> tuple[Sentence, ...]:
    """Return one sentence for every effect whose part in some of the predictions is not known well."""
    structure = structure_of(model)
    return left_out(structure, targets) + held(structure, targets)


def unknown_variance(model: Model, state: State) -> FloatArray:
    """Return the variance per axis of what rows do not tell, or nobody followed, shape (n,) [mm2]."""
    structure, values, targets = state.structure, state.values, state.targets
    missing = left_out_variance(structure, values, targets, state.position_mm, span_of(model.identified_from))
    return np.asarray(missing + held_variance(structure, values, model.covariance, targets))
