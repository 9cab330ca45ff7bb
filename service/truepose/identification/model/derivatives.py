"""Derivatives of predicted positions and orientations in the parameters of the model.

They are taken at the torques in force and with the masses where they are: that a torque or a weight's lever
itself changes with a parameter is left out (a hundredth of the derivative at most), not of the prediction.
"""

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.joints.compliance_nonlinear import softening
from truepose.effects.names import joint_name
from truepose.effects.ports import Port, PortKind, motion_port
from truepose.identification.model.evaluation import State, instrument_place
from truepose.kinematics.chain import (
    alpha_gradient,
    beta_gradient,
    body_gradients,
    theta_gradient,
    theta_gradient_of,
)
from truepose.kinematics.frames import cross, turned_axes


def position_jacobian(state: State) -> FloatArray:
    """Differentiate the positions, as the instrument sees them, in the parameters.

    Returns
    -------
    ndarray, shape (P, n, 3)
        In mm per internal unit of each parameter; parameters of legs (anchors, offset) have zeros.
    """
    return seen_jacobian(state, state.unscaled_mm, place_jacobian(state))


def mean_variance(jacobian: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the mean variance of d components, shape (n,), from (P, n, d) and that of the parameters."""
    parameters, n, d = jacobian.shape
    flat = jacobian.reshape(parameters, n * d)
    squares = np.einsum("pm,pm->m", flat, covariance @ flat)
    return np.asarray(squares.reshape(n, d).mean(axis=1))


def place_jacobian(state: State) -> FloatArray:
    """Differentiate where the nests are, whatever the instrument sees, in the parameters.

    Returns
    -------
    ndarray, shape (P, n, 3)
        In mm per internal unit of each parameter; those of the instrument have zeros.
    """
    gradients = _position_gradients(state)
    jacobian = np.zeros((len(state.structure.specs), len(state.targets), 3))
    for term in state.terms:
        gradient = gradients.get(term.port)
        if gradient is not None:
            jacobian[term.parameter] += _weighted(term.weight, gradient)
    return jacobian


def seen_jacobian(state: State, points_mm: FloatArray, jacobian: FloatArray) -> FloatArray:
    """Differentiate what the instrument sees of points that move by `jacobian` themselves.

    Parameters
    ----------
    state : State
        At n targets.
    points_mm : ndarray, shape (n, 3)
        Where the points are in the world.
    jacobian : ndarray, shape (P, n, 3)
        Motion of the points per parameter; written over.

    Returns
    -------
    ndarray, shape (P, n, 3)
        Lengths and frame of the instrument included.
    """
    if state.scale:
        jacobian *= 1.0 + state.scale
    arms = points_mm - instrument_place(state.structure)
    for term in state.terms:
        if term.port.kind is PortKind.SCALE:
            jacobian[term.parameter] += _weighted(term.weight, arms)
    if state.instrument_motion is None:
        return jacobian
    turn, axes = turned_axes(state.instrument_motion[:, 3:])
    if state.instrument_motion.any():
        jacobian = np.einsum("nij,pnj->pni", turn, jacobian)
    turned = state.seen(points_mm) - state.instrument_motion[:, :3]
    for term in state.terms:
        if term.port.kind is PortKind.INSTRUMENT:
            own = _frame_gradient(term.port.number, axes, turned)
            jacobian[term.parameter] += _weighted(term.weight, own)
    return jacobian


def _frame_gradient(component: int, axes: FloatArray, turned_mm: FloatArray) -> FloatArray:
    if component < 3:
        return np.broadcast_to(np.eye(3)[component], turned_mm.shape)
    return cross(axes[component - 3], turned_mm)


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
    gradients |= _motion_gradients(state)
    gradients |= _torque_gradients(state)
    return gradients


def _base_gradients(state: State) -> dict[Port, FloatArray]:
    arms = state.unscaled_mm - state.base_origin_mm
    shifts = {Port(PortKind.BASE, k): np.broadcast_to(np.eye(3)[k], arms.shape) for k in range(3)}
    turned = cross(state.base_axes[:, None], arms)
    turns = {Port(PortKind.BASE, 3 + k): turned[k] for k in range(3)}
    return shifts | turns


def _nest_gradients(state: State) -> dict[Port, FloatArray]:
    last = state.chain.end_rotation
    gradients: dict[Port, FloatArray] = {}
    for term in state.terms:
        if term.port.kind is PortKind.NEST:
            nest, component = divmod(term.port.number, 3)
            here = (state.targets.nest == nest + 1)[:, None]
            gradients[term.port] = np.where(here, last[:, :, component], 0.0)
    return gradients


def _motion_gradients(state: State) -> dict[Port, FloatArray]:
    return {
        motion_port(body, component): gradient
        for body, motion in state.motions.items()
        for component, gradient in enumerate(body_gradients(state.chain, body, motion, state.unscaled_mm))
    }


def _torque_gradients(state: State) -> dict[Port, FloatArray]:
    """Return what loads do: each turns its own joint by the softness of its gearbox."""
    return {
        Port(PortKind.TORQUE, joint): softness_of(state, joint)[:, None]
        * theta_gradient_of(state.chain, state.unscaled_mm, joint)
        for joint in {term.port.number for term in state.terms if term.port.kind is PortKind.TORQUE}
    }


def softness_of(state: State, joint: int) -> FloatArray:
    """Return how far a joint (0-based) turns per torque at its load, shape (n,) [rad/(N mm)]; 0 if rigid."""
    structure, values = state.structure, state.values
    name = joint_name("c", joint)
    linear = float(values[structure.index_of(name)]) if name in structure.names else 0.0
    if state.torque_n_mm is None:
        return np.full(len(state.targets), linear)
    load = state.torque_n_mm[:, joint] + state.moved.get(Port(PortKind.TORQUE, joint), 0.0)
    return linear + softening(structure.names, values, joint, np.nan_to_num(load, nan=0.0))


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
            axis = chain.y_middle(port.number)
        case PortKind.BASE if port.number >= 3:
            axis = state.base_axes[port.number - 3]
        case PortKind.TOOL_ROTATION:
            axis = chain.end_rotation @ state.tool_axes[port.number]
        case PortKind.TORQUE:
            axis = softness_of(state, port.number)[:, None] * chain.z[port.number]
        case PortKind.MOTION if port.number % 6 >= 3:
            body = port.number // 6
            _, axes = turned_axes(state.motions[body][:, 3:])
            rotation, _about = chain.body(body)
            axis = np.einsum("nij,nj->ni", rotation, axes[port.number % 6 - 3])
    return axis
