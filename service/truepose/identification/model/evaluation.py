"""Predictions: effects move ports, the chain turns ports into positions; `derivatives` differentiates them.

With (R, o) the flange frame of the chain whose ports the parameters have moved (`structure`,
`kinematics.chain`) and x a tool nest in it that ports move by dx, the nest is at

    u = o + R (x + dx)                        `unscaled_mm`

and the instrument, which stands at c, reads lengths too long by the share s, and is moved by (T, d), sees it
at

    p = T (u + s (u - c)) + d                 `position_mm`

The torques that load the gearboxes are those at the deflected arm, found by repeating the forward kinematics
until they balance (docs/decisions/0003): the thesis of A. Nubiola, 2014, annex I, takes them at the
undeflected one, which is off by a micrometre or so.
"""

from collections import defaultdict
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from truepose.domain.arrays import FloatArray, IntArray, Table
from truepose.domain.campaign import Stops
from truepose.effects.ports import Port, PortKind, Rows, Term, known_frames
from truepose.effects.registry import needs_of
from truepose.identification.model.structure import (
    ActiveEffects,
    Structure,
    Told,
    base_axes,
    with_added_loads,
)
from truepose.kinematics.chain import Chain, LinkValues, forward, nominal_values
from truepose.kinematics.frames import turned_axes
from truepose.kinematics.gravity import gravity_torques

_MOST_PASSES = 4
_BALANCED = 1e-5  # of the largest torque: a deflection of 0.1 deg is then right to 2e-8 rad
# Each pass brings the torques closer by a factor of about a thousand: after such a change one more is enough.
_NEARLY_BALANCED = 2e-3


@dataclass(frozen=True, slots=True)
class Targets(Table):
    """Where a prediction is asked for: n stops and the nest at each, of legs what else they depend on.

    Attributes
    ----------
    stops : Stops
        n rows.
    nest : ndarray of int, shape (n,)
        1-based.
    placement : ndarray of int, shape (n,), optional
        Of the base fixture, from 1.
    initialisation : ndarray of int, shape (n,), optional
        Of the ballbar.
    length_mm : ndarray, shape (n,), optional
        As read: what a length reads too much may depend on how long it is.
    fixed_mm : ndarray, shape (n, 3), optional
        World: what stands there, where it is not the tool.
    """

    stops: Stops
    nest: IntArray
    placement: IntArray | None = None
    initialisation: IntArray | None = None
    length_mm: FloatArray | None = None
    fixed_mm: FloatArray | None = None

    def __len__(self) -> int:
        return len(self.stops)


