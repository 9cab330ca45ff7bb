"""Predictions and their derivatives: effects move ports, the chain turns ports into positions.

The torques that load the gearboxes are those at the deflected arm, found by repeating the forward
kinematics until they balance. Derivatives are taken at the torques in force: that a torque itself
changes with a parameter is left out of them (a hundredth of the derivative at most), not of the prediction.
"""

from collections import defaultdict
from dataclasses import dataclass

import numpy as np

from service.domain.arrays import FloatArray, IntArray
from service.domain.campaign import Stops
from service.effects.ports import Port, PortKind, Rows, Term
from service.effects.registry import effect_named
from service.identification.structure import Structure, base_axes
from service.kinematics.chain import (
    Chain,
    LinkValues,
    alpha_gradient,
    beta_gradient,
    forward,
    nominal_values,
    theta_gradient,
)
from service.kinematics.frames import cross
from service.kinematics.gravity import gravity_torques

_MOST_PASSES = 4  # each brings the torques closer by a factor of about a thousand
_BALANCED = 1e-5  # of the largest torque: a deflection of 0.1 deg is then right to 2e-8 rad


@dataclass(frozen=True, slots=True)
class Targets:
    """Where a prediction is asked for: n stops and the nest at each."""

    stops: Stops
    nest: IntArray  # (n,)

    def __len__(self) -> int:
        return len(self.stops)


@dataclass(frozen=True, slots=True)
class State:
    """The evaluated model at n targets, ready to be differentiated."""

    structure: Structure
    targets: Targets
    terms: tuple[Term, ...]  # parameter indices are those of the structure
    chain: Chain
    base_origin_mm: FloatArray  # (3,)
    base_axes: FloatArray  # (3, 3) in rows
    tool_rotation: FloatArray  # (3, 3)
    tool_axes: FloatArray  # (3, 3) in rows, last frame
    scale: float  # relative error of the instrument's lengths
    unscaled_mm: FloatArray  # (n, 3) before that error
    position_mm: FloatArray  # (n, 3)
    torque_n_mm: FloatArray | None  # (n, J)

    @property
    def orientation(self) -> FloatArray:
        """Orientation of the tool in the world, shape (n, 3, 3)."""
        turned: FloatArray = self.chain.rotation[-1] @ self.tool_rotation
        return turned


def evaluate(
    structure: Structure, values: FloatArray, targets: Targets, previous: State | None = None
) -> State:
    """Predict the nest positions at n targets.

    Parameters
    ----------
    structure : Structure
    values : ndarray, shape (P,)
        Parameter values in internal units.
    targets : Targets
    previous : State, optional
        The same targets at nearby values: its torques are the first guess.

    Returns
    -------
    State
    """
    measured = targets.stops.torque_n_mm if structure.torques_measured else None
    if measured is not None or "compliance" not in structure.effects:
        return _evaluate_loaded(structure, values, targets, measured, None)
    state = previous or _evaluate_loaded(structure, values, targets, None, None)
    torque = previous.torque_n_mm if previous else _gravity(structure, state.chain)
    for _ in range(_MOST_PASSES):
        state = _evaluate_loaded(structure, values, targets, torque, state.chain)
        balanced = _gravity(structure, state.chain)
        if balanced is None or torque is None or _close(balanced, torque):
            break
        torque = balanced
    return state


def _close(torque: FloatArray, before: FloatArray) -> bool:
    largest = float(np.abs(torque).max(initial=0.0))
    return float(np.abs(torque - before).max(initial=0.0)) <= _BALANCED * largest


def _gravity(structure: Structure, chain: Chain) -> FloatArray | None:
    if not structure.robot.masses:
        return None
    return gravity_torques(chain, structure.robot.masses, structure.gravity_m_s2)


