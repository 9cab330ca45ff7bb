"""Trials: what further parameters would do to the predictions of a fitted model, without fitting them."""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.ports import ParameterSpec, PortKind, Term
from truepose.effects.registry import effect_named
from truepose.identification.model.evaluation import State, rows_of

_TRIAL = "trial"


def candidate_terms(state: State, effect: str, names: tuple[str, ...], first: int) -> tuple[Term, ...]:
    """Return the terms of parameters `names` of an effect, numbered from `first`."""
    terms = effect_named(effect).terms(names, rows_of(state))
    return tuple(Term(first + parameter, port, weight) for parameter, port, weight in terms)


def tried(state: State, specs: tuple[ParameterSpec, ...], terms: tuple[Term, ...]) -> State:
    """Return the state with further parameters at zero, and their terms alone.

    Its derivatives are those of the further parameters (zero for the present ones).

    Parameters
    ----------
    state : State
    specs : tuple of ParameterSpec
        The further parameters.
    terms : tuple of Term
        How they act; parameter 0 is the first of them.
    """
    present = len(state.structure.specs)
    n = len(state.targets)
    bodies = {term.port.number // 6 for term in terms if term.port.kind is PortKind.MOTION}
    still = {body: np.zeros((n, 6)) for body in bodies - set(state.motions)}
    instrument = state.instrument_motion
    if instrument is None and any(term.port.kind is PortKind.INSTRUMENT for term in terms):
        instrument = np.zeros((n, 6))
    trial = tuple(Term(present + parameter, port, weight) for parameter, port, weight in terms)
    return replace(
        state,
        structure=state.structure.extended(_TRIAL, specs),
        values=np.concatenate([state.values, np.zeros(len(specs))]),
        told=lambda: trial,
        motions=state.motions | still,
        instrument_motion=instrument,
    )


def trial_derivatives(derivatives: FloatArray, state: State) -> FloatArray:
    """Return the part of the derivatives that belongs to the further parameters."""
    return derivatives[len(state.structure.specs) :]
