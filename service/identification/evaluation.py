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
from service.effects.names import joint_name
from service.effects.ports import Port, PortKind, Rows, Term, motion_port
from service.effects.registry import effect_named
from service.identification.structure import Structure, base_axes
from service.kinematics.chain import (
    Chain,
    LinkValues,
    alpha_gradient,
    beta_gradient,
    body_gradients,
    forward,
    nominal_values,
    theta_gradient,
    theta_gradient_of,
)
from service.kinematics.frames import cross, turned_axes
from service.kinematics.gravity import gravity_torques

_MOST_PASSES = 4  # each brings the torques closer by a factor of about a thousand
_BALANCED = 1e-5  # of the largest torque: a deflection of 0.1 deg is then right to 2e-8 rad


@dataclass(frozen=True, slots=True)
class Targets:
    """Where a prediction is asked for: n stops and the nest at each, of legs what else they depend on."""

    stops: Stops
    nest: IntArray  # (n,)
    placement: IntArray | None = None  # (n,) of the base fixture
    initialisation: IntArray | None = None  # (n,) of the ballbar
    length_mm: FloatArray | None = None  # (n,) as read

    def __len__(self) -> int:
        return len(self.stops)


@dataclass(frozen=True, slots=True)
class State:
    """The evaluated model at n targets, ready to be differentiated."""

    structure: Structure
    targets: Targets
    values: FloatArray  # (P,)
    terms: tuple[Term, ...]  # parameter indices are those of the structure
    chain: Chain
    base_origin_mm: FloatArray  # (3,)
    base_axes: FloatArray  # (3, 3) in rows
    tool_rotation: FloatArray  # (3, 3)
    tool_axes: FloatArray  # (3, 3) in rows, last frame
    scale: float  # relative error of the instrument's lengths
    unscaled_mm: FloatArray  # (n, 3) where the nest is
    position_mm: FloatArray  # (n, 3) where the instrument sees it
    motions: dict[int, FloatArray]  # of bodies that move, (n, 6) each
    instrument_motion: FloatArray | None  # (n, 6); None where no parameter moves it
    moved: dict[Port, FloatArray | float]  # every port that a parameter moves
    torque_n_mm: FloatArray | None  # (n, J)

    @property
    def orientation(self) -> FloatArray:
        """Orientation of the tool in the world, shape (n, 3, 3)."""
        turned: FloatArray = self.chain.end_rotation @ self.tool_rotation
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
    if measured is not None or not _is_loaded(structure):
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


def _is_loaded(structure: Structure) -> bool:
    return any("torque" in effect_named(name).needs for name in structure.effects)


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
    terms, moved = _loaded_terms(structure, values, _rows(structure, targets, torque, previous))
    rotation, axes = base_axes(structure.base_rotation, _triple(moved, PortKind.BASE, 3))
    origin = structure.base_origin_mm + _triple(moved, PortKind.BASE, 0)
    tool_rotation, tool_axes = base_axes(structure.tool_rotation, _triple(moved, PortKind.TOOL_ROTATION, 0))
    motions = _motions(moved, len(targets))
    chain = forward(_displaced(nominal, moved), rotation, origin, motions)
    unscaled = chain.points(_nests(structure, moved, targets.nest))
    scale = float(moved.get(Port(PortKind.SCALE, 0), 0.0))
    instrument_motion = _six(moved, PortKind.INSTRUMENT, 0, len(targets))
    return State(
        structure=structure,
        targets=targets,
        values=values,
        terms=terms,
        chain=chain,
        base_origin_mm=origin,
        base_axes=axes,
        tool_rotation=tool_rotation,
        tool_axes=tool_axes,
        scale=scale,
        unscaled_mm=unscaled,
        position_mm=_seen(unscaled, scale, _instrument(structure), instrument_motion),
        motions=motions,
        instrument_motion=instrument_motion,
        moved=moved,
        torque_n_mm=torque,
    )


def _rows(structure: Structure, targets: Targets, torque: FloatArray | None, chain: Chain) -> Rows:
    return Rows(
        stops=targets.stops,
        nest=targets.nest,
        torque_n_mm=torque,
        turn_rad=targets.stops.joints_rad * np.array([row.sign for row in structure.robot.joints]),
        chain=chain,
        gravity_m_s2=structure.gravity_m_s2,
        robot=structure.robot,
        origin_s=structure.origin_s,
        initialisation=targets.initialisation,
        placement=targets.placement,
        length_mm=targets.length_mm,
    )


