"""Predictions: effects move ports, the chain turns ports into positions; `derivatives` differentiates them.

The torques that load the gearboxes are those at the deflected arm, found by repeating the forward
kinematics until they balance.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, Table
from truepose.domain.campaign import Stops
from truepose.effects.ports import Port, PortKind, Rows, Term, known_frames
from truepose.effects.registry import needs_of
from truepose.identification.model.structure import Structure, base_axes
from truepose.identification.model.terms import Acting, with_added_loads
from truepose.kinematics.chain import Chain, LinkValues, forward, nominal_values
from truepose.kinematics.frames import turned_axes
from truepose.kinematics.gravity import gravity_torques

_MOST_PASSES = 4
_BALANCED = 1e-5  # of the largest torque: a deflection of 0.1 deg is then right to 2e-8 rad
# Each pass brings the torques closer by a factor of about a thousand: after such a change one more is enough.
_NEARLY_BALANCED = 2e-3


@dataclass(frozen=True, slots=True)
class Targets(Table):
    """Where a prediction is asked for: n stops and the nest at each, of legs what else they depend on."""

    stops: Stops
    nest: IntArray  # (n,)
    placement: IntArray | None = None  # (n,) of the base fixture
    initialisation: IntArray | None = None  # (n,) of the ballbar
    length_mm: FloatArray | None = None  # (n,) as read
    fixed_mm: FloatArray | None = None  # (n, 3) world: what stands there, where it is not the tool

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

    def seen(self, points_mm: FloatArray) -> FloatArray:
        """Return where the instrument sees points (n, 3) of the world, at the times of the targets."""
        instrument = instrument_place(self.structure)
        return _seen(points_mm, self.scale, instrument, self.instrument_motion)


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
    nominal = nominal_values(structure.robot, targets.stops.joints_rad)
    measured = targets.stops.torque_n_mm if structure.torques_measured else None
    unloaded = cache(partial(forward, nominal, structure.base_rotation, structure.base_origin_mm))
    rows = _rows(structure, targets, measured, unloaded)
    loaded = measured is None and _is_loaded(structure)
    if loaded and previous:
        rows = rows._replace(torque_n_mm=previous.torque_n_mm, frames=known_frames(previous.chain))
    acting = Acting(structure, values, rows)
    state = _evaluate_loaded(acting, targets, nominal, rows)
    for _ in range(_MOST_PASSES if loaded else 0):
        torque = _gravity(structure, state.chain)
        change = _change(torque, state.torque_n_mm)
        if change > _BALANCED:
            rows = rows._replace(torque_n_mm=torque, frames=known_frames(state.chain))
            state = _evaluate_loaded(acting, targets, nominal, rows)
        if change <= _NEARLY_BALANCED:
            break
    return state


def _is_loaded(structure: Structure) -> bool:
    return any("torque" in needs_of(name, structure.names_of(name)) for name in structure.effects)


def _change(torque: FloatArray | None, before: FloatArray | None) -> float:
    """Return by how much of the largest torque some torque has changed.

    Without masses there are none: it is levers that follow the chain, and once is enough.
    """
    if torque is None:
        return _NEARLY_BALANCED
    if before is None:
        return np.inf
    largest = float(np.abs(torque).max(initial=0.0))
    return float(np.abs(torque - before).max(initial=0.0)) / largest if largest else 0.0


def _gravity(structure: Structure, chain: Chain) -> FloatArray | None:
    if not structure.robot.masses:
        return None
    return gravity_torques(chain, structure.robot.masses, structure.gravity_m_s2)


def _evaluate_loaded(acting: Acting, targets: Targets, nominal: LinkValues, rows: Rows) -> State:
    structure, values = acting.structure, acting.values
    terms, moved = acting.under_load(rows)
    rotation, axes = base_axes(structure.base_rotation, _triple(moved, PortKind.BASE, 3))
    origin = structure.base_origin_mm + _triple(moved, PortKind.BASE, 0)
    tool_rotation, tool_axes = base_axes(structure.tool_rotation, _triple(moved, PortKind.TOOL_ROTATION, 0))
    motions = _motions(moved, len(targets))
    chain = forward(_displaced(nominal, moved), rotation, origin, motions)
    unscaled = chain.points(nest_centres(structure, moved)[targets.nest - 1])
    scale = float(moved.get(Port(PortKind.SCALE, 0), 0.0))
    instrument_motion = six_components(moved, PortKind.INSTRUMENT, 0, len(targets))
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
        position_mm=_seen(unscaled, scale, instrument_place(structure), instrument_motion),
        motions=motions,
        instrument_motion=instrument_motion,
        moved=moved,
        torque_n_mm=rows.torque_n_mm,
    )


def _rows(
    structure: Structure, targets: Targets, torque: FloatArray | None, frames: Callable[[], Chain]
) -> Rows:
    return Rows(
        stops=targets.stops,
        nest=targets.nest,
        torque_n_mm=torque,
        turn_rad=targets.stops.joints_rad * np.array([row.sign for row in structure.robot.joints]),
        frames=frames,
        gravity_m_s2=structure.gravity_m_s2,
        robot=structure.robot,
        origin_s=structure.origin_s,
        last_s=structure.last_s,
        initialisation=targets.initialisation,
        placement=targets.placement,
        length_mm=targets.length_mm,
        instrument_mm=structure.instrument_mm,
        nests_mm=structure.nests_mm,
        fixed_mm=targets.fixed_mm,
    )


def rows_of(state: State) -> Rows:
    """Return the rows that effects see at a state, with the loads in force.

    Gravity's are there also where the model has no spring that they could wind up: one may be tried.
    """
    torque = _gravity(state.structure, state.chain) if state.torque_n_mm is None else state.torque_n_mm
    rows = _rows(state.structure, state.targets, torque, known_frames(state.chain))
    return rows if torque is None else rows._replace(torque_n_mm=with_added_loads(torque, state.moved))


def _motions(moved: dict[Port, FloatArray | float], n: int) -> dict[int, FloatArray]:
    bodies = sorted({port.number // 6 for port in moved if port.kind is PortKind.MOTION})
    found = {body: six_components(moved, PortKind.MOTION, 6 * body, n) for body in bodies}
    return {body: motion for body, motion in found.items() if motion is not None}


def six_components(
    moved: dict[Port, FloatArray | float], kind: PortKind, first: int, n: int
) -> FloatArray | None:
    """Return what six ports in a row are moved by, shape (n, 6); None where none of them is moved."""
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


def _triple(moved: dict[Port, FloatArray | float], kind: PortKind, first: int) -> FloatArray:
    return np.array([moved.get(Port(kind, first + k), 0.0) for k in range(3)], dtype=float)


def nest_centres(structure: Structure, moved: dict[Port, FloatArray | float]) -> FloatArray:
    """Return the tool nests with what moves them, last frame, shape (K, 3) [mm]."""
    shifts = np.array([moved.get(Port(PortKind.NEST, k), 0.0) for k in range(structure.nests_mm.size)])
    centres: FloatArray = structure.nests_mm + shifts.reshape(-1, 3)
    return centres


def instrument_place(structure: Structure) -> FloatArray:
    """Return where the instrument stands, the world's origin where that is unknown, shape (3,) [mm]."""
    return np.zeros(3) if structure.instrument_mm is None else structure.instrument_mm


