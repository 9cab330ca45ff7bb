"""What a model lacks at targets: small functions of single joints that readings show beside it.

The model is used without them. Where they would take it, and what is not known of them, is part of its
uncertainty: a known effect that is not corrected for counts with its square (JCGM 100:2008, F.2.4.5). The
parameters have taken over what they could of each function, which the function no longer does.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray
from truepose.domain.results.identification import Model, Parameter, Shortfall
from truepose.effects.ports import ParameterSpec, PortKind, Rows
from truepose.effects.registry import effect_named
from truepose.identification.model.derivatives import mean_variance
from truepose.identification.model.evaluation import State, rows_of
from truepose.kinematics.chain import theta_gradient


class Function(NamedTuple):
    """A parameter of an effect that turns joints, and nothing else."""

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
    told = np.zeros(stops.joints_rad.shape, dtype=np.int64) if stops.direction is None else stops.direction
    return rows._replace(stops=replace(stops, direction=np.where(told == 0, 1, told)))


def lacking_variance(model: Model, state: State, jacobian: FloatArray) -> FloatArray:
    """Return the variance per axis of what the model lacks, mean of the three, shape (n,) [mm2].

    Parameters
    ----------
    model : Model
    state : State
        At n targets.
    jacobian : ndarray, shape (P, n, 3)
        How the parameters move the nests there.
    """
    if model.shortfall is None:
        return np.full(len(state.targets), model.discrepancy_mm**2)
    return shortfall_variance(model.shortfall, state, jacobian)


def shortfall_variance(short: Shortfall, state: State, jacobian: FloatArray) -> FloatArray:
    """Return the variance per axis of a shortfall, shape (n,) [mm2]; parameters as of `lacking_variance`."""
    if not short.functions:
        return np.full(len(state.targets), short.rest_mm**2)
    own, _ = function_columns(tuple(map(_function, short.functions)), state)
    left = own.reshape(len(own), -1) - short.absorbed.T @ jacobian.reshape(len(jacobian), own[0].size)
    known = np.array([one.value for one in short.functions])
    spread = mean_variance(left.reshape(own.shape), short.covariance + np.outer(known, known))
    return np.asarray(spread + short.rest_mm**2)


def _function(parameter: Parameter) -> Function:
    spec = ParameterSpec(parameter.name, parameter.unit, 0.0, parameter.prior_width)
    return Function(parameter.effect, spec)
