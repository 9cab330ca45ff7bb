"""Derivatives of predicted positions, orientations and lengths in the parameters, and trials.

A port moves the tool nest p by its screw (`kinematics.chain`), the foot b of a length by the motion of its
fixture. With e = (p - b) / |p - b| a length |p - b| changes by

    e . (dp - db)    and what the instrument reads too much.

A parameter moves a nest by the sum over its terms of weight * (motion of p per unit of the port); what the
instrument sees of a point u that moves by du, with s, c, T, d as in `evaluation`, is

    dp = T ((1 + s) du + ds (u - c)) + w x (p - d) + dd

with w the turn that its angles make. Orientations change by the axes of the same screws.

They are taken at the torques in force and with the masses where they are: that a torque or a weight's lever
itself changes with a parameter is left out (a hundredth of the derivative at most), not of the prediction
(docs/decisions/0003).
"""

from dataclasses import replace

import numpy as np

from truepose.domain.arrays import FloatArray, distinct_values
from truepose.effects.ports import ParameterSpec, Port, PortKind, Term, motion_port
from truepose.effects.registry import compliant_effects, effect_named
from truepose.identification.model.evaluation import State, instrument_place, rows_of, six_components
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

    Parameters
    ----------
    state : State
        At n targets.

    Returns
    -------
    ndarray, shape (P, n, 3)
        In mm per internal unit of each parameter; parameters of legs (anchors, offset) have zeros.
    """
    return seen_jacobian(state, state.unscaled_mm, place_jacobian(state))


def mean_variance(jacobian: FloatArray, covariance: FloatArray) -> FloatArray:
    """Return the mean over d components of the variance that uncertain parameters give predictions.

    Parameters
    ----------
    jacobian : ndarray, shape (P, n, d)
        Derivatives of n predictions, per unit of each parameter.
    covariance : ndarray, shape (P, P)
        Of the parameters.

    Returns
    -------
    ndarray, shape (n,)
        trace(J^T C J) / d, in the squared unit of the predictions. Never below 0, which a covariance written
        with few digits may give; NaN where it is not known.
    """
    parameters, n, d = jacobian.shape
    flat = jacobian.reshape(parameters, n * d)
    squares = np.einsum("pm,pm->m", flat, covariance @ flat)
    return np.asarray(np.maximum(squares.reshape(n, d).mean(axis=1), 0.0))


def place_jacobian(state: State) -> FloatArray:
    """Differentiate where the nests are, whatever the instrument sees, in the parameters.

    Parameters
    ----------
    state : State
        At n targets.

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
        Motion of the points per parameter [mm per internal unit]; written over.

    Returns
    -------
    ndarray, shape (P, n, 3)
        The same of what is seen, lengths and frame of the instrument included.
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
    # An instrument under trial stands still: its turn is the identity, and the product is saved.
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
    # Only kinds that some term asks for: each is a product over all joints and rows.
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
            # Only readings of that nest move with it; its coordinates are along the axes of the flange frame.
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
        # The slope of the gear at the load that is there, not torque over angle from rest.
        for joint in {term.port.number for term in state.terms if term.port.kind is PortKind.TORQUE}
    }


def softness_of(state: State, joint: int) -> FloatArray:
    """Return how far a joint turns per torque at its load.

    Parameters
    ----------
    state : State
        At n targets.
    joint : int
        0-based.

    Returns
    -------
    ndarray, shape (n,)
        Sum over the effects by which it yields [rad/(N mm)]; 0 if it is rigid.
    """
    load = None
    if state.torque_n_mm is not None:
        load = state.torque_n_mm[:, joint] + state.moved.get(Port(PortKind.TORQUE, joint), 0.0)
        # A torque that was not measured turned no joint in the prediction either.
        load = np.nan_to_num(load, nan=0.0)
    softness = np.zeros(len(state.targets))
    for name, effect in compliant_effects().items():
        if name in state.structure.effects:
            softness += effect.softness(state.structure.names, state.values, joint, load)
    return softness


def rotation_jacobian(state: State) -> FloatArray:
    """Differentiate the orientation of the tool in the parameters, as rotation vectors in the world.

    Parameters
    ----------
    state : State
        At n targets.

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
        # Shifts of bodies, of nests and of links turn nothing: they have no axis.
        case PortKind.MOTION if port.number % 6 >= 3:
            body = port.number // 6
            _, axes = turned_axes(state.motions[body][:, 3:])
            rotation, _about = chain.body(body)
            axis = np.einsum("nij,nj->ni", rotation, axes[port.number % 6 - 3])
    return axis


def moved_feet(state: State, feet_mm: FloatArray) -> FloatArray:
    """Return where the base nest of each leg is once its fixture has moved.

    Parameters
    ----------
    state : State
        At n legs.
    feet_mm : ndarray, shape (n, 3)
        Where they were before.

    Returns
    -------
    ndarray, shape (n, 3)
        [mm], world frame.
    """
    motion = _fixture_motion(state)
    if motion is None:
        return feet_mm
    turn, _ = turned_axes(motion[:, 3:])
    return np.asarray(np.einsum("nij,nj->ni", turn, feet_mm) + motion[:, :3])


def foot_gradient(state: State, component: int) -> FloatArray:
    """Return how the base nests move per component of the places that they had before.

    Parameters
    ----------
    state : State
        At n legs.
    component : int
        0 to 2, of the world.

    Returns
    -------
    ndarray, shape (n, 3)
        mm per mm: a column of the turn of each fixture.
    """
    motion = _fixture_motion(state)
    if motion is None:
        return np.broadcast_to(np.eye(3)[component], (len(state.targets), 3))
    turn, _ = turned_axes(motion[:, 3:])
    return turn[:, :, component]


def excess_mm(state: State) -> FloatArray | float:
    """Return what each length reads too much [mm], shape (n,); 0 where no effect says so."""
    return state.moved.get(Port(PortKind.LENGTH, 0), 0.0)


def length_jacobian(state: State, feet_mm: FloatArray) -> FloatArray:
    """Differentiate the lengths in the parameters of effects.

    Parameters
    ----------
    state : State
        At n legs.
    feet_mm : ndarray, shape (n, 3)
        Base nests before their fixtures moved.

    Returns
    -------
    ndarray, shape (P, n)
        In mm per internal unit of each parameter; those of anchors and offset have zeros.
    """
    feet = moved_feet(state, feet_mm)
    arm = state.position_mm - feet
    direction = arm / np.linalg.norm(arm, axis=1)[:, None]
    jacobian = np.einsum("pni,ni->pn", position_jacobian(state), direction)
    for term in state.terms:
        if term.port.kind is PortKind.LENGTH:
            jacobian[term.parameter] += term.weight
        # A base nest that comes along the leg shortens it, hence the sign.
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
    # Each placement of the fixture has a motion of its own; legs of others do not know of it.
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


_TRIAL = "trial"


def candidate_terms(state: State, effect: str, names: tuple[str, ...], first: int) -> tuple[Term, ...]:
    """Return the terms of parameters of an effect that may not be in the model.

    Parameters
    ----------
    state : State
        At n targets, with the loads in force.
    effect : str
    names : tuple of str
        Of its parameters.
    first : int
        Number of the first of them in the terms.
    """
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
    # Bodies and instruments that stood still so far need axes to be turned about.
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
    """Return the part (p, ...) of derivatives (P + p, ...) that belongs to the p further parameters."""
    return derivatives[len(state.structure.specs) :]