def _displaced(nominal: LinkValues, moved: dict[Port, FloatArray | float]) -> LinkValues:
    shifts: defaultdict[PortKind, dict[int, FloatArray | float]] = defaultdict(dict)
    for port, shift in moved.items():
        shifts[port.kind][port.number] = shift
    return LinkValues(
        alpha_rad=_shifted(nominal.alpha_rad, shifts[PortKind.ALPHA]),
        a_mm=_shifted(nominal.a_mm, shifts[PortKind.A]),
        beta_rad=_shifted(nominal.beta_rad, shifts[PortKind.BETA]),
        theta_rad=_shifted(nominal.theta_rad, shifts[PortKind.THETA]),
        d_mm=_shifted(nominal.d_mm, shifts[PortKind.D]),
    )


def _shifted(start: FloatArray, shifts: dict[int, FloatArray | float]) -> FloatArray:
    """Return link values, (J,) or (n, J), with the joints shifted that are; by rows where one shift is."""
    rows = [shift for shift in shifts.values() if isinstance(shift, np.ndarray)]
    by_joint = start.T if start.ndim == 2 or not rows else np.repeat(start[:, None], len(rows[0]), axis=1)
    by_joint = np.array(by_joint, order="C")
    for joint, shift in shifts.items():
        by_joint[joint] += shift
    return by_joint.T