@dataclass(frozen=True, slots=True)
class State:
    """The evaluated model at n targets, ready to be differentiated."""

    structure: Structure
    targets: Targets
    values: FloatArray  # (P,)
    told: Told  # the terms, worked out once somebody asks for them
    chain: Chain
    base_origin_mm: FloatArray  # (3,)
    base_axes: FloatArray  # (3, 3) in rows
    tool_rotation: FloatArray  # (3, 3)
    tool_axes: FloatArray  # (3, 3) in rows, flange frame
    scale: float  # relative error of the instrument's lengths
    unscaled_mm: FloatArray  # (n, 3) where the nest is
    position_mm: FloatArray  # (n, 3) where the instrument sees it
    motions: dict[int, FloatArray]  # of bodies that move, (n, 6) each
    instrument_motion: FloatArray | None  # (n, 6); None where no parameter moves it
    moved: dict[Port, FloatArray | float]  # every port that a parameter moves
    torque_n_mm: FloatArray | None  # (n, J)

    @property
    def terms(self) -> tuple[Term, ...]:
        """How parameters act on ports; their indices are those of the structure."""
        return self.told()

    @property
    def orientation(self) -> FloatArray:
        """Orientation of the tool in the world, shape (n, 3, 3)."""
        turned: FloatArray = self.chain.end_rotation @ self.tool_rotation
        return turned

    def seen(self, points_mm: FloatArray) -> FloatArray:
        """Return where the instrument sees points of the world, at the times of the targets.

        Parameters
        ----------
        points_mm : ndarray, shape (n, 3)
            Where they are, one for each target.

        Returns
        -------
        ndarray, shape (n, 3)
            [mm], world frame.
        """
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
        Under torques that are balanced to 1e-5 of the largest, four passes at most; as measured, where they
        were.
    """
    prediction = _Prediction(structure, values, targets)
    if not prediction.loaded:
        return prediction.under(None)
    # From a nearby state one pass mostly balances what would else take two or three.
    guess = None if previous is None else Load(previous.torque_n_mm, known_frames(previous.chain))
    state = prediction.under(guess)
    for _ in range(_MOST_PASSES):
        load = load_of(state)
        change = _change(load.torque_n_mm, state.torque_n_mm)
        if change > _BALANCED:
            state = prediction.under(load)
        # The pass above has brought them a thousand times closer: to look once more would only cost a pass.
        if change <= _NEARLY_BALANCED:
            break
    return state


class Load(NamedTuple):
    """What winds up the springs of n rows: torques, and the frames in which weights pull.

    Attributes
    ----------
    torque_n_mm : ndarray, shape (n, J), or None
        About each joint; None where there are no masses.
    frames : callable
        Gives the chain of the n rows.
    """

    torque_n_mm: FloatArray | None  # (n, J); None: there are no masses
    frames: Callable[[], Chain]

    def taken(self, rows: IntArray) -> "Load":
        """Return the load of some rows, shape (m,) indices."""
        torque = None if self.torque_n_mm is None else self.torque_n_mm[rows]
        return Load(torque, cache(lambda: self.frames().taken(rows)))

    def with_torques(self, rows: IntArray, others: "Load | None") -> "Load":
        """Return the load with the torques of some rows replaced; frames stay, which are near enough."""
        if self.torque_n_mm is None or others is None or others.torque_n_mm is None:
            return self
        torque = self.torque_n_mm.copy()
        torque[rows] = others.torque_n_mm
        return self._replace(torque_n_mm=torque)


def load_of(state: State) -> Load:
    """Return what loads the arm where it is: gravity's torques (n, J) [N mm] and its frames.

    It is what the state was predicted with once both are in balance.
    """
    return Load(_gravity(state.structure, state.chain), known_frames(state.chain))


def evaluate_once(
    structure: Structure, values: FloatArray, targets: Targets, load: Load | None
) -> tuple[State, Load | None, FloatArray]:
    """Predict nest positions under a load that is nearly theirs: for searches, which come back anyway.

    Parameters
    ----------
    structure : Structure
    values : ndarray, shape (P,)
        Internal units.
    targets : Targets
        n of them.
    load : Load, optional
        Of the same targets at joint angles near by; without it, that of the arm whose springs are not wound.

    Returns
    -------
    state : State
    load : Load, optional
        Of that state; None where nothing yields, or torques are measured.
    imbalance : ndarray, shape (n,)
        By how much the torques of a row differ from those it was predicted with, of the largest torque [1].
    """
    prediction = _Prediction(structure, values, targets)
    if prediction.loaded and load is None:
        load = load_of(prediction.under(None))
    state = prediction.under(load)
    if not prediction.loaded:
        return state, None, np.zeros(len(targets))
    own = load_of(state)
    return state, own, _imbalance(own.torque_n_mm, state.torque_n_mm, len(targets))


def _imbalance(torque: FloatArray | None, before: FloatArray | None, n: int) -> FloatArray:
    if torque is None or before is None:
        return np.zeros(n)
    # An arm that hangs straight carries no torque at all, and is in balance.
    largest = np.abs(torque).max(initial=1e-300)
    return np.asarray(np.abs(torque - before).max(axis=1) / largest)


class _Prediction:
    """Targets that are predicted under one load after the other; what no load changes is worked out once."""

    def __init__(self, structure: Structure, values: FloatArray, targets: Targets) -> None:
        measured = targets.stops.torque_n_mm if structure.torques_measured else None
        self.loaded = measured is None and _is_loaded(structure)
        self._nominal = nominal_values(structure.robot, targets.stops.joints_rad)
        # Frames are worked out only where an effect asks for them: a fit without springs does not.
        unloaded = cache(partial(forward, self._nominal, structure.base_rotation, structure.base_origin_mm))
        self._targets, self._rows = targets, _rows(structure, targets, measured, unloaded)
        self._acting = ActiveEffects(structure, values, self._rows)

    def under(self, load: Load | None) -> State:
        """Return the state under a load; None: as measured, or of an arm whose springs are not wound."""
        rows = self._rows
        if load is not None:
            rows = rows._replace(torque_n_mm=load.torque_n_mm, frames=load.frames)
        return _evaluate_loaded(self._acting, self._targets, self._nominal, rows)


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


def _evaluate_loaded(acting: ActiveEffects, targets: Targets, nominal: LinkValues, rows: Rows) -> State:
    structure, values = acting.structure, acting.values
    told, moved = acting.under_load(rows)
    rotation, axes = base_axes(structure.base_rotation, _triple(moved, PortKind.BASE, 3))
    origin = structure.base_origin_mm + _triple(moved, PortKind.BASE, 0)
    tool_rotation, tool_axes = base_axes(structure.tool_rotation, _triple(moved, PortKind.TOOL_ROTATION, 0))
    # Base, tool and lengths of the instrument are the same in every row; bodies may move from row to row.
    motions = _motions(moved, len(targets))
    chain = forward(_displaced(nominal, moved), rotation, origin, motions)
    unscaled = chain.points(nest_centres(structure, moved)[targets.nest - 1])
    scale = float(moved.get(Port(PortKind.SCALE, 0), 0.0))
    instrument_motion = six_components(moved, PortKind.INSTRUMENT, 0, len(targets))
    return State(
        structure=structure,
        targets=targets,
        values=values,
        told=cache(told),
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

    Parameters
    ----------
    state : State
        At n targets.

    Returns
    -------
    Rows
        Torques [N mm] with what effects add to them; None where neither masses nor measured torques tell.
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
    """Return what six ports in a row are moved by.

    Parameters
    ----------
    moved : dict of Port to float or ndarray, shape (n,)
    kind : PortKind
    first : int
        Number of the first of the six.
    n : int

    Returns
    -------
    ndarray, shape (n, 6), or None
        Three shifts [mm], three turns RotX RotY RotZ [rad]; None where none of the ports is moved.
    """
    ports = [Port(kind, first + k) for k in range(6)]
    if not any(port in moved for port in ports):
        return None
    return np.stack([np.broadcast_to(moved.get(port, 0.0), n) for port in ports], axis=1)


def _seen(points: FloatArray, scale: float, instrument: FloatArray, motion: FloatArray | None) -> FloatArray:
    scaled: FloatArray = points + scale * (points - instrument)
    if motion is None:
        return scaled
    # Lengths first, as they are read from where the instrument stands; then what moves its frame.
    turn, _ = turned_axes(motion[:, 3:])
    seen: FloatArray = np.einsum("nij,nj->ni", turn, scaled) + motion[:, :3]
    return seen


def _triple(moved: dict[Port, FloatArray | float], kind: PortKind, first: int) -> FloatArray:
    return np.array([moved.get(Port(kind, first + k), 0.0) for k in range(3)], dtype=float)


def nest_centres(structure: Structure, moved: dict[Port, FloatArray | float]) -> FloatArray:
    """Return the tool nests with what moves them.

    Parameters
    ----------
    structure : Structure
        With K nests.
    moved : dict of Port to float

    Returns
    -------
    ndarray, shape (K, 3)
        [mm], flange frame.
    """
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
    # Joint by joint in memory, as the chain runs over them: a column of rows would be strided.
    by_joint = np.array(by_joint, order="C")
    for joint, shift in shifts.items():
        by_joint[joint] += shift
    return by_joint.T