def _loaded_terms(
    structure: Structure, values: FloatArray, rows: Rows
) -> tuple[tuple[Term, ...], dict[Port, FloatArray | float]]:
    """Terms and moved ports, gearboxes loaded by what effects add to the torque too."""
    terms = collect_terms(structure, rows)
    moved = _moved_ports(terms, values)
    added = {port.number: load for port, load in moved.items() if port.kind is PortKind.TORQUE}
    if rows.torque_n_mm is None or not any(np.any(load) for load in added.values()):
        return terms, moved
    torque = rows.torque_n_mm.copy()
    for joint, load in added.items():
        torque[:, joint] += load
    terms = collect_terms(structure, rows._replace(torque_n_mm=torque))
    return terms, _moved_ports(terms, values)


def _motions(moved: dict[Port, FloatArray | float], n: int) -> dict[int, FloatArray]:
    bodies = sorted({port.number // 6 for port in moved if port.kind is PortKind.MOTION})
    found = {body: _six(moved, PortKind.MOTION, 6 * body, n) for body in bodies}
    return {body: motion for body, motion in found.items() if motion is not None}


def _six(moved: dict[Port, FloatArray | float], kind: PortKind, first: int, n: int) -> FloatArray | None:
    ports = [Port(kind, first + k) for k in range(6)]
    if not any(port in moved for port in ports):
        return None
    return np.stack([np.broadcast_to(moved.get(port, 0.0), n) for port in ports], axis=1)


def _seen(points: FloatArray, scale: float, instrument: FloatArray, motion: FloatArray | None) -> FloatArray:
    scaled: FloatArray = points + scale * (points - instrument)
    if motion is None:
        return scaled
    turn, _ = turned_axes(motion[:, 3:])
    seen: FloatArray = np.einsum("nij,nj->ni", turn, scaled) + motion[:, :3]
    return seen


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


def _nests(structure: Structure, moved: dict[Port, FloatArray | float], nest: IntArray) -> FloatArray:
    shifts = np.array([moved.get(Port(PortKind.NEST, k), 0.0) for k in range(structure.nests_mm.size)])
    moved_nests: FloatArray = structure.nests_mm + shifts.reshape(-1, 3)
    return moved_nests[nest - 1]


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
    if state.instrument_motion is not None:
        _see_through_instrument(state, state.instrument_motion, jacobian)
    return jacobian


def _see_through_instrument(state: State, motion: FloatArray, jacobian: FloatArray) -> None:
    """Turn the derivatives with the instrument's frame, and add those of the frame's own motion."""
    turn, axes = turned_axes(motion[:, 3:])
    jacobian[:] = np.einsum("nij,pnj->pni", turn, jacobian)
    for term in state.terms:
        if term.port.kind is PortKind.INSTRUMENT:
            component = term.port.number
            own = (
                np.broadcast_to(np.eye(3)[component], motion[:, :3].shape)
                if component < 3
                else cross(axes[component - 3], state.position_mm - motion[:, :3])
            )
            jacobian[term.parameter] += _weighted(term.weight, own)


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
    gradients[Port(PortKind.SCALE, 0)] = points - _instrument(state.structure)
    return gradients


def _base_gradients(state: State) -> dict[Port, FloatArray]:
    arms = state.unscaled_mm - state.base_origin_mm
    shifts = {Port(PortKind.BASE, k): np.broadcast_to(np.eye(3)[k], arms.shape) for k in range(3)}
    turns = {Port(PortKind.BASE, 3 + k): cross(state.base_axes[k], arms) for k in range(3)}
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
        term.port: softness * theta_gradient_of(state.chain, state.unscaled_mm, term.port.number)
        for term in state.terms
        if term.port.kind is PortKind.TORQUE
        for softness in (softness_of(state.structure, state.values, term.port.number),)
    }


def softness_of(structure: Structure, values: FloatArray, joint: int) -> float:
    """Return the linear compliance of a joint (0-based) in the model, 0 where it has none [rad/(N mm)]."""
    name = joint_name("c", joint)
    return float(values[structure.index_of(name)]) if name in structure.names else 0.0


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
            axis = chain.end_rotation @ state.tool_axes[port.number]
        case PortKind.TORQUE:
            axis = softness_of(state.structure, state.values, port.number) * chain.z[port.number]
        case PortKind.MOTION if port.number % 6 >= 3:
            body = port.number // 6
            _, axes = turned_axes(state.motions[body][:, 3:])
            rotation, _about = chain.body(body)
            axis = np.einsum("nij,nj->ni", rotation, axes[port.number % 6 - 3])
    return axis