def _evaluate_loaded(
    structure: Structure,
    values: FloatArray,
    targets: Targets,
    torque: FloatArray | None,
    previous: Chain | None,
) -> State:
    nominal = nominal_values(structure.robot, targets.stops.joints_rad)
    if previous is None:
        previous = forward(nominal, structure.base_rotation, structure.base_origin_mm)
    turn = targets.stops.joints_rad * np.array([row.sign for row in structure.robot.joints])
    rows = Rows(targets.stops, targets.nest, torque, turn, previous, structure.gravity_m_s2)
    terms = collect_terms(structure, rows)
    moved = _moved_ports(terms, values)
    rotation, axes = base_axes(structure.base_rotation, _triple(moved, PortKind.BASE, 3))
    origin = structure.base_origin_mm + _triple(moved, PortKind.BASE, 0)
    tool_rotation, tool_axes = base_axes(structure.tool_rotation, _triple(moved, PortKind.TOOL_ROTATION, 0))
    chain = forward(_displaced(nominal, moved), rotation, origin)
    unscaled = chain.points(_nests(structure, moved)[targets.nest - 1])
    scale = float(moved.get(Port(PortKind.SCALE, 0), 0.0))
    position = unscaled + scale * (unscaled - _instrument(structure))
    return State(
        structure=structure,
        targets=targets,
        terms=terms,
        chain=chain,
        base_origin_mm=origin,
        base_axes=axes,
        tool_rotation=tool_rotation,
        tool_axes=tool_axes,
        scale=scale,
        unscaled_mm=unscaled,
        position_mm=position,
        torque_n_mm=torque,
    )


def collect_terms(structure: Structure, rows: Rows) -> tuple[Term, ...]:
    """Ask every effect how its parameters act; parameter indices are those of the structure."""
    terms: list[Term] = []
    for effect in structure.effects:
        indices = [k for k, owner in enumerate(structure.owners) if owner == effect]
        names = tuple(structure.specs[k].name for k in indices)
        terms += [
            term._replace(parameter=indices[term.parameter])
            for term in effect_named(effect).terms(names, rows)
        ]
    return tuple(terms)


def _moved_ports(terms: tuple[Term, ...], values: FloatArray) -> dict[Port, FloatArray | float]:
    moved: defaultdict[Port, FloatArray | float] = defaultdict(float)
    for term in terms:
        moved[term.port] = moved[term.port] + term.weight * float(values[term.parameter])
    return dict(moved)


def _triple(moved: dict[Port, FloatArray | float], kind: PortKind, first: int) -> FloatArray:
    return np.array([moved.get(Port(kind, first + k), 0.0) for k in range(3)], dtype=float)


def _nests(structure: Structure, moved: dict[Port, FloatArray | float]) -> FloatArray:
    shifts = [moved.get(Port(PortKind.NEST, k), 0.0) for k in range(structure.nests_mm.size)]
    moved_nests: FloatArray = structure.nests_mm + np.array(shifts, dtype=float).reshape(-1, 3)
    return moved_nests


def _instrument(structure: Structure) -> FloatArray:
    return np.zeros(3) if structure.instrument_mm is None else structure.instrument_mm


def _displaced(nominal: LinkValues, moved: dict[Port, FloatArray | float]) -> LinkValues:
    n, joints = nominal.theta_rad.shape

    def shifted(kind: PortKind, start: FloatArray) -> FloatArray:
        shifts = [moved.get(Port(kind, j), 0.0) for j in range(joints)]
        if all(np.ndim(shift) == 0 for shift in shifts):
            change = np.array(shifts, dtype=float)
        else:
            change = np.stack([np.broadcast_to(shift, n) for shift in shifts], axis=1)
        return np.asarray(start + change)

    return LinkValues(
        alpha_rad=shifted(PortKind.ALPHA, nominal.alpha_rad),
        a_mm=shifted(PortKind.A, nominal.a_mm),
        beta_rad=shifted(PortKind.BETA, nominal.beta_rad),
        theta_rad=shifted(PortKind.THETA, nominal.theta_rad),
        d_mm=shifted(PortKind.D, nominal.d_mm),
    )


