"""Prediction with an identified model: positions, and how well they are known.

With J the derivatives of a position in the parameters, C their covariance, and all variances per axis, the
mean of the three, a predicted position has

    u^2 = tr(J^T C J) / 3 + u_unknown^2 + repeatability^2 + u_lacking^2

Readings may show small functions of single joints beside a model: its inadequacy. It is used without them.
Where they would take it, and what is not known of them, is part of its uncertainty: a known effect that is
not corrected for counts with its square (JCGM 100:2008, F.2.4.5). The parameters have taken over what they
could of each function, which the function no longer does: with F how functions of values b and covariance B
move the nests, and K what the parameters absorbed of each,

    u_lacking^2 = tr(L^T (B + b b^T) L) / 3 + rest^2        L = F - K^T J
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.campaign import Stops
from truepose.domain.identification import Model, ModelInadequacy, Parameter
from truepose.domain.last_moves import with_moves
from truepose.effects.ports import ParameterSpec, PortKind, Rows
from truepose.effects.registry import effect_named
from truepose.identification.model.derivatives import (
    mean_variance,
    place_jacobian,
    position_jacobian,
    rotation_jacobian,
)
from truepose.identification.model.estimates import check_targets, structure_of, values_of
from truepose.identification.model.evaluation import State, Targets, evaluate, rows_of
from truepose.identification.model.missing_input_uncertainty import (
    missing_input_sentences,
    missing_input_variance,
    span_of,
)
from truepose.identification.model.validity import held_effect_sentences, held_effect_variance
from truepose.kinematics.chain import theta_gradient
from truepose.messages.message import Message


class Function(NamedTuple):
    """A parameter of an effect that turns joints, and nothing else.

    Attributes
    ----------
    effect : str
    spec : ParameterSpec
    """

    effect: str
    spec: ParameterSpec


def function_columns(functions: tuple[Function, ...], state: State) -> tuple[FloatArray, IntArray]:
    """Return how functions of joints move the nests.

    Parameters
    ----------
    functions : tuple of Function, length c
    state : State
        At n targets. Joints that do not tell from where they came are taken to have come from below: what
        counts is the square, which is the same from above.

    Returns
    -------
    columns : ndarray, shape (c, n, 3)
        In mm per internal unit of each.
    joint : ndarray, shape (c,)
        0-based.
    """
    # A function turns one joint, so that its lever is that of the joint: no evaluation a function is needed.
    columns = np.zeros((len(functions), len(state.targets), 3))
    joint = np.zeros(len(functions), dtype=np.int64)
    lever, rows = theta_gradient(state.chain, state.unscaled_mm), _with_ways(rows_of(state))
    for effect in dict.fromkeys(one.effect for one in functions):
        own = [k for k, one in enumerate(functions) if one.effect == effect]
        for term in effect_named(effect).terms(tuple(functions[k].spec.name for k in own), rows):
            if term.port.kind is PortKind.THETA:
                weight = np.broadcast_to(term.weight, len(state.targets))
                joint[own[term.parameter]] = term.port.number
                columns[own[term.parameter]] += weight[:, None] * lever[term.port.number]
    return columns, joint


def _with_ways(rows: Rows) -> Rows:
    stops = rows.stops
    # A gap that a target does not tell the side of is still there: left out, it would count for nothing.
    told = np.zeros(stops.joints_rad.shape, dtype=np.int64) if stops.direction is None else stops.direction
    return rows._replace(stops=replace(stops, direction=np.where(told == 0, 1, told)))


def lacking_variance(model: Model, state: State, jacobian: FloatArray) -> FloatArray:
    """Return the variance per axis of what the model lacks, mean of the three.

    Parameters
    ----------
    model : Model
    state : State
        At n targets.
    jacobian : ndarray, shape (P, n, 3)
        How the parameters move the nests there [mm per internal unit].

    Returns
    -------
    ndarray, shape (n,)
        [mm2]; the square of the discrepancy everywhere, where the model describes nothing that it lacks.
    """
    # Of lengths nothing is described: a fit of positions alone has the functions beside it.
    if model.shortfall is None:
        return np.full(len(state.targets), model.discrepancy_mm**2)
    return shortfall_variance(model.shortfall, state, jacobian)


def shortfall_variance(short: ModelInadequacy, state: State, jacobian: FloatArray) -> FloatArray:
    """Return the variance per axis of a shortfall, mean of the three.

    Parameters
    ----------
    short : ModelInadequacy
        c functions, and the rest.
    state : State
        At n targets.
    jacobian : ndarray, shape (P, n, 3)
        How the parameters move the nests there [mm per internal unit].

    Returns
    -------
    ndarray, shape (n,)
        [mm2]
    """
    if not short.functions:
        return np.full(len(state.targets), short.rest_mm**2)
    own, _ = function_columns(tuple(map(_function, short.functions)), state)
    left = own.reshape(len(own), -1) - short.absorbed.T @ jacobian.reshape(len(jacobian), own[0].size)
    # Values count with their square, as predictions are not corrected for them.
    known = np.array([one.value for one in short.functions])
    spread = mean_variance(left.reshape(own.shape), short.covariance + np.outer(known, known))
    return np.asarray(spread + short.rest_mm**2)


def _function(parameter: Parameter) -> Function:
    # From a model file it comes back as a parameter; effects take specs.
    spec = ParameterSpec(parameter.name, parameter.unit, 0.0, parameter.prior_width)
    return Function(parameter.effect, spec)


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
    # Rows in the order of time tell how far each joint came: an effect that asks for it is then not left out.
    targets = Targets(with_moves(stops), nest)
    check_targets(model, targets)
    state = evaluate(structure_of(model), values_of(model), targets)
    jacobian = position_jacobian(state)
    variance = mean_variance(jacobian, model.covariance) + unknown_variance(model, state)
    # What is lacking counts per target: one number for all held 91 % of true errors where 95 % were stated.
    total = variance + model.repeatability_mm**2 + lacking_variance(model, state, jacobian)
    return state.position_mm, np.sqrt(total)


def placed_variance(model: Model, state: State) -> FloatArray:
    """Return the variance per axis of where the nests are, mean of the three.

    As that of predictions, but for what only concerns the instrument: whoever sends a tool somewhere wants
    it there, not seen there.

    Parameters
    ----------
    model : Model
    state : State
        Of that model at n targets.

    Returns
    -------
    ndarray, shape (n,)
        [mm2]: parameters, what rows do not tell, scatter of the arm and what the model lacks.
    """
    # Scale, drift and kick of the instrument move readings, not the tool.
    jacobian = place_jacobian(state)
    variance = mean_variance(jacobian, model.covariance) + unknown_variance(model, state)
    return np.asarray(variance + model.repeatability_mm**2 + lacking_variance(model, state, jacobian))


def turned_variance(model: Model, state: State) -> FloatArray:
    """Return the variance per axis of the flange frame's turn, of the parameters alone, mean of the three.

    Parameters
    ----------
    model : Model
    state : State
        Of that model at n targets.

    Returns
    -------
    ndarray, shape (n,)
        [rad2]; what the model lacks and the scatter of the arm are known in mm only, and not in it.
    """
    jacobian = rotation_jacobian(state)
    return mean_variance(jacobian, model.covariance)


def unpredictable(model: Model, stops: Stops) -> tuple[Message, ...]:
    """Return one sentence for every effect whose part in the positions of some rows is not known well.

    Parameters
    ----------
    model : Model
    stops : Stops
        The rows; which nest does not matter.
    """
    return unpredictable_at(model, Targets(with_moves(stops), np.ones(len(stops), dtype=np.int64)))


def unpredictable_at(model: Model, targets: Targets) -> tuple[Message, ...]:
    """Return one sentence for every effect whose part in some of the predictions is not known well."""
    # First what rows do not tell, then what nobody followed as far.
    structure = structure_of(model)
    return missing_input_sentences(structure, targets) + held_effect_sentences(structure, targets)


def unknown_variance(model: Model, state: State) -> FloatArray:
    """Return the variance per axis of what rows do not tell, or nobody followed, mean of the three.

    Parameters
    ----------
    model : Model
    state : State
        Of that model at n targets.

    Returns
    -------
    ndarray, shape (n,)
        [mm2]; 0 where the rows tell all and are within the time of the readings.
    """
    structure, values, targets = state.structure, state.values, state.targets
    missing = missing_input_variance(
        structure, values, targets, state.position_mm, span_of(model.identified_from)
    )
    return np.asarray(missing + held_effect_variance(structure, values, model.covariance, targets))
