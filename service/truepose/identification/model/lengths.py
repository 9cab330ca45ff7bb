"""Lengths from base nests to tool nests: what moves the base nests, and what a length reads too much."""

import numpy as np

from truepose.domain.arrays import FloatArray, distinct_values
from truepose.effects.ports import Port, PortKind
from truepose.identification.model.derivatives import position_jacobian
from truepose.identification.model.evaluation import State, six_components
from truepose.kinematics.frames import cross, turned_axes


def moved_feet(state: State, feet_mm: FloatArray) -> FloatArray:
    """Return where the base nest of each leg is once its fixture has moved, shape (n, 3) in and out."""
    motion = _fixture_motion(state)
    if motion is None:
        return feet_mm
    turn, _ = turned_axes(motion[:, 3:])
    return np.asarray(np.einsum("nij,nj->ni", turn, feet_mm) + motion[:, :3])


def foot_gradient(state: State, component: int) -> FloatArray:
    """Return how the base nests move per component of the places that they had before, shape (n, 3)."""
    motion = _fixture_motion(state)
    if motion is None:
        return np.broadcast_to(np.eye(3)[component], (len(state.targets), 3))
    turn, _ = turned_axes(motion[:, 3:])
    return turn[:, :, component]


def excess_mm(state: State) -> FloatArray | float:
    """Return what each length reads too much, shape (n,), 0 where no effect says so."""
    return state.moved.get(Port(PortKind.LENGTH, 0), 0.0)


def length_jacobian(state: State, feet_mm: FloatArray) -> FloatArray:
    """Differentiate the lengths in the parameters of effects, shape (P, n) [mm per unit].

    Parameters
    ----------
    state : State
        At n legs.
    feet_mm : ndarray, shape (n, 3)
        Base nests before their fixtures moved.
    """
    feet = moved_feet(state, feet_mm)
    arm = state.position_mm - feet
    direction = arm / np.linalg.norm(arm, axis=1)[:, None]
    jacobian = np.einsum("pni,ni->pn", position_jacobian(state), direction)
    for term in state.terms:
        if term.port.kind is PortKind.LENGTH:
            jacobian[term.parameter] += term.weight
        elif term.port.kind is PortKind.FIXTURE:
            moved = _fixture_gradient(state, term.port.number, feet)
            jacobian[term.parameter] -= term.weight * np.einsum("ni,ni->n", moved, direction)
    return np.asarray(jacobian)


def _fixture_motion(state: State) -> FloatArray | None:
    """Motion of the fixture of each leg, shape (n, 6); None where none moves."""
    placement = state.targets.placement
    if placement is None or not any(port.kind is PortKind.FIXTURE for port in state.moved):
        return None
    motion = np.zeros((len(state.targets), 6))
    for number in distinct_values(placement).tolist():
        own = six_components(state.moved, PortKind.FIXTURE, 6 * (number - 1), len(state.targets))
        if own is not None:
            motion[placement == number] = own[placement == number]
    return motion


def _fixture_gradient(state: State, number: int, feet_mm: FloatArray) -> FloatArray:
    """Return the motion of the base nests per component of a fixture's motion, shape (n, 3)."""
    placement = state.targets.placement
    if placement is None:
        return np.zeros_like(feet_mm)
    motion = _fixture_motion(state)
    motion = np.zeros((len(feet_mm), 6)) if motion is None else motion
    _, axes = turned_axes(motion[:, 3:])
    index, component = divmod(number, 6)
    if component < 3:
        own = np.broadcast_to(np.eye(3)[component], feet_mm.shape)
    else:
        own = cross(axes[component - 3], feet_mm - motion[:, :3])
    return np.where((placement == index + 1)[:, None], own, 0.0)