def position_jacobian(state: State) -> FloatArray:
    """Differentiate the positions in the parameters.

    Returns
    -------
    ndarray, shape (P, n, 3)
        In mm per internal unit of each parameter; parameters of legs (anchors, offset) have zeros.
    """
    gradients = _position_gradients(state)
    jacobian = np.zeros((len(state.structure.specs), len(state.targets), 3))
    for term in state.terms:
        gradient = gradients.get(term.port)
        if gradient is not None:
            factor = 1.0 if term.port.kind is PortKind.SCALE else 1.0 + state.scale
            jacobian[term.parameter] += _weighted(term.weight, gradient) * factor
    return jacobian


def _weighted(weight: float | FloatArray, gradient: FloatArray) -> FloatArray:
    if isinstance(weight, np.ndarray):
        return weight[:, None] * gradient
    return weight * gradient


def _position_gradients(state: State) -> dict[Port, FloatArray]:
    chain, points = state.chain, state.unscaled_mm
    kinds = {term.port.kind for term in state.terms}
    stacks: dict[PortKind, FloatArray] = {}
    if PortKind.THETA in kinds:
        stacks[PortKind.THETA] = theta_gradient(chain, points)
    if PortKind.ALPHA in kinds:
        stacks[PortKind.ALPHA] = alpha_gradient(chain, points)
    if PortKind.A in kinds:
        stacks[PortKind.A] = chain.x_before
    if PortKind.D in kinds:
        stacks[PortKind.D] = chain.z
    gradients = {
        Port(kind, joint): stack[joint] for kind, stack in stacks.items() for joint in range(len(stack))
    }
    gradients |= {
        term.port: beta_gradient(chain, points, term.port.number)
        for term in state.terms
        if term.port.kind is PortKind.BETA
    }
    gradients |= _base_gradients(state)
    gradients |= _nest_gradients(state)
    gradients[Port(PortKind.SCALE, 0)] = points - _instrument(state.structure)
    return gradients


def _base_gradients(state: State) -> dict[Port, FloatArray]:
    arms = state.unscaled_mm - state.base_origin_mm
    shifts = {Port(PortKind.BASE, k): np.broadcast_to(np.eye(3)[k], arms.shape) for k in range(3)}
    turns = {Port(PortKind.BASE, 3 + k): cross(state.base_axes[k], arms) for k in range(3)}
    return shifts | turns


def _nest_gradients(state: State) -> dict[Port, FloatArray]:
    last = state.chain.rotation[-1]
    gradients: dict[Port, FloatArray] = {}
    for term in state.terms:
        if term.port.kind is PortKind.NEST:
            nest, component = divmod(term.port.number, 3)
            here = (state.targets.nest == nest + 1)[:, None]
            gradients[term.port] = np.where(here, last[:, :, component], 0.0)
    return gradients


def rotation_jacobian(state: State) -> FloatArray:
    """Rotations of the tool per parameter, as rotation vectors in the world.

    Returns
    -------
    ndarray, shape (P, n, 3)
        In rad per internal unit of each parameter.
    """
    jacobian = np.zeros((len(state.structure.specs), len(state.targets), 3))
    for term in state.terms:
        axis = _rotation_axis(state, term.port)
        if axis is not None:
            jacobian[term.parameter] += _weighted(term.weight, np.broadcast_to(axis, jacobian.shape[1:]))
    return jacobian


def _rotation_axis(state: State, port: Port) -> FloatArray | None:
    chain = state.chain
    axis: FloatArray | None = None
    match port.kind:
        case PortKind.THETA:
            axis = chain.z[port.number]
        case PortKind.ALPHA:
            axis = chain.x_before[port.number]
        case PortKind.BETA:
            axis = chain.y_middle[port.number]
        case PortKind.BASE if port.number >= 3:
            axis = state.base_axes[port.number - 3]
        case PortKind.TOOL_ROTATION:
            axis = chain.rotation[-1] @ state.tool_axes[port.number]
    return axis
