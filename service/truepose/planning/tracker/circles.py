"""Sessions of the single-axis circle test: one joint turned at a time, up and down, one nest in sight.

Angles are whole steps from 0, as far as limits, table and column allow and the same nest faces the tracker:
of all nests the one with the longest unbroken row of stops, of several such the one farthest from the axis.

All others stand at 0 where the nest is seen over the whole interval there. A reflector is seen within 29 deg
of where it faces, so that an axis across the line of sight leaves an arc of 58 deg at most. An axis that
points at the tracker leaves any arc, and where the other joints stand does not matter to a circle: of many
postures the one is taken in which the nest is seen longest.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from truepose.domain.arrays import BoolArray, FloatArray, IntArray
from truepose.domain.errors import ConfigurationError
from truepose.domain.session import PlannedStop, SessionPlan, Turn
from truepose.planning.workspace.bodies import bodies_in
from truepose.planning.workspace.candidates import cosines_in_sight, has_room, is_seen
from truepose.planning.workspace.path_clearance import Ways, touching
from truepose.planning.workspace.space import (
    WorkSpace,
    nest_places,
    nominal_chain,
    require_consistent,
    within,
)

_MOST_STOPS: Final = 5000  # two days and nights of measuring
_FEWEST: Final = 5  # angles; four determine a circle, and one may be lost
_SHORTEST_RAD: Final = float(np.radians(20.0))  # on shorter arcs the axis is as uncertain as joints err
_BESIDE_AXIS_MM: Final = 20.0  # nearer, a tracker's reading tells angles to less than 0.05 deg
_ROUNDING: Final = 1e-9  # rad, and of a step
_POSTURES: Final = 2000  # of which the best is taken; twice as many see a joint over few degrees more
_COARSE: Final = 31  # angles at which a posture is looked at first
_LOOKED_AT: Final = 20  # postures at every angle, and on the way there


def usual_turns(n_joints: int) -> tuple[Turn, ...]:
    """Return intervals and steps of Table 2.3 (thesis of A. Nubiola, 2014), as many as there are joints.

    Parameters
    ----------
    n_joints : int

    Returns
    -------
    tuple of Turn
        Six at most: of a seventh joint the table says nothing.
    """
    table = ((60, 5), (40, 1), (40, 1), (155, 5), (90, 5), (400, 1))
    return tuple(
        Turn(joint, -float(np.radians(reach)), float(np.radians(reach)), float(np.radians(step)))
        for joint, (reach, step) in enumerate(table[:n_joints], start=1)
    )


def plan_circles(space: WorkSpace, template: SessionPlan, turns: Sequence[Turn] = ()) -> SessionPlan:
    """Fill the stops of a template with sweeps of the joints, all others at rest.

    Parameters
    ----------
    space : WorkSpace
    template : SessionPlan
        Role, speeds and all else; no stop is approached from elsewhere, since the side is what is tested.
    turns : sequence of Turn
        By default `usual_turns`; of these a joint that shows no nest far enough is left out.

    Returns
    -------
    SessionPlan
        The same cell gets the same test.

    Raises
    ------
    ConfigurationError
        An interval is none, or the stops are too many. A joint that was asked for, or every joint, shows no
        nest over 20 deg and five angles.
    WorkSpaceError
        What is said of the cell contradicts itself.
    """
    require_consistent(space)
    wanted = turns or usual_turns(space.robot.n_joints)
    for turn in wanted:
        _require_possible(space, turn)
    sweeps = [_best_sweep(space, turn) for turn in wanted]
    kept = [sweep for sweep in sweeps if sweep.is_enough]
    lost = [sweep.joint for sweep in sweeps if not sweep.is_enough]
    if not kept or (turns and lost):
        raise ConfigurationError(_refused(lost))
    at_rest = tuple(0.0 for _ in space.robot.joints)
    stops = tuple(_stops(kept, at_rest if within(space.motion_limits, np.array([at_rest]))[0] else None))
    if len(stops) > _MOST_STOPS:
        raise ConfigurationError(
            f"The plan has {len(stops)} configurations; at most {_MOST_STOPS} are allowed. Use larger steps."
        )
    return replace(template, stops=stops, approach_offset_rad=None)


@dataclass(frozen=True, slots=True)
class _Sweep:
    joint: int
    joints_rad: FloatArray  # (m, J) upwards
    nest: int

    @property
    def is_enough(self) -> bool:
        """Whether a circle can be fitted to it."""
        turned = self.joints_rad[:, self.joint - 1]
        return len(turned) >= _FEWEST and bool(np.ptp(turned) >= _SHORTEST_RAD - _ROUNDING)


def _require_possible(space: WorkSpace, turn: Turn) -> None:
    if not 1 <= turn.joint <= space.robot.n_joints:
        raise ConfigurationError(
            f"There is no joint {turn.joint}; {space.robot.name} has {space.robot.n_joints} joints."
        )
    if not (turn.lower_rad < turn.upper_rad and turn.step_rad > 0.0):
        raise ConfigurationError(
            f"For joint {turn.joint}, the end of the range must be above its start and the step above 0 deg."
        )


def _best_sweep(space: WorkSpace, turn: Turn) -> _Sweep:
    angles, at_rest = _angles(turn), np.zeros(space.robot.n_joints)
    if not len(angles):  # of a turn that is shorter than its step
        return _Sweep(turn.joint, np.zeros((0, space.robot.n_joints)), 1)
    best = _sweep(space, turn, at_rest)
    # All others at 0 is the test of the thesis: another posture is looked for only where it shows more.
    if len(best.joints_rad) == len(angles):
        return best
    sweeps = [_sweep(space, turn, posture) for posture in _promising(space, turn)]
    longer = [sweep for sweep in sweeps if len(sweep.joints_rad) > len(best.joints_rad)]
    ranked = sorted(longer, key=lambda sweep: -len(sweep.joints_rad))
    begins = np.array([sweep.joints_rad[0] for sweep in ranked]).reshape(-1, at_rest.size)
    # From rest to its begin the arm goes by one joint motion that nobody else plans.
    ways = Ways((), np.broadcast_to(at_rest, begins.shape), begins)
    blocked = set(touching(bodies_in(space), ways).tolist())
    return next((sweep for row, sweep in enumerate(ranked) if row not in blocked), best)


def _promising(space: WorkSpace, turn: Turn) -> FloatArray:
    """Return the postures in which some nest is seen at most of a few angles in a row, best first."""
    low, high = np.array([(limit.lower_rad, limit.upper_rad) for limit in space.ranges]).T
    drawn = np.random.default_rng(0).random((_POSTURES, low.size))  # the same test gets the same plan
    postures = low + (high - low) * drawn
    angles = _angles(turn)
    few = angles[np.unique(np.linspace(0, len(angles) - 1, _COARSE).round().astype(np.int64))]
    _, seen, _ = _look(space, turn, postures, few)
    row, longest = np.zeros(seen.shape[:2], dtype=np.int64), np.zeros(seen.shape[:2], dtype=np.int64)
    for at_angle in np.moveaxis(seen, 2, 0):
        row = np.where(at_angle, row + 1, 0)
        longest = np.maximum(longest, row)
    most = longest.max(axis=0)
    best = np.argsort(-most, kind="stable")[:_LOOKED_AT]
    return np.asarray(postures[best[most[best] > 1]])


def _sweep(space: WorkSpace, turn: Turn, posture_rad: FloatArray) -> _Sweep:
    joints, seen, radius = _look(space, turn, posture_rad[None], _angles(turn))
    rows = [_longest(row) for row in seen[:, 0]]
    best = max(range(len(rows)), key=lambda nest: (len(rows[nest]), float(radius[nest].mean())))
    return _Sweep(turn.joint, joints[0, rows[best]], best + 1)


def _look(
    space: WorkSpace, turn: Turn, postures_rad: FloatArray, angles_rad: FloatArray
) -> tuple[FloatArray, BoolArray, FloatArray]:
    """Turn a joint through angles (m,), the others as in postures (p, J).

    The distance from the axis is |(P - O) x z| with O on the axis and z along it. Returns the joints (p, m,
    J), which of K nests are seen off the axis, and how far off [mm], both (K, p, m).
    """
    p, m, axis = len(postures_rad), len(angles_rad), turn.joint - 1
    joints = np.repeat(postures_rad, m, axis=0)
    joints[:, axis] = np.tile(angles_rad, p)
    chain = nominal_chain(space, joints)
    away = nest_places(space, chain) - chain.origin[axis]
    radius = np.linalg.norm(np.cross(away, chain.z[axis]), axis=2)
    # Beams past arm and volumes are looked at only where the arm has room.
    room = has_room(space, joints, chain)
    seen = room & is_seen(space, cosines_in_sight(space, chain, room))
    shown, shape = seen & (radius >= _BESIDE_AXIS_MM), (len(space.nests), p, m)
    return joints.reshape(p, m, -1), shown.reshape(shape), radius.reshape(shape)


def _angles(turn: Turn) -> FloatArray:
    """Return whole steps from 0 within the interval, ascending, shape (m,) [rad]."""
    first = np.ceil(turn.lower_rad / turn.step_rad - _ROUNDING)
    last = np.floor(turn.upper_rad / turn.step_rad + _ROUNDING)
    return np.asarray(np.arange(first, last + 1.0) * turn.step_rad)


def _longest(seen: BoolArray) -> IntArray:
    """Return the longest unbroken row of angles at which a nest is seen (m,): indices."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], seen, [False]]).astype(np.int8)))
    starts, ends = edges[::2], edges[1::2]
    if not len(starts):
        return np.zeros(0, dtype=np.int64)
    longest = int(np.argmax(ends - starts))
    return np.arange(starts[longest], ends[longest])


def _stops(sweeps: Sequence[_Sweep], at_rest: tuple[float, ...] | None) -> Iterator[PlannedStop]:
    """Yield the stops; between two sweeps the arm goes to rest, from where all ways were found clear."""
    config = 0
    for sweep in sweeps:
        begin_rad = at_rest
        # Up and down again, the turning point once: what differs between the two sides of an angle is
        # the play of the gear.
        for joints in (*sweep.joints_rad, *sweep.joints_rad[-2::-1]):
            config += 1
            yield PlannedStop(config, tuple(joints.tolist()), sweep.nest, begin_rad=begin_rad)
            begin_rad = None


def _refused(joints: Sequence[int]) -> str:
    listed = ", ".join(map(str, joints))
    return (
        f"For joint {listed}, the tracker sees no nest over at least 20 deg and {_FEWEST} consecutive angles "
        "at any position of the other joints within limits and clear of the table. Use a smaller step, or a "
        "nest that stays visible longer."
    )
